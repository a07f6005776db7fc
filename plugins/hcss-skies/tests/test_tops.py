"""Tops of the example: the brightness temperature of each cloud is that of the example, whatever its altitude."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import CloudGeneratorContract, sample_cloud_inputs
from hcss_skies.generator import ExampleClouds
from hcss_skies.parameters import ExampleParameters
from hcss_skies.tops import between_cells, hanging_clouds, look_up_pairs

from hcss_twin.providers import Grid


class Emitting:
    """Clouds that emit 1 - exp(-thickness / 50 m) at the temperature of their top, before 295 K; 6 K/km."""

    clear_K, coldest_K = 295.0, 230.0

    def air_temperature_K(self, altitude_m):
        return 297.0 - 6e-3 * np.asarray(altitude_m)

    def thickness_m(self, brightness_temperature_K):
        return np.maximum(self.clear_K - brightness_temperature_K, 0.0).astype(np.float32)

    def of(self, top_m, thickness_m):
        emissivity = 1.0 - np.exp(-thickness_m / 50.0)
        return self.clear_K + emissivity * (self.air_temperature_K(top_m) - self.clear_K)

    def hanging_K(self, top_m):
        thickness = np.concatenate(([0.0], np.geomspace(1.0, 1000.0, 40)))
        return thickness, self.of(top_m, thickness)


class TestOwnTops(CloudGeneratorContract):
    """Pixels of 30 km, so that a frame has many independent clouds."""

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def _clouds_of_a_layer_once(cls):
        """Generators of one layer, which differ by their seed and grid alone, share the table of their clouds."""
        kept = {}

        def once(sky, layer, kelvin, excess_m, highest_m):
            key = (repr(layer), kelvin.tobytes(), excess_m.tobytes(), highest_m)
            if key not in kept:
                kept[key] = hanging_clouds(sky, layer, kelvin, excess_m, highest_m)
            return kept[key]

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("hcss_skies.generator.hanging_clouds", once)
            yield

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = sample_cloud_inputs(coverage, seed)
        layer = replace(inputs.layer, base_m=500.0, top_m=1500.0, thickness_min_m=1.0)
        return replace(inputs, grid=Grid(48, 64, 30e3), inversion=Emitting(), layer=layer)

    def make_provider(self, inputs):
        return ExampleClouds(inputs, ExampleParameters(example="open-cells-1", tops="example"))


@pytest.fixture
def layer():
    inputs = sample_cloud_inputs()
    return replace(inputs.layer, base_m=500.0, top_m=1500.0, thickness_min_m=1.0)


def test_clouds_have_the_brightness_temperature_asked_for_at_any_top(layer):
    sky, opaque = Emitting(), np.linspace(0.0, 9000.0, 91)
    kelvin = sky.air_temperature_K(opaque)
    clouds = hanging_clouds(sky, layer, kelvin, np.array([0.0, 5000.0]), 14000.0)
    thickness, top = np.moveaxis(clouds.fields.astype(float), -1, 0)
    seen = sky.of(top, thickness)
    cloudy = kelvin < sky.clear_K - 0.1
    assert np.abs(seen - kelvin[:, None])[cloudy].max() < 0.3  # between knots of altitude and thickness
    assert np.all(thickness[kelvin > sky.clear_K] == 0.0)
    x = clouds.step_m * np.arange(top.shape[1])
    high = opaque > 500.0
    # x above the opaque cloud, up to the coldest altitude; the air above is transparent, so that opaque means p.
    expected = np.minimum(opaque[:, None] + x, clouds.range_m[1])
    np.testing.assert_allclose(top[high], expected[high], atol=20.0)
    assert np.all(np.diff(thickness[high], axis=1) <= 1e-3)
    assert np.all(thickness <= top)


def test_a_scene_with_its_own_tops_shows_the_example_and_both_fields_belong_together(make):
    altitudes = {"base_m": 500.0, "top_m": 4000.0}  # the whole example fits
    of_layer, of_tops = (
        make(inversion=Emitting(), least=0.5, layer=altitudes, tops=tops) for tops in ("layer", "example")
    )
    assert of_layer.cloud_top_range_m is None
    window = 0.0, slice(0, 64), slice(0, 64)
    low, high = of_tops.cloud_top_range_m
    top, thickness = of_tops.cloud_top_m(*window).astype(float), of_tops.thickness_m(*window).astype(float)
    assert low <= top.min() <= top.max() <= high
    # The layer's thickness here is clear_K less the brightness temperature.
    kelvin = Emitting.clear_K - of_layer.thickness_m(*window).astype(float)
    seen = Emitting().of(top, thickness)
    assert np.abs(seen - kelvin)[thickness > 1.0].max() < 0.5
    part = of_tops.cloud_top_m(0.0, slice(10, 20), slice(30, 50))
    np.testing.assert_array_equal(part, of_tops.cloud_top_m(*window)[10:20, 30:50])


def test_tops_between_cells_are_bilinear():
    y, x = np.mgrid[:5, :6]
    np.testing.assert_allclose(between_cells(3.0 * y + x, np.array([0.5, 3.25]), np.array([4.5])), [[6.0], [14.25]])


@pytest.mark.parametrize("extreme", [-1e30, -1.0, 0.0, 1e30, np.inf, -np.inf])
def test_pairs_beyond_the_knots_are_those_of_the_nearest_knot(extreme):
    fields = np.arange(24, dtype=np.float32).reshape(3, 4, 2)
    out = np.full((2, 2, 2), extreme, np.float32)
    look_up_pairs(out, fields, 500.0)
    edge = fields[-1, -1] if extreme > 0.0 else fields[0, 0]
    np.testing.assert_allclose(out, np.broadcast_to(edge, out.shape), atol=1e-4)
