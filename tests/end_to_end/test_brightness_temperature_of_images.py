"""Images of brightness temperature become clouds that have this temperature in the scene."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.ndimage import gaussian_filter

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import ScenarioError

SIDE = 48
PRINTED = {"radiance": {"model": "as-printed"}, "sea": {"model": "cox-munk"}, "optics": {"provider": "mie"}}


def _image(folder, low, high, units="K"):
    """Write a smooth random image with values from low to high, rows southward."""
    field = gaussian_filter(np.random.default_rng(3).normal(size=(SIDE, SIDE)), 3.0, mode="wrap")
    kelvin = low + (high - low) * (field - field.min()) / np.ptp(field)
    variable = xr.DataArray(kelvin, dims=("y", "x"), attrs={"units": units})
    xr.Dataset({"brightness_temperature" if units == "K" else "counts": variable}).to_netcdf(folder / "image.nc")
    return kelvin


def _scene(folder, cloud_type="paper-stratus", **layer):
    return {
        "time": "2024-04-20T22:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "atmosphere": {"profile": "us-standard-1976"},
        "image": {"rows": SIDE, "columns": SIDE, "pixel_size": 1000.0},
        "frames": {"count": 1},
        "bands": ["lwir-10.8"],
        "output": {"variables": ["brightness_temperature", "cloud_layer_thickness"], "certificate": 0},
        "clouds": {
            "type": cloud_type,
            "generator": "imagery",
            "parameters": {"image": str(folder / "image.nc"), "method": "temperature"},
            **layer,
        },
        # The law is the same for all models: cirrus has the default ones.
        **({} if cloud_type == "cirrus" else PRINTED),
    }


def _inversion(folder, cloud_type, **layer):
    scene = _scene(folder, cloud_type, **layer)
    scene["clouds"] |= {"generator": "fractal", "parameters": {}}
    return make_plan(Scenario.from_dict(scene)).assembly.built["clouds"].inputs.inversion


@pytest.mark.parametrize(
    ("cloud_type", "limits_um"),
    [("paper-stratus", None), ("cirrus", None), ("cirrus", [3.48, 4.36]), ("cirrus", [11.8, 12.2])],
)
def test_scene_has_the_brightness_temperature_of_its_image(tmp_path, cloud_type, limits_um):
    """In the image's band, by night: 10.8 um, SEVIRI's at 3.9 um, which reaches into the band of CO2, or 12 um."""
    inversion = _inversion(tmp_path, cloud_type, thickness_min=1.0)
    scene = _scene(tmp_path, cloud_type, thickness_min=1.0)
    if limits_um is not None:
        inversion, scene["bands"] = inversion.in_band(tuple(limits_um)), [limits_um]
        scene["clouds"]["parameters"]["limits_um"] = limits_um
    kelvin = _image(tmp_path, inversion.coldest_K + 0.5, inversion.clear_K + 1.0)
    cube = simulate(Scenario.from_dict(scene))
    seen = cube.brightness_temperature.values[0, 0, ::-1].astype(np.float64)
    # The scene's own clear sky where the image is warmer.
    wanted = np.minimum(kelvin, inversion.clear_K)
    assert np.max(np.abs(seen - wanted)) < 0.15
    assert np.mean(np.abs(seen - wanted)) < 0.03
    # Thin cloud is kept: no pixel that is .5 K colder than clear sky is left out.
    assert not np.any(cube.cloud_layer_thickness.values[0, 0, ::-1][kelvin < inversion.clear_K - 0.5] == 0.0)


def test_shares_that_are_lost_are_in_the_plan(tmp_path):
    inversion = _inversion(tmp_path, "paper-stratus")
    _image(tmp_path, inversion.coldest_K - 5.0, inversion.clear_K)
    plan = make_plan(Scenario.from_dict(_scene(tmp_path)))
    (note,) = [each for each in plan.assembly.generators[0].declares.notes if "too thin for the layer" in each]
    assert "0.00% are 2 K warmer" in note
    assert " 0.00% are 2 K colder than its thickest" not in note


def test_image_without_kelvin_is_refused_by_name(tmp_path):
    _image(tmp_path, 0.0, 255.0, units="1")
    scene = _scene(tmp_path)
    with pytest.raises(ScenarioError, match=r"clouds\.parameters\.method: 'temperature' given .* kelvin"):
        make_plan(Scenario.from_dict(scene))
    scene["clouds"]["parameters"] |= {"method": "auto", "limits_um": [3.8, 4.0]}
    with pytest.raises(ScenarioError, match=r"clouds\.parameters\.limits_um: given for an image without kelvin"):
        make_plan(Scenario.from_dict(scene))


@pytest.mark.parametrize(
    ("band_um", "parameters", "message"),
    [
        (3.89, {}, r"limits_um: none given, and the image's band is at 3\.89 um.* closest is about \[3\.79, 3\.99\]"),
        (3.89, {"limits_um": [4.0, 3.8]}, r"limits_um: \[4, 3\.8\] given.* closest is \[3\.8, 4\]"),
        (3.89, {"limits_um": [3.8, 4.0], "method": "otsu"}, "limits_um: has no meaning with the method 'otsu'"),
        (11.2, {}, None),
    ],
)
def test_an_image_of_another_band_needs_its_limits(tmp_path, band_um, parameters, message):
    _image(tmp_path, 270.0, 285.0)
    with xr.load_dataset(tmp_path / "image.nc") as image:
        image.assign(band_wavelength=band_um).to_netcdf(tmp_path / "image.nc")
    scene = _scene(tmp_path)
    scene["clouds"]["parameters"] |= {"variable": "brightness_temperature", **parameters}
    if message is None:
        make_plan(Scenario.from_dict(scene))
        return
    with pytest.raises(ScenarioError, match=message):
        make_plan(Scenario.from_dict(scene))


def test_clouds_that_are_not_colder_than_clear_sky_are_refused(tmp_path):
    _image(tmp_path, 280.0, 290.0)
    with pytest.raises(ScenarioError, match="are not colder than clear sky"):
        make_plan(Scenario.from_dict(_scene(tmp_path, temperature=320.0)))


def test_thickness_falls_with_temperature_and_stays_in_the_layer(tmp_path):
    inversion = _inversion(tmp_path, "cumulus")
    kelvin = np.array([0.0, 100.0, *np.linspace(inversion.coldest_K - 1.0, inversion.clear_K + 1.0, 9999), 1e9, np.nan])
    thickness = inversion.thickness_m(kelvin)
    assert thickness.dtype == np.float32
    assert np.all(np.diff(thickness[:-1]) <= 0.0)
    assert thickness[0] == thickness.max() <= 2934.0
    assert np.all(thickness[-2:] == 0.0)
    assert thickness[thickness > 0.0].min() == 10.0
