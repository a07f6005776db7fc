"""Curves of reference columns against a radiance in closed form, and which scenes solve columns afresh."""

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.certificate.reference_columns import (
    AFRESH_COLUMNS,
    CURVE_SHARE,
    SOLVED_AFRESH,
    References,
    columns_afresh,
)
from hcss_twin.engine.certificate.reference_curve import reference_curve
from hcss_twin.providers import CloudLayer, Microphysics

LEVELS_M = np.arange(0.0, 20e3, 1e3)


def layer(low_m, high_m):
    particles = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
    return CloudLayer("cloud", 500.0, 500.0 + high_m, "base", low_m, 0.5, None, particles)


def grey_cloud(thickness_m):
    """Grey, isothermal in itself, with the temperature of a profile that has a kink at each level."""
    top = np.interp(500.0 + thickness_m, LEVELS_M, 290.0 - 6e-3 * LEVELS_M + 3.0 * np.sin(LEVELS_M))
    through = np.exp(-thickness_m / 40.0)
    return np.stack(((1.0 - through) * (top / 290.0) ** 4, 0.9 * through), axis=1)[..., None]


@pytest.mark.parametrize(("low_m", "high_m"), [(1.0, 3000.0), (700.0, 3000.0), (250.0, 250.0)])
def test_curves_follow_a_grey_cloud_between_the_kinks_of_the_profile(low_m, high_m):
    asked = []

    def columns(thickness_m):
        asked.append(thickness_m.size)
        return grey_cloud(thickness_m)

    curve = reference_curve(columns, layer(low_m, high_m), LEVELS_M, 1e-6)
    thickness = np.geomspace(low_m, high_m, 1001)
    exact = grey_cloud(thickness)
    assert curve.columns == asked[-1]
    assert curve.error <= 1e-6
    assert (
        np.max(
            np.abs(curve.terms(layer(low_m, high_m), LEVELS_M, thickness) - exact) / exact.sum(axis=1, keepdims=True)
        )
        <= 1e-6
    )


def test_jumps_have_no_curve():
    assert (
        reference_curve(lambda h: np.where(h > 77.0, 2.0, 1.0)[:, None, None], layer(10.0, 900.0), LEVELS_M, 1e-3)
        is None
    )


def test_certificates_read_from_curves_what_columns_give():
    plan = make_plan(Scenario.load("cirrus-over-cumulus", CHEAP | {"bands": ["lwir-10.8"]}))
    low, high = plan.layers
    thickness = np.zeros((9, 2))
    thickness[1:4, 0] = np.geomspace(low.thickness_min_m, low.thickness_max_m, 3)
    thickness[3:7, 1] = np.geomspace(high.thickness_min_m, high.thickness_max_m, 4)
    exact, curves = References(), References(from_curves=True)
    suns = [plan.sun_up_at(0.0)] * len(thickness)
    terms = curves.terms(plan, thickness, suns)
    np.testing.assert_allclose(terms, exact.terms(plan, thickness, suns), rtol=1e-5, atol=1e-7)
    assert curves.read == 5  # one column has cloud in both layers, three have none
    assert exact.interpolation == ""
    assert f"{curves.read} columns is interpolated between {curves.curve_columns} reference" in curves.interpolation


def test_all_columns_of_curves_are_solved_afresh_and_the_certificate_says_how_far_they_are():
    plan = make_plan(Scenario.load("stratus", CHEAP | {"bands": ["lwir-10.8"]}))
    least, most = 1.01 * plan.layers[0].thickness_min_m, 0.99 * plan.layers[0].thickness_max_m  # no nodes of the curve
    thickness = np.append(0.0, np.geomspace(least, most, 8))[:, None]
    exact, curves, checked = References(), References(from_curves=True), References(from_curves=True, afresh=3)
    suns = [plan.sun_up_at(0.0)] * len(thickness)
    terms = checked.terms(plan, thickness, suns)
    own = np.any(terms != curves.terms(plan, thickness, suns), axis=(1, 2))
    assert np.count_nonzero(own) == checked.checked == 8
    assert not own[0]  # clear sky is on no curve
    # The change on the next finer spectral grid is interpolated between few of the columns of a call.
    np.testing.assert_allclose(terms[own], exact.terms(plan, thickness, suns)[own], rtol=1e-6, atol=1e-5)
    assert 0.0 < checked.check_error < 1e-5
    assert "8 of the columns are solved afresh" in checked.interpolation


def test_a_tenth_of_the_scenes_solves_columns_afresh():
    drawn = [columns_afresh(Scenario.load("stratus", {"seed": number})) for number in range(200)]
    assert set(drawn) == {0, AFRESH_COLUMNS}
    assert np.count_nonzero(drawn) == pytest.approx(200 / SOLVED_AFRESH, abs=13)


@pytest.mark.parametrize("afresh", [0, 3])
@pytest.mark.parametrize("vapour", [0.0, 0.05])
def test_certificates_read_from_curves_how_columns_change_with_texture(vapour, afresh):
    texture = {"sea": {"temperature_texture": 0.3}, "atmosphere": {"water_vapour_texture": vapour}}
    plan = make_plan(Scenario.load("stratus", CHEAP | {"bands": ["lwir-10.8"]} | texture))
    least, most = 1.01 * plan.layers[0].thickness_min_m, 0.99 * plan.layers[0].thickness_max_m  # no nodes of the curve
    thickness = np.append(0.0, np.geomspace(least, most, 8))[:, None]
    suns, curves = [plan.sun_up_at(0.0)] * len(thickness), References(from_curves=True, afresh=afresh)
    states, exact = (each.perturbed(plan, thickness, suns) for each in (curves, References()))
    total = exact.sum(axis=2, keepdims=True)
    assert np.max(np.abs(exact - exact[0]) / total) > 1e-4
    allowed = 1e-12 if afresh else CURVE_SHARE * plan.accuracy.relative
    away = np.max(np.abs((states - states[0]) - (exact - exact[0])) / total)
    assert away <= allowed
    assert afresh or away > 0.0  # they are read, not solved
    assert (curves.check_error > 0.0) == (afresh > 0)
    assert curves.read == curves.checked == 0  # columns are counted once, where those of the scene are asked for
