"""Clouds with tops of their own on slant paths: against rays that are followed metre by metre."""

from functools import lru_cache
from typing import ClassVar

import numpy as np
import pytest
from cheap import CHEAP
from installed_providers import install

from hcss_twin import Scenario, simulate
from hcss_twin.providers import CloudDeclaration
from hcss_twin.providers.registry import ProviderSpec, hookimpl

SIZE, PIXEL_M = 48, 100.0
RANGE = 1500.0, 4000.0
SCENE = {
    "time": "2024-04-20T15:30:00+10:00",
    "place": {"latitude": 20.0, "longitude": 150.0},
    "image": {"rows": SIZE, "columns": SIZE, "pixel_size": PIXEL_M},
    "frames": {"count": 1},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "accuracy": 1e-2,
    "atmosphere": {"profile": "us-standard-1976"},
    "sea": {"temperature": 291.4, "wind_speed": 7.0, "temperature_texture": 0.0},
    "clouds": {
        "type": "stratus", "base": 1000.0, "top": 2500.0, "anchor": "top", "thickness_min": 5.0,
        "coverage_mode": "field", "generator": "towers",
    },
    "output": {
        "variables": ["radiance", "cloud_mask", "cloud_thickness", "cloud_top_altitude", "shadow_mask"],
        "certificate": 16,
    },
}  # fmt: skip


def towers(y, x):
    """Thickness and top of blocks of 6 x 6 points, of which two in three are clear."""
    up, across = np.floor_divide(y, 6), np.floor_divide(x, 6)
    cloudy = (up + 2 * across) % 3 == 0
    thickness = np.where(cloudy, 120.0 + 300.0 * ((up * 5 + across * 3) % 4), 0.0)
    return thickness, RANGE[0] + 500.0 * ((up * 2 + across) % 6)


class Towers:
    declares = CloudDeclaration()
    image_coverage = 1.0 / 3.0
    cloud_top_range_m = RANGE
    expected_failures: ClassVar = {"frozen_field_only_translates": "the cloud stands still in the image"}

    def __init__(self, inputs, parameters):
        self.margin = (inputs.grid.rows - SIZE) // 2, (inputs.grid.columns - SIZE) // 2

    def _at(self, rows, columns):
        y, x = np.mgrid[rows, columns]
        return [values.astype(np.float32) for values in towers(y - self.margin[0], x - self.margin[1])]

    def thickness_m(self, time_s, rows, columns):
        return self._at(rows, columns)[0]

    def thickness_around_m(self, time_s, rows, columns, summary):
        return self._at(rows, columns)[0]

    def cloud_top_m(self, time_s, rows, columns):
        return self._at(rows, columns)[1]


class Sheet(Towers):
    """Thin clouds at nearly one height."""

    cloud_top_range_m = 1999.0, 2001.0

    def _at(self, rows, columns):
        thickness, top = super()._at(rows, columns)
        return np.minimum(thickness, np.float32(5.0)), np.full_like(top, 2000.0)


class Spread(Towers):
    """The same thickness over heights 1.4 times as large."""

    def cloud_depth_m(self, time_s, rows, columns):
        return np.maximum(np.float32(1.4) * self._at(rows, columns)[0], np.float32(1.0))


class Standing(Spread):
    """The same bodies, which the sensor sees at the flat side of the layer."""

    cloud_top_range_m = None


class Plugin:
    @hookimpl
    def hcss_register_cloud_generators(self):
        return [
            ProviderSpec(each.__name__.lower(), f"{__name__}:{each.__name__}", None, 3, "a test")
            for each in (Towers, Sheet, Spread, Standing)
        ]


@pytest.fixture(scope="module", autouse=True)
def installed():
    with pytest.MonkeyPatch.context() as patch:
        install(patch, Plugin())
        yield


@lru_cache
def seen(zenith, azimuth, **changes):
    view = {"view.zenith": zenith, "view.azimuth": azimuth, "slant.parallax": "on", "slant.shadows": "on"}
    more = {key.replace("__", "."): value for key, value in changes.items()}
    return simulate(Scenario.from_dict(SCENE, {**CHEAP, **view, **more, "output.certificate": 16}))


HEIGHTS_M = np.arange(RANGE[1], RANGE[0] - 1500.0, -1.0)


def met(zenith, azimuth, spread=1.0):
    """Cloud at each height of the lines from all points of the sea: whether, thickness, and top, (heights, y, x)."""
    tangent, bearing = np.tan(np.radians(zenith)), np.radians(azimuth)
    y, x = np.mgrid[:SIZE, :SIZE]
    north, east = (HEIGHTS_M[:, None, None] * tangent * turn(bearing) / PIXEL_M for turn in (np.cos, np.sin))
    thickness, top = towers(np.rint(y + north), np.rint(x + east))
    height = HEIGHTS_M[:, None, None]
    return (thickness > 0.0) & (height <= top) & (height >= top - spread * thickness), thickness, top


@pytest.mark.parametrize("view", [(55.0, 70.0), (30.0, 200.0), (0.0, 0.0)])
def test_a_line_of_sight_sees_all_that_it_crosses_at_its_mean_height(view):
    made = seen(*view)
    inside, thickness, top = met(*view)
    crossed = np.sum(inside, axis=0) if view[0] else np.max(np.where(inside, thickness, 0.0), axis=0)
    any_cloud = crossed > 0.0
    expected = np.where(any_cloud, np.sum(inside * HEIGHTS_M[:, None, None], axis=0) / np.maximum(crossed, 1.0), 0.0)
    expected = np.where(any_cloud, np.maximum(expected + 0.5 * crossed, RANGE[0]), 0.0)
    if not view[0]:
        expected = np.max(np.where(inside, top, 0.0), axis=0)
    found = made["cloud_thickness"].values[0], np.nan_to_num(made["cloud_top_altitude"].values[0])
    # Slices of height move a line by less than a point.
    assert np.mean((found[0] > 0.0) == any_cloud) > 0.97
    both = any_cloud & (found[0] > 0.0)
    errors = [np.abs(of - true)[both] for of, true in zip(found, (np.minimum(crossed, 1500.0), expected), strict=True)]
    for error in errors:
        assert np.sqrt(np.mean(error**2)) < (40.0 if view[0] else 1e-3)
    assert 0.3 < np.mean(any_cloud) < 0.9
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_the_sea_is_in_shadow_where_the_path_of_the_sun_meets_cloud():
    made = seen(0.0, 0.0)
    shaded = np.any(met(float(made.solar_zenith_angle[0]), float(made.solar_azimuth_angle[0]))[0], axis=0)
    clear = made["cloud_mask"].values[0] == 0
    assert 0.3 < np.mean(shaded[clear]) < 0.9
    assert np.mean((made["shadow_mask"].values[0] == shaded)[clear]) > 0.95


def test_thin_clouds_at_one_height_are_those_of_a_flat_layer():
    layer = {"clouds__top": 2000.0, "clouds__base": 1990.0, "clouds__thickness_min": 1.0}
    sheet = seen(55.0, 70.0, clouds__generator="sheet", **layer)
    north, east = (2000.0 * np.tan(np.radians(55.0)) * turn(np.radians(70.0)) / PIXEL_M for turn in (np.cos, np.sin))
    y, x = np.mgrid[:SIZE, :SIZE]
    cloudy = towers(y + int(np.rint(north)), x + int(np.rint(east)))[0] > 0.0
    np.testing.assert_array_equal(sheet["cloud_mask"].values[0] > 0, cloudy)


def test_a_sensor_at_a_known_altitude_sees_the_same_where_its_lines_of_sight_are_nearly_parallel():
    far, parallel = seen(30.0, 200.0, platform__altitude=3.5e7), seen(30.0, 200.0)
    for name in ("cloud_thickness", "cloud_top_altitude"):
        one, other = (np.nan_to_num(made[name].values[0]) for made in (far, parallel))
        assert np.mean(np.isclose(one, other, atol=1.0)) > 0.95
    near = seen(30.0, 200.0, platform__altitude=2e5)
    assert near.attrs["hcss_certificate"].startswith("computed as specified")


def test_clouds_of_another_height_than_their_thickness_have_it_in_all_of_that_height():
    """They are seen at the top of what is crossed, which is as thick as its share of the height."""
    made = seen(55.0, 70.0, clouds__generator="spread")
    inside, _, _ = met(55.0, 70.0, 1.4)
    height = np.sum(inside, axis=0)
    cloudy = height / 1.4 > 2.5  # half the thinnest cloud
    middle = np.sum(inside * HEIGHTS_M[:, None, None], axis=0) / np.maximum(height, 1.0)
    top = np.clip(middle + 0.5 * height, *RANGE)
    found = made["cloud_thickness"].values[0], np.nan_to_num(made["cloud_top_altitude"].values[0])
    assert np.mean((found[0] > 0.0) == cloudy) > 0.97
    both = cloudy & (found[0] > 0.0)
    for of, true in zip(found, (np.minimum(height / 1.4, 1500.0), top), strict=True):
        assert np.sqrt(np.mean((of - true)[both] ** 2)) < 50.0  # slices of 35 m cut 1.4 times as much
    shaded = np.any(met(float(made.solar_zenith_angle[0]), float(made.solar_azimuth_angle[0]), 1.4)[0], axis=0)
    clear = made["cloud_mask"].values[0] == 0
    assert np.mean((made["shadow_mask"].values[0] == shaded)[clear]) > 0.95
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_the_sun_meets_bodies_that_the_sensor_does_not_see():
    """Not columns that hang from the top of the layer by their thickness, with which nearly half the points differ."""
    made = seen(0.0, 0.0, clouds__generator="standing", clouds__base=50.0, clouds__top=4000.0)
    sun = float(made.solar_zenith_angle[0]), float(made.solar_azimuth_angle[0])
    shaded = np.any(met(*sun, 1.4)[0], axis=0)
    clear = made["cloud_mask"].values[0] == 0
    assert np.mean((made["shadow_mask"].values[0] == shaded)[clear]) > 0.95
    assert np.nanmax(made["cloud_top_altitude"].values) == 4000.0
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
