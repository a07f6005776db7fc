"""A whole run of Pyxel over eight frames: optics, photon noise, quantum efficiency, ADC."""

import re
import shutil

import netCDF4
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from hcss_pyxel.cli import cli
from scipy import constants

# The example's instrument, written out again: what it should be, not what the code says.
PITCH_M, F_NUMBER, TRANSMISSION, QUANTUM_EFFICIENCY = 15e-6, 2.0, 0.8, 0.7
ELECTRONS_PER_STEP = 7e6 / (2**14 - 1)


@pytest.fixture(scope="module")
def ran(cube, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "example"
    made = CliRunner().invoke(cli, ["example", str(cube), "--band", "mwir", "-o", str(folder)])
    assert made.exit_code == 0, made.output
    pipeline = folder / "pipeline.yaml"
    text = pipeline.read_text()
    pipeline.write_text(re.sub(r"wavelength_um: [0-9.]+", "wavelength_um: 4.4", text))
    done = CliRunner().invoke(cli, ["run", str(pipeline)])
    assert done.exit_code == 0, done.output
    with xr.open_dataset(folder / "result.nc") as result:
        return result.load(), pipeline


@pytest.fixture(scope="module")
def expected_electrons(cube, ran):
    """By hand from the raw cube: L x aperture x solid angle x transmission x time x QE x lambda / (h c)."""
    line = next(line for line in ran[1].read_text().splitlines() if "integration_time:" in line)
    seconds = float(line.split(":")[1].split("#")[0])
    with netCDF4.Dataset(cube) as file:
        radiance = file["radiance"][:, list(file["band_name"][:]).index("mwir")].astype(float).data
    focal_length = 1.0
    aperture = np.pi * (focal_length / F_NUMBER / 2.0) ** 2
    solid_angle = (PITCH_M / focal_length) ** 2
    power = radiance * aperture * solid_angle * TRANSMISSION
    return power * seconds * QUANTUM_EFFICIENCY * 4.4e-6 / (constants.h * constants.c)


def electrons(ran):
    # the ADC cuts fractions off: half a step on average
    return (ran[0]["image"].to_numpy().astype(float) + 0.5) * ELECTRONS_PER_STEP


def test_the_mean_signal_is_our_radiance_through_the_radiometric_equation(ran, expected_electrons):
    found, wanted = electrons(ran), expected_electrons
    assert found.shape == (8, 96, 80)
    assert found.mean() == pytest.approx(wanted.mean(), rel=1e-3)
    # of each frame, too, apart from what optics carry over the edges of the image
    np.testing.assert_allclose(found.mean(axis=(1, 2)), wanted.mean(axis=(1, 2)), rtol=1e-3)


def test_frames_follow_our_clock(ran, expected_electrons, cube):
    with netCDF4.Dataset(cube) as file:
        np.testing.assert_allclose(ran[0]["time"], file["time"][:] + 1.0)
    found, wanted = electrons(ran), expected_electrons
    away = np.array([[np.std(one - other) for other in wanted] for one in found])
    assert np.argmin(away, axis=1).tolist() == list(range(8))
    # no other frame comes near
    assert np.all(np.sort(away, axis=1)[:, 1] > 2.0 * np.diag(away))


def test_noise_is_that_of_the_electrons(ran, expected_electrons):
    """Between the pixels of a frame, next to those of the same scene without noise: Poisson's."""
    from astropy.convolution import convolve_fft

    kernel = np.load(ran[1].with_name("psf.npy"))
    found, ratios = electrons(ran), []
    for one, scene in zip(found, expected_electrons, strict=True):
        blurred = convolve_fft(scene, kernel, boundary="fill", fill_value=scene.mean())
        inner = np.s_[8:-8, 8:-8]
        excess = (one - blurred)[inner]
        rounding = ELECTRONS_PER_STEP**2 / 12
        ratios.append((excess.var() - rounding) / blurred[inner].mean())
    # 8 x 80 x 64 pixels: the variance is known to 0.7 %
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03)


def test_the_brightest_pixel_does_not_saturate(ran):
    assert 0.5 * 2**14 < ran[0]["image"].max() < 0.8 * 2**14


def test_the_wavelength_of_an_example_is_that_of_the_scenes_own_spectra(cube, tmp_path):
    """Next to photons integrated here over the spectrum of each column of the same radiance."""
    from hcss_pyxel.mean_wavelength import mean_wavelengths_of

    made = CliRunner().invoke(cli, ["example", str(cube), "--band", "lwir", "-o", str(tmp_path / "e")])
    told = float(re.search(r"wavelength_um: ([0-9.]+), by", made.output).group(1))
    known = next(mean for mean in mean_wavelengths_of(cube) if mean.band == "lwir")
    assert known.wavelength_um.min() < told < known.wavelength_um.max()
    assert f"wavelength_um: {told}" in (tmp_path / "e" / "pipeline.yaml").read_text()
    listed = CliRunner().invoke(cli, ["wavelength", str(cube)]).output
    line = next(line.split() for line in listed.splitlines() if line.startswith("lwir"))
    assert line[1] == f"{known.wavelength_um[0]:.4f}"
    assert line[2] == f"{11.0 / known.wavelength_um[0] - 1:+.1%}"


def test_an_example_of_a_scene_that_is_not_at_hand_says_so(cube, tmp_path):
    shutil.copy(cube, tmp_path / "c.nc")
    with netCDF4.Dataset(tmp_path / "c.nc", "a") as file:
        file.delncattr("hcss_scenario")
    made = CliRunner().invoke(cli, ["example", str(tmp_path / "c.nc"), "-o", str(tmp_path / "e")])
    assert made.exit_code == 0, made.output
    assert "black-body, because the scene cannot be computed again" in made.output
    assert "wavelength_um: black-body" in (tmp_path / "e" / "pipeline.yaml").read_text()


def test_an_example_is_not_overwritten(cube, ran):
    from hcss_twin.providers import CubeError

    again = CliRunner().invoke(cli, ["example", str(cube), "-o", str(ran[1].parent)])
    assert isinstance(again.exception, CubeError)
    assert "exists; give another folder" in str(again.exception)
    once_more = CliRunner().invoke(cli, ["run", str(ran[1])])
    assert once_more.exit_code == 1
    assert "--force" in once_more.output
