"""Clouds of given brightness temperature and excess, in a scene whose radiance is a closed form."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import Emitting
from hcss_author import sample_cloud_inputs
from hcss_follow.hanging import HIGHEST_M, hanging_clouds

from hcss_twin.providers import Catalog


class Counting(Emitting):
    """Counts the altitudes that are asked for; air cools to 200 K at the tropopause at 16 km and warms above."""

    def __init__(self, lapse_K_m=6e-3):
        self.lapse_K_m, self.asked = lapse_K_m, 0

    def air_temperature_K(self, altitude_m):
        return 297.0 - self.lapse_K_m * np.minimum(altitude_m, 32_000.0 - np.asarray(altitude_m))

    def hanging_K(self, top_m):
        self.asked += 1
        return super().hanging_K(top_m)


@pytest.fixture
def layer():
    return replace(sample_cloud_inputs(0.5, 1).layer, base_m=500.0, top_m=1500.0, thickness_min_m=0.01)


def clouds_of(clouds, layer, kelvin, excess_m):
    """Return thickness and top of pixels."""
    pairs = np.stack(np.broadcast_arrays(kelvin, excess_m), axis=-1).astype(np.float32)
    clouds.look_up(pairs, layer)
    return pairs[..., 0].astype(float), pairs[..., 1].astype(float)


def test_clouds_have_their_temperature_and_excess(layer):
    """Also where a small excess thins an opaque cloud to a few optical thicknesses, and at the tropopause."""
    scene = Counting()
    clouds = hanging_clouds(scene, layer, Catalog())
    kelvin, excess_m = np.linspace(203.0, 294.0, 300)[:, None], np.array([0.0, 20.0, 60.0, 130.0, 400.0, 3000.0])
    thickness, top = clouds_of(clouds, layer, kelvin, excess_m)
    assert np.abs(scene.of(top, thickness) - kelvin).max() < 0.03
    opaque = (297.0 - kelvin) / 6e-3
    np.testing.assert_allclose(top, np.minimum(opaque + excess_m, 16_000.0), atol=30.0)
    assert thickness[:, 0].min() > thickness[:, 2].max()  # without excess: opaque


def test_what_is_warmer_than_clear_sky_is_clear_and_what_is_too_cold_is_opaque(layer):
    clouds = hanging_clouds(Counting(), layer, Catalog())
    thickness, top = clouds_of(clouds, layer, np.array([[296.0, 190.0]]), 0.0)
    assert thickness[0, 0] == 0.0
    assert (thickness[0, 1], top[0, 1]) == (1000.0, pytest.approx(16_000.0, abs=25.0))


def test_a_scene_is_asked_once_and_another_one_again(layer, tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    first, again, other = Counting(), Counting(), Counting(5.9e-3)
    made, cached = (hanging_clouds(scene, layer, Catalog()) for scene in (first, again))
    changed = hanging_clouds(other, layer, Catalog())
    assert 1 < first.asked <= 33
    assert again.asked == 1
    assert other.asked == first.asked
    np.testing.assert_array_equal(cached.thickness_m, made.thickness_m)
    assert not np.array_equal(changed.opaque_K, made.opaque_K)


def test_tables_end_at_the_tops_of_a_scene(layer):
    clouds = hanging_clouds(Counting(), layer, Catalog())
    low = clouds.up_to(3000.0)
    assert low.altitude_m[-1] == pytest.approx(3000.0, abs=25.0)
    assert clouds.up_to(np.inf).altitude_m[-1] < HIGHEST_M
    kelvin = np.array([[294.0, 290.0, 282.0]])
    np.testing.assert_array_equal(clouds_of(low, layer, kelvin, 0.0), clouds_of(clouds, layer, kelvin, 0.0))
