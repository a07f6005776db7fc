"""Made images with known motion, a scene of known radiance, and states of both."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hcss_author import sample_cloud_inputs
from hcss_author.own_cache import own_cache  # noqa: F401
from hcss_follow.analysis import Image, analyse
from hcss_follow.generator import FollowedClouds
from hcss_follow.parameters import FollowedParameters

from hcss_twin.providers import Catalog, Grid, Motion

TIME = datetime(2020, 9, 6, tzinfo=UTC)
STILL = Motion(0.0, (0.0, 0.0), np.inf, 1.0)


def field(side, seed=3, shift=(0.0, 0.0), fine=24.0):
    """Brightness temperature (side, side) of smooth waves of ``fine`` pixels and more, moved by pixels, exactly."""
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.arange(side) - shift[0], np.arange(side) - shift[1], indexing="ij")
    total = np.zeros((side, side))
    for _ in range(60):
        k = 2 * np.pi / rng.uniform(fine, 3 * fine)
        turn, phase = rng.uniform(0, 2 * np.pi, 2)
        total += np.cos(k * (np.sin(turn) * y + np.cos(turn) * x) + phase)
    return 290.0 - 8.0 * np.clip(0.5 + total / 12.0, 0.0, None)


def images(side=128, steps=(0, 1), per_step=(2.0, -3.0), **options):
    """Images 15 min apart, moved by so many pixels northward and eastward each time."""
    return [
        Image(field(side, shift=(n * per_step[0], n * per_step[1]), **options), TIME + n * timedelta(minutes=15))
        for n in steps
    ]


def state_of(given, **options):
    return analyse(given, **{"pixel_size_m": 3000.0, "latitude": 5.0, "longitude": -20.0, **options})


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
        thickness = np.concatenate(([0.0], np.geomspace(0.01, 1000.0, 200)))
        return thickness, self.of(top_m, thickness)

    def in_band(self, limits_um):
        return self


@pytest.fixture
def make(tmp_path):
    """Return a function that makes generators of a state, a grid and parameters."""

    def made(state, rows=32, columns=32, pixel_size_m=3000.0, motion=STILL, seed=1, **parameters):
        path = tmp_path / "state.nc"
        state.write(path)
        inputs = sample_cloud_inputs(0.5, seed)
        layer = replace(inputs.layer, base_m=500.0, top_m=1500.0, thickness_min_m=0.01)
        inputs = replace(
            inputs, layer=layer, grid=Grid(rows, columns, pixel_size_m), motion=motion, inversion=Emitting(),
            catalog=Catalog(),
        )  # fmt: skip
        return FollowedClouds(inputs, FollowedParameters(state=str(path), **parameters))

    return made


def seen(generator, time_s=0.0, rows=slice(0, 32), columns=slice(0, 32)):
    """Brightness temperature of a window of a generator's clouds."""
    top = generator.cloud_top_m(time_s, rows, columns).astype(float)
    return Emitting().of(top, generator.thickness_m(time_s, rows, columns).astype(float))
