"""A layer does not depend on the layers it is solved with, and a series ends where its rest is small."""

import numpy as np
import pytest

from hcss_twin.physics.multiple_scattering.directions import scattering_kernels
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

NAMES = ("reflection", "transmission", "direct", "emissivity", "far_share")
ALBEDO = np.array([0.3, 0.95, 1.0])
MOMENTS = np.array([[1.0, 1.0, 1.0], [0.85, -0.4, 0.9]])
EXTRA = [1.0, 0.05]
# One wavenumber's thickness is not a multiple of another's by a power of 2.
FACTOR = np.array([1.0, 0.37, 2.9])
VIEWS, AZIMUTH = np.repeat([1.0, 0.6, 0.2], 3), np.tile([0.0, 1.5, np.pi], 3)


def alone(thickness):
    one = [solve_layers(row[np.newaxis], ALBEDO, MOMENTS, EXTRA, 8) for row in thickness]
    return {name: np.concatenate([getattr(layer, name) for layer in one]) for name in NAMES}


@pytest.mark.parametrize(
    "powers",
    [
        # Every one from the thinnest, whose start is far thinner than the next ones need; some left out;
        # to and fro, with gaps for which a new start costs less; the same one twice.
        np.arange(-24, 6),
        np.array([5, -3, 0, -9]),
        np.array([20, -60, -8, -30, 2]),
        np.array([1, 1, 0]),
    ],
)
@pytest.mark.parametrize("rounding", [0.0, 1e-13])
def test_a_layer_of_a_family_is_the_layer_alone(powers, rounding) -> None:
    rng = np.random.default_rng(4)
    thickness = np.outer(2.0**powers, FACTOR) * (1.0 + rounding * rng.uniform(-1, 1, (powers.size, 3)))
    family, separate = solve_layers(thickness, ALBEDO, MOMENTS, EXTRA, 8), alone(thickness)
    for name in NAMES:
        np.testing.assert_allclose(getattr(family, name), separate[name], rtol=1e-9, atol=1e-13, err_msg=name)


def test_families_that_differ_between_wavenumbers_and_layers_of_none_are_solved() -> None:
    thickness = np.array([[1.0, 0.1, 7.0], [0.5, 0.0, 3.0], [4.0, 0.4, 3.5], [0.0, 1e-9, 1.5], [1e6, 0.2, 1e-3]])
    family, separate = solve_layers(thickness, ALBEDO, MOMENTS, EXTRA, 8), alone(thickness)
    for name in NAMES:
        np.testing.assert_allclose(getattr(family, name), separate[name], rtol=1e-9, atol=1e-13, err_msg=name)


def test_a_family_keeps_the_balance_of_energy_to_its_thickest_member() -> None:
    layer = solve_layers(1e-4 * 2.0 ** np.arange(34)[:, np.newaxis], [1.0], MOMENTS[:, 2:], EXTRA, 8)
    flux = 2.0 * np.pi * layer.mu * layer.weight
    sums = (layer.reflection + layer.transmission) @ flux + layer.direct
    np.testing.assert_allclose(sums, 1.0, rtol=0, atol=1e-12)


def test_sunlight_of_a_family_is_that_of_the_layer_alone() -> None:
    thickness = np.outer(0.5 ** np.arange(-4, 12), FACTOR)
    sunlit = (VIEWS, 0.7, AZIMUTH, 8, 16)
    family = solve_sun(thickness, ALBEDO, MOMENTS, *sunlit, mode_tolerance=0.0)
    for t in range(thickness.shape[0]):
        one = solve_sun(thickness[t : t + 1], ALBEDO, MOMENTS, *sunlit, mode_tolerance=0.0)
        for found, expected in zip(family, one, strict=True):
            np.testing.assert_allclose(found[t], expected[0], rtol=1e-9, atol=1e-13)


def test_modes_left_out_change_little_and_none_with_tolerance_0() -> None:
    rng = np.random.default_rng(6)
    tau, albedo = 10 ** rng.uniform(-2, 2, (4, 20)), rng.uniform(0.3, 1.0, 20)
    moments = np.stack([np.ones(20), rng.uniform(0.5, 0.9, 20)])
    sunlit = (tau, albedo, moments, VIEWS, 0.7, AZIMUTH, 16, 32)
    every = solve_sun(*sunlit, mode_tolerance=0.0)
    largest = []
    for tolerance in (1e-3, 1e-5, 1e-14):
        few = solve_sun(*sunlit, mode_tolerance=tolerance)
        largest.append(max(np.max(np.abs(f / e - 1.0)) for f, e in zip(few, every, strict=True)))
        assert largest[-1] < 5 * tolerance + 1e-12
    # Something was left out.
    assert largest[0] > largest[1] > 1e-9


def test_a_series_that_is_zero_ends_at_once(monkeypatch) -> None:
    solved = []

    def counted(where, scattering, mode):
        solved.append(mode)
        return scattering_kernels(where, scattering, mode)

    monkeypatch.setattr("hcss_twin.physics.multiple_scattering.doubling.scattering_kernels", counted)
    # Toward the zenith nothing depends on azimuth.
    solve_sun([[3.0]], [0.9], [[1.0], [0.8]], [1.0], 0.5, [1.0], 8, 16)
    assert solved == [0, 1, 2]
    solved.clear()
    solve_sun([[3.0]], [0.9], [[1.0], [0.8]], [1.0], 0.5, [1.0], 8, 16, mode_tolerance=0.0)
    assert solved == list(range(16))
