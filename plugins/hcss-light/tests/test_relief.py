"""Clouds with a shape in height: the kit, columns that keep their optical thickness, and light against Monte Carlo."""

import dataclasses

import numpy as np
import pytest
from hcss_author import CloudGeneratorContract, assert_registered, sample_cloud_inputs
from hcss_light.comparison import compare
from hcss_light.relief import ReliefClouds, ReliefParameters

from hcss_twin import Scenario, simulate
from hcss_twin.core.errors import HcssError
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.cloud_columns import read_columns

SHAPE = {"gamma": 2.0, "H": 0.4, "L": (6.0, 6.0), "k": (0, 6)}


class TestRelief(CloudGeneratorContract):
    seeds = 4

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = sample_cloud_inputs(coverage, seed)
        return dataclasses.replace(inputs, layer=dataclasses.replace(inputs.layer, coverage_mode="field"))

    coverage_tolerance = 0.3

    def make_provider(self, inputs):
        return ReliefClouds(inputs, ReliefParameters(**SHAPE))


def scene(light, **changes):
    values = {
        "time": "2024-04-20T23:30:00+10:00",
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": 45.0},
        "image": {"rows": 12, "columns": 12, "pixel_size": 200.0},
        "frames": {"count": 1},
        "accuracy": 0.02,
        "bands": [[10.5, 11.0]],
        "clouds": {"type": "paper-cumulus", "coverage": 0.5, "coverage_mode": "field", "generator": "fractal-relief"},
        "output": {"variables": ["radiance"], "certificate": 0},
        "radiance": {"light": light},
    }
    return Scenario.from_dict(values | changes)


def test_is_found_when_installed():
    assert_registered("clouds", "fractal-relief", distribution="hcss-light")


def test_a_volume_is_drawn_with_bases_and_tops_of_the_shape(tmp_path):
    cube = tmp_path / "cube.nc"
    given = scene("columns", output={"variables": ["truth"], "certificate": 0})
    simulate(given).to_netcdf(cube)
    columns = read_columns(cube)
    cloudy = ~np.isnan(columns.base_m)
    assert np.ptp(columns.base_m[cloudy]) > 50.0
    assert np.all(columns.top_m[cloudy] > columns.base_m[cloudy])


def test_independent_columns_do_not_see_the_shape():
    relief, flat = (
        scene("columns"),
        scene("columns", clouds={"type": "paper-cumulus", "coverage": 0.5, "coverage_mode": "field"}),
    )
    np.testing.assert_array_equal(simulate(relief).radiance.values, simulate(flat).radiance.values)


def test_slanted_light_sees_the_shape_and_agrees_with_monte_carlo_in_the_same_voxels():
    """The mean of 10.8 um; columns of the same clouds are several percent off."""
    (band,) = compare(scene("source"), 16, 300, 0, 1)["bands"]
    assert band["errors"]["cube"]["rms"] < 0.02
    assert band["errors"]["cube"]["rms"] < 0.5 * band["errors"]["columns"]["rms"]


def test_a_profile_for_clouds_with_their_own_shape_is_refused():
    with pytest.raises(HcssError, match="light_profile"):
        simulate(scene("source", radiance={"light": "source", "light_profile": "adiabatic"}))


def test_sides_of_clouds_change_with_height_instead_of_standing_as_needles():
    """At 20 m: the share of sides that go on straight over the next 100 m; nearly all do in columns on a flat base."""
    image = {"rows": 64, "columns": 64, "pixel_size": 20.0}
    plan = make_plan(scene("columns", image=image))
    generator, layer = plan.assembly.generators[0], plan.layers[0]
    edges, window = np.arange(layer.base_m, layer.top_m, 20.0), (slice(0, 64), slice(0, 64))
    thickness = generator.thickness_m(0.0, *window)
    flat = layer.base_m + thickness > edges[:-1, None, None]
    straight = []
    for cloudy in (flat, generator.height_shares(0.0, *window, thickness, edges) > 1e-6):
        side = cloudy[:, :, 1:] != cloudy[:, :, :-1]
        straight.append(np.count_nonzero(side[5:] & side[:-5]) / np.count_nonzero(side[:-5]))
    assert straight[1] < 0.7 * straight[0]


@pytest.mark.parametrize("pixel_m", [25.0, 100.0])
def test_tops_are_as_high_as_columns_are_thick_over_the_sky(pixel_m):
    """Heights below 20 m of cloud, where columns on a flat base have them; independent skies around the image."""
    plan = make_plan(scene("columns", image={"rows": 32, "columns": 32, "pixel_size": pixel_m}))
    generator, layer = plan.assembly.generators[0], plan.layers[0]
    edges, found = np.linspace(layer.base_m, layer.top_m, 49), []
    for number in range(16):
        window = (slice(0, 16), slice(8000 * number, 8000 * number + 16))
        thickness = generator.thickness_around_m(0.0, *window, None)
        cloud = generator.height_shares(0.0, *window, thickness, edges) * thickness
        above, seen = np.cumsum(cloud[::-1], axis=0)[::-1], np.minimum(20.0, 0.5 * thickness)
        top = np.max(np.where(above >= seen, edges[1:, None, None] - layer.base_m, 0.0), axis=0)
        found.append((np.sum(top[thickness > 0.0]), np.sum(thickness - seen)))
    tops, flat = np.sum(found, axis=0)
    # 16 places scatter by some 7 %; with the thickness as threshold tops were 40 % too high.
    assert abs(tops - flat) < 0.1 * flat
