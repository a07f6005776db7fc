"""Layers against published numbers and against the integral equation of semi-infinite atmospheres."""

import numpy as np
import pytest

from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

# S. Chandrasekhar, Radiative Transfer (Dover 1960), Table XI: H(mu) of conservative isotropic scattering.
CONSERVATIVE_H = {0.1: 1.2474, 0.2: 1.4503, 0.3: 1.6425, 0.4: 1.8293, 0.5: 2.0128, 0.6: 2.1941, 0.7: 2.3740}
CONSERVATIVE_H |= {0.8: 2.5527, 0.9: 2.7306, 1.0: 2.9078}

# K. Stamnes et al., Appl. Opt. 27, 2502-2509 (1988), test problems 1 to 3 of their code, after
# H. C. van de Hulst, Multiple Light Scattering (1980), Tables 12 and 37, and Z. Sweigart, Astrophys. J.
# Suppl. 22, 1-80 (1970), Table 1. Thickness, albedo, moments, mu of the sun, its irradiance; radiance
# reflected and transmitted (irradiance written negative) toward three mu at the azimuth of the sunbeam;
# tolerance. They printed the results of 16 streams, 8 per hemisphere; in problem 3 their correction of
# single scattering was another one.
VIEWS = (0.1, 0.5, 1.0)
RAYLEIGH_VIEWS = (0.018014, 0.538263, 0.981986)
ISOTROPIC, RAYLEIGH, PEAKED = (1.0, 0.0), (1.0, 0.0, 0.1), (1.0, 0.75)
RADIANCES = [
    (0.03125, 0.2, ISOTROPIC, 0.1, np.pi / 0.1, VIEWS, (0.117771, 0.0264170, 0.0134041), 5e-6),
    (0.03125, 0.2, ISOTROPIC, 0.1, -np.pi / 0.1, VIEWS, (0.115898, 0.0263324, 0.0133826), 5e-6),
    (0.03125, 1.0, ISOTROPIC, 0.1, np.pi / 0.1, VIEWS, (0.622884, 0.139763, 0.0709192), 5e-6),
    (32.0, 0.2, ISOTROPIC, 0.1, np.pi / 0.1, VIEWS, (0.262972, 0.0906967, 0.0502853), 5e-6),
    (32.0, 1.0, ISOTROPIC, 0.1, np.pi / 0.1, VIEWS, (1.93321, 1.02732, 0.797199), 5e-6),
    (32.0, 1.0, ISOTROPIC, 0.1, -np.pi / 0.1, VIEWS, (0.0116385, 0.0187805, 0.0271316), 5e-6),
    (0.2, 0.5, RAYLEIGH, 0.080442, np.pi, RAYLEIGH_VIEWS, (0.161796, 0.0211501, 0.00786713), 5e-6),
    (0.2, 0.5, RAYLEIGH, 0.080442, -np.pi, RAYLEIGH_VIEWS, (0.0257685, 0.0200778, 0.00771897), 5e-6),
    (5.0, 1.0, RAYLEIGH, 0.080442, np.pi, RAYLEIGH_VIEWS, (0.364010, 0.0826993, 0.0492370), 5e-6),
    (5.0, 1.0, RAYLEIGH, 0.080442, -np.pi, RAYLEIGH_VIEWS, (0.00379276, 0.00769337, 0.0105950), 5e-6),
    (1.0, 1.0, PEAKED, 1.0, np.pi, VIEWS, (0.151159, 0.101103, 0.0395460), 0.009),
    (1.0, 1.0, PEAKED, 1.0, -np.pi, VIEWS, (0.213750, 0.266648, 3.05855), 2e-3),
    (8.0, 1.0, PEAKED, 1.0, np.pi, VIEWS, (0.379740, 0.519598, 0.493302), 1e-3),
    (8.0, 1.0, PEAKED, 1.0, -np.pi, VIEWS, (0.236362, 0.422350, 0.669581), 3e-4),
]


@pytest.mark.parametrize(("tau", "albedo", "moments", "sun", "irradiance", "views", "printed", "tolerance"), RADIANCES)
def test_radiances_equal_published_ones(tau, albedo, moments, sun, irradiance, views, printed, tolerance) -> None:
    chi = np.array(moments)[:, np.newaxis]
    found = solve_sun([[tau]], [albedo], chi, views, sun, [np.pi] * 3, 8, 16, exact_orders=1)
    face = found[0] if irradiance > 0 else found[1]
    np.testing.assert_allclose(face[0, 0] * sun * abs(irradiance), printed, rtol=tolerance)


# The same problems: diffuse fluxes up at the top and down at the base, for irradiance pi across the layer.
FLUXES = [
    (0.03125, 0.2, ISOTROPIC, 0.1, 1.0, 0.0799451, 0.0794108),
    (0.03125, 1.0, ISOTROPIC, 0.1, 1.0, 0.422922, 0.420233),
    (32.0, 0.2, ISOTROPIC, 0.1, 1.0, 0.259686, 0.0),
    (32.0, 1.0, ISOTROPIC, 0.1, 1.0, 3.07390, 0.0676954),
    (0.2, 0.5, RAYLEIGH, 0.080442, 0.080442, 0.0535063, 0.0441791),
    (5.0, 1.0, RAYLEIGH, 0.080442, 0.080442, 0.225915, 0.0268008),
    (1.0, 1.0, PEAKED, 1.0, 1.0, 0.247374, 1.73849),
    (8.0, 1.0, PEAKED, 1.0, 1.0, 1.59096, 1.54958),
]


@pytest.mark.parametrize(("tau", "albedo", "moments", "sun", "scale", "up", "down"), FLUXES)
def test_fluxes_equal_published_ones(tau, albedo, moments, sun, scale, up, down) -> None:
    layer = solve_layers([[tau]], [albedo], np.array(moments)[:, np.newaxis], [sun], 8)
    weight = 2.0 * np.pi * layer.mu * layer.weight
    reflected = weight @ layer.reflection[0, 0, :, 0] * np.pi * scale
    # Published diffuse flux includes the forward peak, which delta-M counts as direct.
    passed = weight @ layer.transmission[0, 0, :, 0] + layer.direct[0, 0, 0] - np.exp(-tau / sun)
    assert reflected == pytest.approx(up, rel=5e-6)
    assert passed * np.pi * scale == pytest.approx(down, rel=5e-6, abs=1e-6)


def chandrasekhar_h(albedo: float, mu: np.ndarray) -> np.ndarray:
    """H function of isotropic scattering by its integral equation (Radiative Transfer, section 38)."""
    node, weight = np.polynomial.legendre.leggauss(200)
    # Nodes gather at 0, where H has an infinite slope.
    s, ds = (0.5 * (node + 1.0)) ** 2, weight * 0.5 * (node + 1.0)
    h = np.ones_like(s)

    def sweep(at: np.ndarray, h: np.ndarray) -> np.ndarray:
        total = (s * h * ds) / (s + at[:, np.newaxis])
        return 1.0 / (np.sqrt(1.0 - albedo) + 0.5 * albedo * total.sum(axis=1))

    for _ in range(2000):
        new = 0.5 * (h + sweep(s, h))
        if np.max(np.abs(new - h)) < 1e-13:
            break
        h = new
    return sweep(mu, h)


def test_the_integral_equation_gives_the_table_of_chandrasekhar() -> None:
    mu = np.array(list(CONSERVATIVE_H))
    np.testing.assert_allclose(chandrasekhar_h(1.0, mu), list(CONSERVATIVE_H.values()), atol=6e-5)


@pytest.mark.parametrize("albedo", [0.3, 0.8, 0.99, 1.0])
def test_a_semi_infinite_isotropic_layer_reflects_as_the_h_functions_say(albedo) -> None:
    mu = np.array(list(CONSERVATIVE_H))
    layer = solve_layers([[1e7]], [albedo], [[1.0], [0.0]], mu, 32)
    h = chandrasekhar_h(albedo, mu)
    expected = albedo / (4 * np.pi) * np.outer(h, h) / np.add.outer(mu, mu)
    np.testing.assert_allclose(layer.reflection[0, 0, :10, :10], expected, rtol=3e-4)
    # Emissivity is H(mu) sqrt(1 - albedo): section 45.
    np.testing.assert_allclose(layer.emissivity[0, 0, :10], h * np.sqrt(1 - albedo), rtol=2e-5, atol=1e-12)
