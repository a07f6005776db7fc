"""The radiometer against closed forms: modulation transfer, noise of a given size, photons."""

import numpy as np
import pytest
from scipy import integrate, interpolate, stats

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.providers import Grid, SensorBand, SensorInputs

PLANCK, LIGHT, BOLTZMANN = 6.62607015e-34, 299792458.0, 1.380649e-23
BOX = {"mid": (3.0, 5.0), "long": (8.0, 14.0)}


def sensor(rows, columns, bands=("mid",), seed=1, speed=0.0, base=None, **parameters):
    inputs = SensorInputs(
        bands=tuple(SensorBand(name, np.array(BOX[name]), np.ones(2)) for name in bands),
        grid=Grid(rows, columns, 20.0),
        platform_speed_m_s=speed,
        frame_interval_s=1.0,
        seed=seed,
        catalog=Catalog(base=base),
    )
    return Radiometer(inputs, RadiometerParameters(**parameters))


def transfer(provider, size, along_y, along_x):
    """Amplitude left of a wave with these frequencies (cycles per pixel), fitted away from the edges."""
    y, x = np.mgrid[:size, :size]
    phase = 2.0 * np.pi * (along_y * y + along_x * x) + 0.4
    measured = provider.measure((3.0 + np.cos(phase))[None], 0, 0.0).radiance[0]
    inner = slice(size // 4, 3 * size // 4)
    basis = np.stack([np.cos(phase), np.sin(phase), np.ones_like(phase)])[:, inner, inner].reshape(3, -1)
    cosine, sine, mean = np.linalg.lstsq(basis.T, measured[inner, inner].ravel(), rcond=None)[0]
    assert mean == pytest.approx(3.0, rel=1e-3)
    assert abs(sine) < 5e-3  # nothing is displaced
    return cosine


FREQUENCIES = [(0.0, 0.05), (0.11, 0.0), (0.13, 0.21), (0.31, 0.08), (0.0, 0.43)]


@pytest.mark.parametrize(("along_y", "along_x"), FREQUENCIES)
def test_gaussian_spread_has_the_transfer_of_a_gaussian(along_y, along_x):
    sigma = 0.6
    found = transfer(sensor(160, 160, psf="gaussian", psf_sigma=sigma), 160, along_y, along_x)
    # the Fourier transform of the spread, integrated in space
    axis = np.linspace(-12.0, 12.0, 4801) * sigma
    spread = stats.norm.pdf(axis, scale=sigma)
    closed = np.prod([np.trapezoid(spread * np.cos(2.0 * np.pi * f * axis), axis) for f in (along_y, along_x)])
    assert found == pytest.approx(closed, rel=0.01)


def overlap_of_circles(distance):
    """Share of a circle of diameter 1 that one displaced by ``distance`` covers, by quadrature."""
    half = 0.5 * distance
    area = 4.0 * integrate.quad(lambda x: np.sqrt(max(0.25 - x * x, 0.0)), half, 0.5)[0]
    return area / (np.pi / 4.0)


@pytest.mark.parametrize(("along_y", "along_x"), FREQUENCIES)
def test_a_round_aperture_has_the_transfer_of_overlapping_circles(along_y, along_x):
    diameter, angle = 0.1, 3.2e-5
    provider = sensor(160, 160, psf="airy", aperture_diameter=diameter, pixel_angle=angle)
    found = transfer(provider, 160, along_y, along_x)
    cycles_per_radian = np.hypot(along_y, along_x) / angle
    assert found == pytest.approx(overlap_of_circles(4e-6 * cycles_per_radian / diameter), rel=0.01)


def test_an_aperture_passes_nothing_beyond_its_cut_off():
    provider = sensor(160, 160, psf="airy", aperture_diameter=0.05, pixel_angle=2e-5)  # 0.25 cycles per pixel
    assert abs(transfer(provider, 160, 0.0, 0.3)) < 1e-3


@pytest.mark.parametrize("frequency", [0.02, 0.07, 0.15, 0.3])
def test_smear_has_the_transfer_of_a_box(frequency):
    provider = sensor(160, 160, speed=-1000.0, integration_time=0.05)  # 2.5 pixels
    found = transfer(provider, 160, 0.0, frequency)
    box = np.linspace(-1.25, 1.25, 20001)
    assert found == pytest.approx(np.mean(np.cos(2.0 * np.pi * frequency * box)), abs=2e-3)
    assert transfer(provider, 160, frequency, 0.0) == pytest.approx(1.0, abs=1e-3)


def kelvin_of(radiance, band):
    """Temperature of black bodies of these radiances, from Planck's law over wavelength by quadrature."""
    low, high = BOX[band]
    wavelength = np.linspace(low, high, 4001) * 1e-6
    temperature = np.linspace(280.0, 320.0, 401)
    exponent = np.exp(PLANCK * LIGHT / (wavelength * BOLTZMANN * temperature[:, None]))
    planck = 2.0 * PLANCK * LIGHT**2 / wavelength**5 / (exponent - 1.0)
    table = np.trapezoid(planck, wavelength, axis=1)
    return interpolate.CubicSpline(table, temperature)(radiance), np.interp(300.0, temperature, table)


@pytest.mark.parametrize("band", sorted(BOX))
def test_a_flat_scene_is_as_noisy_in_kelvin_as_asked(band):
    provider = sensor(512, 512, (band,), noise="nedt", nedt={band: 0.08}, nedt_temperature=300.0)
    _, flat = kelvin_of(np.array([1.0]), band)
    measured = provider.measure(np.full((1, 512, 512), flat), 0, 0.0).radiance[0]
    kelvin, _ = kelvin_of(measured, band)
    assert kelvin.std() == pytest.approx(0.08, rel=0.01)
    assert kelvin.mean() == pytest.approx(300.0, abs=1e-3)
    # neighbours have nothing in common
    assert abs(np.corrcoef(kelvin[:, 1:].ravel(), kelvin[:, :-1].ravel())[0, 1]) < 0.01


def test_a_flat_scene_is_as_noisy_in_radiance_as_asked():
    measured = sensor(512, 512, noise="ner", ner=0.003).measure(np.full((1, 512, 512), 0.7), 0, 0.0).radiance
    assert measured.std() == pytest.approx(0.003, rel=0.01)
    assert measured.mean() == pytest.approx(0.7, abs=5 * 0.003 / 512)
    assert stats.kurtosis(measured.ravel()) == pytest.approx(0.0, abs=0.05)


def test_photons_are_those_of_the_radiometric_equation():
    provider = sensor(4, 4, aperture_diameter=0.1, pixel_angle=5e-5, transmission=0.8, photon_temperature=290.0)
    rate = provider.measure(np.full((1, 4, 4), 1.5), 0, 0.0).photon_rate
    wavelength = np.linspace(3.0, 5.0, 20001) * 1e-6
    planck = wavelength**-5 / (np.exp(PLANCK * LIGHT / (wavelength * BOLTZMANN * 290.0)) - 1.0)
    mean = np.trapezoid(planck * wavelength, wavelength) / np.trapezoid(planck, wavelength)
    expected = 1.5 * (np.pi * 0.05**2) * 5e-5**2 * 0.8 * mean / (PLANCK * LIGHT)
    np.testing.assert_allclose(rate, expected, rtol=1e-6)
    assert provider.worked_out["bands"]["mid"]["photon_wavelength_um"] == pytest.approx(mean * 1e6, rel=1e-6)
