"""Flows with published laws: a dry convective boundary layer, and a density current."""

import numpy as np
import pytest
from hcss_skies.les.case import case_of
from hcss_skies.les.model import Model
from hcss_skies.les.thermodynamics import GRAVITY
from les_cases import DRY, case

FLUX, LAPSE, BEGIN = 0.1, 0.006, 400.0
"""Surface flux (K m/s), stratification above (K/m), and initial depth (m) of the boundary layer."""


@pytest.fixture(scope="module")
def convection():
    """Means of a boundary layer that grows for 1.5 h: heights, and profiles of its last half hour."""
    model = Model(
        case(
            grid={"columns": [24, 24], "side_m": 75.0, "spacing_m": 50.0, "top_m": 2000.0, "sponge_bottom_m": 1700.0},
            air={"theta_l_K": [[0, 300.0], [BEGIN, 300.0], [2000, 300.0 + LAPSE * (2000 - BEGIN)]],
                 "water_g_kg": [[0, 0.0]], "noise_below_m": BEGIN},
            surface={"heat_K_m_s": FLUX}, precision="single", longest_step_s=8.0,
        )
    )  # fmt: skip
    variance, heights, fluxes = [], [], []
    for until in range(3600, 5401, 60):
        model.run_until(float(until))
        w = 0.5 * (model.w[..., 1:] + model.w[..., :-1])
        theta = model.theta_l.mean((0, 1), dtype=float)
        heights.append(model.mesh.faces_m[1:-1][np.diff(theta).argmax()])
        variance.append((w**2).mean((0, 1)))
        fluxes.append((w * (model.theta_l - theta.astype(np.float32))).mean((0, 1)))
    return model, np.mean(heights), np.mean(variance, 0), np.mean(fluxes, 0)


def test_a_dry_boundary_layer_grows_faster_than_by_encroachment_and_not_much(convection):
    _, depth, *_ = convection
    # h^2 = h_0^2 + 2 (1 + 2 A) F t / lapse; A = 0: encroachment, A = .2: usual entrainment (H. Tennekes, J. Atmos. Sci.
    # 30, 558 (1973), eq. 13); the mean of the last half hour
    grown = [np.sqrt(BEGIN**2 + 2.0 * (1.0 + 2.0 * a) * FLUX / LAPSE * 4500.0) for a in (0.0, 0.2, 0.4)]
    assert grown[0] < depth < grown[2]
    assert depth == pytest.approx(grown[1], rel=0.08)


def test_the_heat_of_a_dry_boundary_layer_is_that_of_the_surface_flux(convection):
    model, *_ = convection
    start = Model(model.case)
    gained = model.mass @ (model.theta_l.mean((0, 1), dtype=float) - start.theta_l.mean((0, 1), dtype=float))
    assert gained == pytest.approx(model.reference.density_at_faces[0] * FLUX * model.time_s, rel=1e-3)


def test_updraughts_of_a_dry_boundary_layer_follow_the_convective_velocity(convection):
    _, depth, variance, flux = convection
    scale = (GRAVITY / 300.0 * FLUX * depth) ** (1.0 / 3.0)
    # w'^2 / w*^2 = 1.8 (z/h)^(2/3) (1 - .8 z/h)^2, at most .43 (D. H. Lenschow et al., J. Atmos. Sci. 37, 1313 (1980), eq. 11)
    assert variance.max() / scale**2 == pytest.approx(0.43, abs=0.1)
    centres = 50.0 * np.arange(40) + 25.0
    assert 0.2 < centres[variance.argmax()] / depth < 0.6
    # the flux at the inversion is -.1 to -.3 of that at the surface (same, fig. 4; resolved part)
    assert -0.3 < flux.min() / FLUX < -0.05
    middle = (centres > 0.3 * depth) & (centres < 0.7 * depth)
    np.testing.assert_allclose(flux[middle], FLUX * (1.0 - 1.2 * centres[middle] / depth), atol=0.15 * FLUX)


def density_current(side_m):
    """The front (m from the middle) and the coldest theta (K) of a falling cold bubble after 900 s.

    J. M. Straka et al., Int. J. Numer. Methods Fluids 17, 1 (1993): a bubble of -15 K, 4 km wide and 2 km high, at 3 km.
    """
    columns = int(51200 / side_m)
    current = case_of(
        {
            **DRY,
            "grid": {"columns": [columns, 4], "side_m": side_m, "top_m": 6400.0, "spacing_m": side_m,
                     "sponge_bottom_m": 6300.0, "sponge_rate_s": 0.0},
            "air": {**DRY["air"], "theta_l_K": [[0, 300.0]], "noise_K": 0.0}, "precision": "single",
        },
        "test",
    )  # fmt: skip
    model = Model(current)
    x = side_m * (np.arange(columns) + 0.5) - 25600.0
    radius = np.minimum(np.hypot(x[:, None] / 4000.0, (model.mesh.centres_m - 3000.0) / 2000.0), 1.0)
    cold = -7.5 * (1.0 + np.cos(np.pi * radius)) / model.reference.exner
    model.theta_l[...] = cold[:, None, :]
    model.diagnose()
    model.run_until(900.0)
    lowest = model.theta_l[:, 0, 0]
    right = x > 0.0
    outside = np.flatnonzero(right & (lowest < -1.0))[-1]
    front = x[outside] + side_m * (lowest[outside] + 1.0) / (lowest[outside] - lowest[outside + 1])
    np.testing.assert_allclose(lowest, lowest[::-1], atol=0.2)
    return front, model.theta_l.min()


def test_the_front_of_a_density_current_is_where_published_models_have_it():
    front, coldest = density_current(200.0)
    print(front, coldest)


@pytest.mark.long
def test_the_front_of_a_finer_density_current_is_where_the_reference_has_it():
    front, coldest = density_current(100.0)
    print(front, coldest)
