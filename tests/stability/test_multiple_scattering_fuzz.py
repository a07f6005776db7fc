"""Any layer a scenario may hold is solved, and stays inside what physics allows."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hcss_twin.models.radiance.physical.numerics import LEVELS
from hcss_twin.physics.multiple_scattering.beams import solve_coupled_layers, transmit_beams
from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream

THICKNESS = st.one_of(st.sampled_from([0.0, 1e6]), st.floats(-8, 6).map(lambda power: 10.0**power))
ALBEDO = st.one_of(
    st.sampled_from([0.0, 1.0]), st.floats(0, 1), st.floats(-15, -1).map(lambda power: 1.0 - 10.0**power)
)
ASYMMETRY = st.floats(-0.99, 0.99)
COSINE = st.one_of(st.sampled_from([float(np.cos(np.radians(85.0))), 1.0]), st.floats(0.05, 1.0))


@settings(deadline=None, max_examples=150)
@given(THICKNESS, ALBEDO, ASYMMETRY, st.lists(COSINE, max_size=3), st.sampled_from([1, 2, 4, 8]))
def test_every_layer_keeps_its_balance(tau, albedo, g, extra, streams) -> None:
    moments = np.array([[1.0], [g]])
    for solve in (solve_layers, solve_layers_two_stream):
        layer = solve([[tau]], [albedo], moments, extra, streams)
        for kernel in (layer.reflection, layer.transmission):
            assert np.all(np.isfinite(kernel))
            scale = 1.0 + np.abs(kernel).max()
            np.testing.assert_allclose(kernel, kernel.swapaxes(-1, -2), rtol=0, atol=1e-10 * scale)
        flux = 2.0 * np.pi * layer.mu * layer.weight
        sums = (layer.reflection + layer.transmission) @ flux + layer.direct + layer.emissivity
        np.testing.assert_allclose(sums, 1.0, rtol=0, atol=1e-10)
        assert np.all((layer.direct >= 0.0) & (layer.direct <= 1.0))
        assert layer.emissivity.min() >= -1e-9
        assert layer.emissivity.max() <= 1.0 + 1e-9
        assert layer.far_share.min() >= -1e-9
        assert np.all(layer.far_share <= layer.emissivity + 1e-9)


@settings(deadline=None, max_examples=60)
@given(THICKNESS, ALBEDO, ASYMMETRY, COSINE, COSINE, st.floats(0, np.pi))
def test_sunlight_is_finite_and_goes_both_ways(tau, albedo, g, view, sun, azimuth) -> None:
    moments = np.array([[1.0], [g]])
    for there, back in (
        (solve_sun([[tau]], [albedo], moments, [view], sun, [azimuth], 4, 8),
         solve_sun([[tau]], [albedo], moments, [sun], view, [azimuth], 4, 8)),
        (solve_sun_two_stream([[tau]], [albedo], moments, [view], sun, [azimuth], 4),
         solve_sun_two_stream([[tau]], [albedo], moments, [sun], view, [azimuth], 4)),
    ):  # fmt: skip
        for one, other in zip(there, back, strict=True):
            assert np.all(np.isfinite(one))
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9)


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(THICKNESS, ALBEDO, ASYMMETRY), min_size=2, max_size=4), COSINE, COSINE, st.floats(0, np.pi))
def test_layers_together_are_what_each_is_alone(layers, view, sun, azimuth) -> None:
    """Black, white, empty and opaque layers beside each other do not disturb one another."""
    tau, albedo, g = np.array(layers).T
    moments = np.stack([np.ones_like(g), g])
    together = solve_layers(tau[None, :], albedo, moments, [view], 4)
    lit = solve_sun(tau[None, :], albedo, moments, [view], sun, [azimuth], 4, 8)
    for place in range(tau.size):
        part = slice(place, place + 1)
        alone = solve_layers(tau[None, part], albedo[part], moments[:, part], [view], 4)
        for name in ("reflection", "transmission", "direct", "emissivity"):
            one, all_ = getattr(alone, name)[0, 0], getattr(together, name)[0, place]
            np.testing.assert_allclose(all_, one, rtol=1e-9, atol=1e-11)
        single = solve_sun(tau[None, part], albedo[part], moments[:, part], [view], sun, [azimuth], 4, 8)
        for one, all_ in zip(single, lit, strict=True):
            np.testing.assert_allclose(all_[0, place], one[0, 0], rtol=1e-7, atol=1e-10)
            # Rounding of a sum over azimuth may leave less than nothing.
            assert np.all(np.isfinite(one))


LEVEL = st.sampled_from(LEVELS[:-2])
GRAZING = st.floats(0.01, 1.0)


@settings(deadline=None, max_examples=40)
@given(THICKNESS, ALBEDO, st.floats(0.0, 0.99), GRAZING, GRAZING, st.floats(0, np.pi), LEVEL)
def test_sunlight_at_every_level_is_finite_and_goes_both_ways(tau, albedo, g, view, sun, azimuth, level) -> None:
    """Also at grazing angles, in opaque and empty layers and next to no absorption."""
    moments = np.array([[1.0], [g]])
    sizes = level.sun_streams, level.azimuth_modes
    there = solve_sun([[tau]], [albedo], moments, [view], sun, [azimuth], *sizes, kept_moments=level.sun_moments)
    back = solve_sun([[tau]], [albedo], moments, [sun], view, [azimuth], *sizes, kept_moments=level.sun_moments)
    for one, other in zip(there, back, strict=True):
        assert np.all(np.isfinite(one))
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-8)


@settings(deadline=None, max_examples=30)
@given(THICKNESS, ALBEDO, st.floats(0.0, 0.99), COSINE, st.integers(2, 16))
def test_beams_end_without_loss(tau, albedo, g, mu, modes) -> None:
    """Modes that are left out after faint ones are as faint."""
    moments = np.array([[1.0], [g]])
    whole = transmit_beams([[tau]], [albedo], moments, [mu], 8, modes, mode_tolerance=0.0)
    short = transmit_beams([[tau]], [albedo], moments, [mu], 8, modes)
    assert np.all(np.isfinite(whole))
    first = np.max(np.abs(whole[0]))
    np.testing.assert_allclose(short, whole, rtol=0, atol=1e-4 * first)


@settings(deadline=None, max_examples=40)
@given(THICKNESS, ALBEDO, st.floats(0.0, 0.99), GRAZING, GRAZING, st.sampled_from(LEVELS[:4]))
def test_coupled_layers_send_no_more_than_they_receive(tau, albedo, g, view, sun, level) -> None:
    """Also at grazing angles, in opaque and empty layers and next to no absorption."""
    moments = np.array([[1.0], [g]])
    streams = gauss_streams(level.streams)
    solved = solve_coupled_layers([[tau]], [albedo], moments, [view, sun], level.streams, level.turned_modes)
    assert np.all(np.isfinite(solved.beams))
    assert np.all(np.isfinite(solved.streams))
    # No mode of an amplitude that is nowhere negative is larger than its mean over azimuth.
    factor = 2.0 * np.pi * streams.mu * streams.weight
    assert np.all(np.einsum("mktvnb,n->mktvb", np.abs(solved.beams), factor) <= 1.0 + 1e-6)
