"""Laws that any layer keeps: energy, reciprocity, addition, and the limits that have closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.physics.multiple_scattering.forward_peak import once_back, once_through
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.phase_function import delta_m, henyey_greenstein
from hcss_twin.physics.multiple_scattering.second_order import twice_back
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream

THICKNESS = np.array([0.0, 1e-8, 1e-3, 0.1, 1.0, 8.0, 64.0, 1e3, 1e6])[:, np.newaxis]
EXTRA = [1.0, 0.5, 0.05]
SOLVERS = pytest.mark.parametrize("solve", [solve_layers, solve_layers_two_stream])


def henyey_greenstein_moments(g):
    return np.stack([np.ones_like(np.asarray(g, dtype=float)), np.asarray(g, dtype=float)])


def flux_weight(layer):
    return 2.0 * np.pi * layer.mu * layer.weight


@SOLVERS
def test_a_conservative_layer_emits_nothing(solve) -> None:
    g = [-0.9, 0.0, 0.85, 0.99]
    layer = solve(np.repeat(THICKNESS, 4, axis=1), np.ones(4), henyey_greenstein_moments(g), EXTRA, 8)
    np.testing.assert_allclose(layer.emissivity, 0.0, atol=1e-15)
    np.testing.assert_allclose(layer.far_share, 0.0, atol=1e-15)


def test_a_conservative_layer_conserves_the_light_of_a_beam() -> None:
    tau, g = np.repeat(THICKNESS, 3, axis=1), [0.0, 0.85, 0.95]
    layer = solve_layers(tau, np.ones(3), henyey_greenstein_moments(g), EXTRA, 8)
    leaves = flux_weight(layer) @ (layer.reflection + layer.transmission)
    np.testing.assert_allclose(leaves + layer.direct, 1.0, rtol=0, atol=1e-10)


def test_a_layer_on_another_is_one_of_both_thicknesses() -> None:
    moments = henyey_greenstein_moments([0.8])
    streams = 8

    def matrices(tau):
        # The unscaled problem of the same truncated phase function, as plain operators on the streams.
        layer = solve_layers([[tau]], [0.9], moments, [], streams)
        weight = flux_weight(layer)
        transmission = layer.transmission[0, 0] * weight + np.diag(layer.direct[0, 0])
        return layer.reflection[0, 0] * weight, transmission, layer.emissivity[0, 0], layer.far_share[0, 0]

    r1, t1, e1, f1 = matrices(0.37)
    r2, t2, e2, f2 = matrices(1.9)
    between = np.linalg.inv(np.eye(streams) - r1 @ r2)
    down = between @ t1
    reflection, transmission = r1 + t1 @ r2 @ down, t2 @ down
    # Planck radiance 0 at the top, 1 at the base, linear in optical depth.
    middle = 0.37 / (0.37 + 1.9)
    toward_lower = middle * (e1 - f1)
    toward_upper = middle * (e2 - f2) + f2
    up = np.linalg.solve(np.eye(streams) - r2 @ r1, toward_upper + r2 @ toward_lower)
    far = middle * f1 + t1 @ up
    whole = matrices(0.37 + 1.9)
    np.testing.assert_allclose(reflection, whole[0], rtol=0, atol=1e-10)
    np.testing.assert_allclose(transmission, whole[1], rtol=0, atol=1e-10)
    np.testing.assert_allclose(far, whole[3], rtol=0, atol=1e-10)


@SOLVERS
def test_a_layer_that_does_not_scatter_has_closed_forms(solve) -> None:
    tau = THICKNESS[3:]
    layer = solve(tau, [0.0], henyey_greenstein_moments([0.85]), EXTRA, 8)
    x = tau / layer.mu
    np.testing.assert_array_equal(layer.reflection, 0.0)
    np.testing.assert_array_equal(layer.transmission, 0.0)
    np.testing.assert_allclose(layer.emissivity[:, 0], -np.expm1(-x), rtol=1e-11)
    expected = -np.expm1(-x) / x - np.exp(-x)
    np.testing.assert_allclose(layer.far_share[:, 0], expected, rtol=1e-9, atol=1e-13)


@SOLVERS
def test_both_faces_of_a_thin_layer_emit_alike(solve) -> None:
    layer = solve([[1e-6]], [0.6], henyey_greenstein_moments([0.8]), EXTRA, 8)
    np.testing.assert_allclose(layer.far_share, 0.5 * layer.emissivity, rtol=2e-5)


@SOLVERS
def test_a_thick_layer_does_not_show_its_far_face(solve) -> None:
    layer = solve([[1e5]], [0.6], henyey_greenstein_moments([0.8]), EXTRA, 8)
    assert np.all(layer.far_share > 0.0)
    assert np.all(layer.far_share < 1e-4)


@SOLVERS
def test_no_layer_is_no_layer(solve) -> None:
    layer = solve([[0.0]], [0.9], henyey_greenstein_moments([0.8]), EXTRA, 8)
    np.testing.assert_array_equal(layer.direct, 1.0)
    for nothing in (layer.reflection, layer.transmission, layer.emissivity, layer.far_share):
        np.testing.assert_array_equal(nothing, 0.0)


@pytest.mark.parametrize("two_stream", [False, True])
def test_a_thin_layer_scatters_once(two_stream) -> None:
    tau, g, mu, sun, azimuth = 1e-7, 0.85, 0.6, 0.7, 2.0
    arguments = ([[tau]], [0.9], henyey_greenstein_moments([g]), [mu], sun, [azimuth], 8)
    brdf, btdf = solve_sun_two_stream(*arguments) if two_stream else solve_sun(*arguments, 16)
    across = np.sqrt((1 - mu**2) * (1 - sun**2)) * np.cos(azimuth)
    for found, cosine in ((brdf, -mu * sun - across), (btdf, mu * sun - across)):
        phase = (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5
        assert found[0, 0, 0] == pytest.approx(0.9 * phase * tau / (4 * np.pi * mu * sun), rel=2e-5)


def test_an_extra_direction_is_a_stream_without_weight() -> None:
    arguments = ([[0.1], [3.0]], [0.9], henyey_greenstein_moments([0.8]))
    plain = solve_layers(*arguments, [], 8)
    with_extras = solve_layers(*arguments, plain.mu, 8)
    for name in ("reflection", "transmission"):
        extra, stream = np.s_[..., :8, 8:], np.s_[..., 8:, 8:]
        kernel = getattr(with_extras, name)
        np.testing.assert_allclose(kernel[extra], kernel[stream], rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(kernel[stream], getattr(plain, name), rtol=1e-11, atol=1e-12)
    for name in ("emissivity", "far_share", "direct"):
        values = getattr(with_extras, name)
        np.testing.assert_allclose(values[..., :8], values[..., 8:], rtol=0, atol=1e-13)


def test_the_mean_over_azimuth_of_sunlight_is_the_kernel() -> None:
    # So smooth a phase function is not truncated: both are the same problem.
    moments, views = henyey_greenstein_moments([0.3]), np.array([0.2, 0.6, 1.0])
    azimuth = np.pi * (np.arange(32) + 0.5) / 32
    arguments = ([[0.1], [3.0]], [0.9], moments)
    where = np.repeat(views, 32), 0.5, np.tile(azimuth, 3), 12, 24
    brdf, btdf = solve_sun(*arguments, *where, None, 0.0, exact_orders=1)
    layer = solve_layers(*arguments, [0.5, *views], 12)
    for found, kernel in ((brdf, layer.reflection), (btdf, layer.transmission)):
        mean = found.reshape(2, 1, 3, 32).mean(axis=-1)
        np.testing.assert_allclose(mean, kernel[..., 1:4, 0], rtol=1e-10, atol=1e-10)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    rng = np.random.default_rng(2)
    tau, albedo = 10 ** rng.uniform(-2, 2, (9, 11)), rng.uniform(0, 1, 11)
    moments = henyey_greenstein_moments(rng.uniform(0, 0.95, 11))
    one = solve_layers(tau, albedo, moments, EXTRA, 4, threads=1)
    three = solve_layers(tau, albedo, moments, EXTRA, 4, threads=3)
    np.testing.assert_array_equal(one.reflection, three.reflection)
    np.testing.assert_array_equal(one.far_share, three.far_share)
    arguments = (tau, albedo, moments, [0.3], 0.5, [1.0], 4, 4)
    np.testing.assert_array_equal(solve_sun(*arguments, threads=1), solve_sun(*arguments, threads=3))


def test_a_thick_layer_that_scatters_backward_transmits_no_sunlight() -> None:
    _, btdf = solve_sun([[1e5], [1e6]], [0.9], henyey_greenstein_moments([-0.9]), [0.5], 0.5, [1.0], 4, 8)
    np.testing.assert_array_equal(btdf, 0.0)


@pytest.mark.parametrize("g", [-0.5, 0.5, 0.85])
def test_a_low_sun_fades_smoothly_through_thick_layers(g) -> None:
    """Its direct light is less than the smallest number where scattered light is not."""
    thickness, albedo = np.arange(20.0, 40.0, 0.05)[:, np.newaxis], np.array([0.9])
    moments = henyey_greenstein_moments([g])
    scaled = delta_m(thickness, albedo, moments, 16)
    btdf = once_through(scaled, albedo, moments, np.array([0.94]), 0.0166, np.array([30.0]))
    # Where the sun has gone, what it lit at the top fades along the view.
    steps = np.diff(np.log(btdf.ravel()))
    np.testing.assert_allclose(steps, -0.05 * (1.0 - 0.9 * scaled.peak[0]) / 0.94, rtol=0.02)


@pytest.mark.parametrize("g", [0.99, 0.9953, 0.9979])
def test_thin_layers_transmit_light_scattered_once_however_sharp_the_forward_peak(g) -> None:
    """In closed form, P / (4 pi mu mu0) times the path, of Henyey and Greenstein's function."""
    depth, albedo, mu, sun = 1e-6, 0.5, np.array([0.9, 0.9, 0.7]), 0.8
    azimuth = np.array([np.pi, 2.5, 0.5])
    _, btdf = solve_sun([[depth]], [albedo], henyey_greenstein_moments([g]), mu, sun, azimuth, 8, 16)
    turned = np.array([scattering_cosine(-m, sun, a) for m, a in zip(mu, azimuth, strict=True)])
    once = albedo * depth * henyey_greenstein(turned, g) / (4.0 * np.pi * mu * sun)
    np.testing.assert_allclose(btdf[0, 0], once, rtol=1e-5)


@pytest.mark.parametrize("thickness", [0.01, 1.0, 12.0])
@pytest.mark.parametrize("g", [-0.6, 0.6])
def test_light_towards_the_sun_is_the_series_of_small_angles(g, thickness) -> None:
    """C_l of van de Hulst (1980), section 14.1.2, with the direct light of the scaled problem alone."""
    count, albedo, mu = 4, np.array([0.95]), 0.8
    scaled = delta_m(np.array([[thickness]]), albedo, henyey_greenstein_moments([g]), count)
    unscattered = replace(scaled, albedo=np.zeros(1))
    azimuth = np.array([np.pi, 2.0])
    btdf = once_through(unscattered, albedo, henyey_greenstein_moments([g]), np.full(2, mu), mu, azimuth)
    degree, y = np.arange(200), thickness / mu
    moment, below = g**degree, np.exp(-y * (1.0 - 0.95 * g**count)) - np.exp(-y)
    missing = np.where(degree < count, below, np.exp(-y) * np.expm1(0.95 * moment * y))
    turned = np.array([scattering_cosine(-mu, mu, each) for each in azimuth])
    series = np.polynomial.legendre.legval(turned, (2 * degree + 1) * missing)
    np.testing.assert_allclose(btdf[0, 0], series / (4.0 * np.pi * mu), rtol=1e-6)


def test_light_scattered_twice_is_the_second_order_in_albedo_of_all_light() -> None:
    # A phase function whose moments all are kept, so that nothing is scaled: brdf = a w + b w^2 + c w^3 + ...
    moments = np.zeros((36, 1))
    moments[:16, 0] = 0.6 ** np.arange(16) * np.linspace(1.0, 0.3, 16)
    depth, mu, sun, azimuth = np.array([[0.3], [3.0], [10.0]]), np.array([0.8]), 0.5, np.array([1.0])

    def more_than_once(albedo: float) -> np.ndarray:
        scaled = delta_m(depth, np.array([albedo]), moments, 16)
        once = once_back(scaled, np.array([albedo]), moments, mu, sun, azimuth)
        return solve_sun(depth, [albedo], moments, mu, sun, azimuth, 8, 16, None, 0.0, exact_orders=1)[0] - once

    small = 1e-3
    expected = (8.0 * more_than_once(small) - more_than_once(2.0 * small)) / (4.0 * small**2)
    found = twice_back(depth, np.ones(1), moments[:16], 8, 16, mu, sun, azimuth)
    np.testing.assert_allclose(found, expected, rtol=1e-5)


@pytest.mark.parametrize("along", ["view", "sun"])
def test_a_direction_that_is_one_of_the_streams_is_no_special_one(along) -> None:
    moments, stream = henyey_greenstein_moments([0.8]), float(gauss_streams(64).mu[40])

    def brdf(mu: float) -> np.ndarray:
        view, sun = (mu, 0.6) if along == "view" else (0.6, mu)
        return solve_sun([[0.1], [5.0]], [0.9], moments, [view], sun, [1.0], 8, 12, kept_moments=12)[0]

    np.testing.assert_allclose(brdf(stream), brdf(stream + 1e-7), rtol=1e-5)
