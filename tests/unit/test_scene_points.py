"""Values between the points of the scene."""

import numpy as np
import pytest

from hcss_twin.engine.scene_points import interpolated


def test_interpolated_clouds_are_never_thinner_than_the_thinnest():
    rng = np.random.default_rng(5)
    field = np.where(rng.random((40, 50)) < 0.5, rng.uniform(20.0, 300.0, (40, 50)), 0.0).astype(np.float32)
    places = rng.uniform(-0.5, 39.5, (1, 10_000)), rng.uniform(-0.5, 49.5, (1, 10_000))
    between = interpolated(field, *places, (0, 0))
    assert between[between > 0.0].min() >= 20.0 * (1 - 1e-6)
    assert np.mean(between > 0.0) == pytest.approx(0.5, abs=0.03)
    assert interpolated(field, *np.indices(field.shape, dtype=float), (0, 0)) == pytest.approx(field)
