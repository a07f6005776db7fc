"""The loader in a detector of Pyxel, one step at a time."""

import shutil

import netCDF4
import numpy as np
import pytest
from hcss_pyxel import load_cube
from scipy import constants

from hcss_twin.providers import CubeError

OPTICS = {"f_number": 2.5}


def radiance(cube, band, frame):
    with netCDF4.Dataset(cube) as file:
        return file["radiance"][frame, list(file["band_name"][:]).index(band)].astype(float).data


def expected(value, wavelength_um=4.0, seconds=1.0, transmission=1.0, f_number=2.5):
    """L A Omega t lambda / (h c), with the aperture of a lens of 1 m focal length."""
    aperture = np.pi / 4 * (1.0 / f_number) ** 2
    per_photon = constants.h * constants.c / (wavelength_um * 1e-6)
    return value * aperture * (15e-6 * 20e-6) * transmission * seconds / per_photon


def test_a_pixel_gets_the_photons_of_the_radiometric_equation(cube, detector):
    made = detector(time=3.0)
    load_cube(made, cube, "mwir", **OPTICS, transmission=0.7)
    np.testing.assert_allclose(made.photon.array_2d, expected(radiance(cube, "mwir", 2), transmission=0.7), rtol=1e-6)


def test_an_aperture_and_its_focal_length_are_an_f_number(cube, detector):
    one, other = detector(), detector()
    load_cube(one, cube, "mwir", f_number=2.5)
    load_cube(other, cube, "mwir", aperture_diameter=0.1, focal_length=0.25)
    np.testing.assert_allclose(one.photon.array_2d, other.photon.array_2d, rtol=1e-12)


def test_each_step_sees_its_frame(cube, detector):
    for step in range(8):
        made = detector(time=step + 1.0)
        load_cube(made, cube, "lwir", **OPTICS)
        np.testing.assert_allclose(
            made.photon.array_2d, expected(radiance(cube, "lwir", step), wavelength_um=11.0), rtol=1e-6
        )


def test_a_short_exposure_ends_with_the_step(cube, detector):
    made = detector(time=2.5, step=2.5)
    load_cube(made, cube, "mwir", **OPTICS, integration_time=0.75)
    # from 1.75 to 2.5 s: a quarter of a second of frame 1, half a second of frame 2
    frames = (radiance(cube, "mwir", 1) * 0.25 + radiance(cube, "mwir", 2) * 0.5) / 0.75
    np.testing.assert_allclose(made.photon.array_2d, expected(frames, seconds=0.75), rtol=1e-6)


def test_between_frames_radiance_goes_straight_if_asked_for(cube, detector):
    made = detector(time=2.5, step=0.5)
    load_cube(made, cube, "mwir", **OPTICS, frames="interpolate")
    frames = radiance(cube, "mwir", 2) * 0.75 + radiance(cube, "mwir", 3) * 0.25
    np.testing.assert_allclose(made.photon.array_2d, expected(frames, seconds=0.5), rtol=1e-6)


def test_an_offset_moves_the_clock(cube, detector):
    one, other = detector(time=5.0), detector(time=2.0)
    load_cube(one, cube, "mwir", **OPTICS)
    load_cube(other, cube, "mwir", **OPTICS, time_offset=3.0)
    np.testing.assert_array_equal(one.photon.array_2d, other.photon.array_2d)


def test_a_window_is_that_part_of_the_cube(cube, detector):
    made = detector(rows=10, columns=20)
    load_cube(made, cube, "mwir", **OPTICS, window=[86, 60])
    part = radiance(cube, "mwir", 0)[86:, 60:]
    np.testing.assert_allclose(made.photon.array_2d, expected(part), rtol=1e-6)


def test_photons_of_other_models_stay(cube, detector):
    made = detector()
    made.photon.array = np.full((96, 80), 7.0)
    load_cube(made, cube, "mwir", **OPTICS)
    alone = detector()
    load_cube(alone, cube, "mwir", **OPTICS)
    np.testing.assert_allclose(made.photon.array_2d, alone.photon.array_2d + 7.0, rtol=1e-12)


def test_the_overscan_of_a_ccd_is_dark(cube, detector):
    from pyxel.detectors import CCDGeometry
    from pyxel.detectors.ccd.ccd_geometry import CCDRegions

    geometry = CCDGeometry(
        row=CCDRegions(image_row=96, overscan_row=4), col=80, pixel_vert_size=15.0, pixel_horz_size=20.0
    )
    made = detector(geometry=geometry)
    load_cube(made, cube, "mwir", **OPTICS)
    np.testing.assert_allclose(made.photon.array_2d[:96], expected(radiance(cube, "mwir", 0)), rtol=1e-6)
    assert not made.photon.array_2d[96:].any()


def test_a_longer_mean_wavelength_is_more_photons(cube, detector):
    counts = {}
    for wavelength in ("central", 4.4, "black-body"):
        made = detector()
        load_cube(made, cube, "mwir", **OPTICS, wavelength_um=wavelength)
        counts[wavelength] = made.photon.array_2d.mean()
    assert counts[4.4] == pytest.approx(counts["central"] * 1.1, rel=1e-9)
    # a black body of 290 K in 3-5 um: Planck's law, mean wavelength 4.5 um
    assert counts["black-body"] == pytest.approx(counts["central"] * 4.5 / 4.0, rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"band": None}, "band: the cube has several; allowed: lwir, mwir"),
        ({"band": "mvir"}, "band: the cube has no 'mvir'; allowed: lwir, mwir; closest is 'mwir'"),
        ({"f_number": None}, "f_number: give either it, or both"),
        ({"aperture_diameter": 0.1}, "f_number: give either it, or both"),
        ({"f_number": None, "aperture_diameter": 0.1}, "focal_length: missing"),
        ({"f_number": 0.0}, "f_number: 0; allowed: above 0"),
        ({"f_number": "2"}, "f_number: '2'; a finite number is needed"),
        ({"transmission": 70.0}, "transmission: 70; allowed: above 0, at most 1"),
        ({"frames": "nearest"}, "frames: 'nearest'; allowed: hold, interpolate"),
        ({"integration_time": 2.0}, "integration_time: 2 s; allowed: above 0, at most the step of the readout, 1 s"),
        ({"time_offset": 8.0}, "exposure from 8 to 9 s .*: the cube covers 0 to 8 s"),
        ({"window": [0]}, r"window: \[0\]; two whole numbers"),
        ({"window": [1, 0]}, "window: row 1 for 96 rows of the detector, 96 of the cube; allowed: 0 to 0"),
        ({"wavelength_um": "centre"}, "wavelength_um: 'centre'; .*closest is 'central'"),
        ({"wavelength_um": 4000.0}, "wavelength_um: 4000; the band lies between 3 and 5 um"),
        ({"variable": "cloud_mask"}, "variable: 'cloud_mask' is no band radiance"),
    ],
)
def test_what_does_not_fit_is_named_with_what_is_allowed(cube, detector, arguments, message):
    made = detector()
    with pytest.raises(ValueError, match=message):
        load_cube(made, cube, **{"band": "mwir", **OPTICS, **arguments})
    assert made.photon.ndim == 0


def test_a_detector_of_another_size_is_told_both_sizes(cube, detector):
    with pytest.raises(ValueError, match=r"the detector has 80 x 96 pixels .*, the cube 96 x 80"):
        load_cube(detector(rows=80, columns=96), cube, "mwir", **OPTICS)


def test_what_is_no_cube_is_refused(detector, tmp_path):
    with pytest.raises(CubeError, match="there is no such file"):
        load_cube(detector(), tmp_path / "none.nc", "mwir", **OPTICS)


def test_radiance_that_is_missing_is_not_turned_into_photons(cube, detector, tmp_path):
    shutil.copy(cube, tmp_path / "c.nc")
    with netCDF4.Dataset(tmp_path / "c.nc", "a") as file:
        file["radiance"][0, 0, 0, 0] = np.nan
    with pytest.raises(ValueError, match="radiance: 1 values are not finite"):
        load_cube(detector(), tmp_path / "c.nc", "mwir", **OPTICS)
