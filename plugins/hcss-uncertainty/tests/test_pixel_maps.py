"""Running moments of pairs of images: against numpy on the whole stack."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from hcss_uncertainty.estimators import seed_variance, variance
from hcss_uncertainty.pixel_maps import PairMoments, require_room_for_maps

from hcss_twin.core.errors import ScenarioError


@pytest.mark.parametrize("dtype", [np.float32, np.int32, np.bool_])
def test_running_moments_are_those_of_the_stack(dtype):
    rng = np.random.default_rng(0)
    shape = (40, 2, 3, 5)
    stack = (1e4 + 3.0 * rng.standard_normal((40, 1, 3, 5)) + rng.standard_normal(shape)).astype(np.float32)
    stack = stack > 1e4 if dtype == np.bool_ else stack.astype(dtype)
    found = PairMoments(shape[2:])
    for first, second in stack:
        found.add(first, second)
    whole = stack.astype(np.float64)
    np.testing.assert_allclose(found.mean, whole.mean(axis=(0, 1)), rtol=1e-12)
    y = np.moveaxis(whole, 1, 0).reshape(2, 40, -1)
    np.testing.assert_allclose(found.variance.ravel(), variance(y), rtol=1e-9)
    np.testing.assert_allclose(found.seed_variance.ravel(), seed_variance(y), rtol=1e-12)
    # what both are of: half the mean square difference of scenes of different draws, and of the same
    apart = 0.5 * (whole[:, :, None, None] - whole[None, None]) ** 2
    other = ~np.eye(40, dtype=bool)
    expected = np.moveaxis(apart, 2, 1)[other].mean(axis=(0, 1, 2))
    np.testing.assert_allclose(found.variance, expected, rtol=1e-9)


def test_memory_does_not_grow_with_the_number_of_draws():
    image = np.zeros((200, 200), dtype=np.float32)
    found = PairMoments(image.shape)

    def after(draws):
        for _ in range(draws):
            found.add(image, image)
        return tracemalloc.get_traced_memory()

    tracemalloc.start()
    try:
        _, first = after(2)
        tracemalloc.reset_peak()
        _, later = after(30)
    finally:
        tracemalloc.stop()
    assert later <= first * 1.05
    assert later < 6 * image.size * 8


def test_maps_that_do_not_fit_are_refused_with_their_size():
    plan = SimpleNamespace(
        pixels=(4096, 4096),
        frame_times_s=np.zeros(1),
        bands=("a", "b"),
        sensor=SimpleNamespace(stages=()),
        scenario=SimpleNamespace(origin="x"),
    )
    require_room_for_maps(plan)  # 24 bytes x 4096^2 x (1 + 2 x 2): 1.9 GiB
    plan.sensor = SimpleNamespace(stages=("radiometer",))
    require_room_for_maps(plan)  # and with measured radiance and digital number 3.4
    plan.bands = ("a", "b", "c")
    with pytest.raises(ScenarioError, match=r"bands: 3 need 4\.9 GiB; allowed: 4 GiB"):
        require_room_for_maps(plan)
