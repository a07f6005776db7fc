"""The parts of the rough sea: densities, shadowing, bases, water, foam; refusals and notes."""

import weakref

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.parameters import RoughSeaParameters
from hcss_twin.models.sea.facets import smith_lambda
from hcss_twin.models.sea.reflection import Reflection, basis_values, checked_nodes, gathered_linearly
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.sea_water import foam_coverage, foam_reflectance
from hcss_twin.models.sea.slope_statistics import slope_statistics
from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.providers import SeaInputs


def sea(wind=5.0, temperature_K=290.0, **parameters):
    return RoughSea(SeaInputs(wind, 0.0, temperature_K, Catalog()), RoughSeaParameters(**parameters))


@pytest.mark.parametrize("wind", [0.0, 0.5, 1.0, 10.0, 20.0])
@pytest.mark.parametrize("law", ["isotropic", "upwind-crosswind", "gram-charlier"])
def test_densities_integrate_to_one_with_the_laws_variances(wind, law):
    slopes = slope_statistics(wind, law)
    axis = np.linspace(-8.0, 8.0, 801)
    up, across = axis * np.sqrt(slopes.variance_upwind), axis * np.sqrt(slopes.variance_crosswind)
    density = slopes.density(up[:, None], across[None, :]) * (up[1] - up[0]) * (across[1] - across[0])
    assert density.min() >= 0.0
    assert density.sum() == pytest.approx(1.0, abs=1e-4)
    if law != "gram-charlier":
        assert (density * up[:, None] ** 2).sum() == pytest.approx(slopes.variance_upwind, rel=1e-6)
        assert (density * across[None, :] ** 2).sum() == pytest.approx(slopes.variance_crosswind, rel=1e-6)


def test_upwind_and_crosswind_variances_have_cox_and_munks_coefficients():
    slopes = slope_statistics(10.0, "upwind-crosswind")
    assert slopes.variance_upwind == pytest.approx(0.0316, rel=1e-12)
    assert slopes.variance_crosswind == pytest.approx(0.0222, rel=1e-12)
    below, above = (slope_statistics(w, "upwind-crosswind").variance_upwind for w in (0.999999, 1.000001))
    assert below == pytest.approx(above, rel=1e-5)


def test_smiths_lambda_is_the_area_of_facets_turned_away():
    """1 + Lambda is the integral of the projected areas of the facets turned toward the view."""
    variance = 0.03
    slope = np.linspace(-2.0, 2.0, 400_001)
    density = np.exp(-0.5 * slope**2 / variance) / np.sqrt(2.0 * np.pi * variance)
    for mu in (0.05, 0.2, 0.5):
        seen = np.maximum(mu - slope * np.sqrt(1.0 - mu**2), 0.0)
        expected = (seen * density).sum() * (slope[1] - slope[0]) / mu - 1.0
        assert smith_lambda(np.array(mu), variance).item() == pytest.approx(expected, abs=1e-8)
    assert smith_lambda(np.array(1.0), variance).item() == 0.0


@pytest.mark.parametrize("basis", ["linear", "lagrange"])
def test_bases_reproduce_the_nodes_and_straight_lines(basis):
    nodes = np.array([0.1, 0.3, 0.6, 0.9])
    np.testing.assert_allclose(basis_values(nodes, nodes, basis), np.eye(4), atol=1e-14)
    mu = np.linspace(0.1, 0.9, 33)
    np.testing.assert_allclose(basis_values(mu, nodes, basis) @ (2.0 - nodes), 2.0 - mu, atol=1e-13)
    np.testing.assert_allclose(basis_values(np.array([0.001, 1.0]), nodes, basis).sum(axis=1), 1.0, atol=1e-12)


@pytest.mark.parametrize("count", [64, 200])
def test_many_gauss_nodes_interpolate_themselves(count):
    nodes = gauss_streams(count).mu
    np.testing.assert_allclose(basis_values(nodes, nodes, "lagrange"), np.eye(count), atol=1e-14)


def test_values_are_gathered_as_the_linear_basis_says():
    random = np.random.default_rng(2)
    mu, nodes, values = random.uniform(-0.2, 1.2, 50), np.linspace(0.0, 1.0, 7), random.random((50, 3))
    expected = basis_values(mu, nodes, "linear").T @ values
    np.testing.assert_allclose(gathered_linearly(mu, nodes, values), expected, atol=1e-13)


@pytest.mark.parametrize("nodes", [[], [0.0, 0.5], [0.5, 0.4], [0.5, 1.1], [[0.5]], [np.nan]])
def test_nodes_that_cannot_be_are_refused(nodes):
    with pytest.raises(ValueError, match="mu_nodes"):
        checked_nodes(np.array(nodes))


def test_foam_laws_have_their_published_coefficients():
    assert foam_coverage(10.0, "monahan-1980-least-squares") == pytest.approx(2.95e-6 * 10.0**3.52, rel=1e-12)
    assert foam_coverage(10.0, "monahan-1980") == pytest.approx(3.84e-6 * 10.0**3.41, rel=1e-12)
    assert foam_coverage(10.0, "monahan-1986") == pytest.approx(1.95e-5 * 10.0**2.55, rel=1e-12)
    assert foam_coverage(0.0, "monahan-1980") == 0.0
    assert foam_coverage(60.0, "monahan-1980") == 1.0
    found = foam_reflectance(1e4 / np.array([10.0, 2.5, 1.65, 0.86, 0.5]), 0.98)
    np.testing.assert_allclose(found, [0.02, 0.02, 0.22 * 0.175, 0.22 * 0.61, 0.22], rtol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wind": 60.1}, r"wind_speed_m_s 60.1: allowed 0 to 60"),
        ({"wind": 20.1, "slopes": "gram-charlier"}, r"sea.wind_speed: 20.1 m/s with .*'gram-charlier'; .* 0 to 20"),
        ({"temperature_K": 250.0}, r"sea.temperature: 250 K .* 263.15 to 318.15.*water_temperature"),
    ],
)
def test_what_the_sea_cannot_be_is_refused(changes, message):
    with pytest.raises((ValueError, ScenarioError), match=message):
        sea(**changes)


def test_arguments_out_of_range_are_refused_by_name():
    model, nu, one = sea(), np.array([900.0]), np.ones(1)
    with pytest.raises(ValueError, match="mu between"):
        model.emissivity(nu, np.zeros(1))
    with pytest.raises(ValueError, match="wind_azimuth"):
        model.emissivity(nu, one, np.zeros(2))
    with pytest.raises(ValueError, match="relative_azimuth"):
        model.brdf(nu, one, one, np.array([4.0]))
    with pytest.raises(ValueError, match="covers"):
        model.emissivity(np.array([60_000.0]), one)


def test_notes_say_what_is_extrapolated_or_left_out():
    assert sea().declares.notes == ()
    assert any("Cox and Munk" in note for note in sea(20.0).declares.notes)
    assert any("extrapolated" in note for note in sea(temperature_K=303.0).declares.notes)
    assert any("hide" in note for note in sea(shadowing="none").declares.notes)
    assert any("second reflection" in note for note in sea(re_reflection=False).declares.notes)
    young, old = (sea(spectrum="jonswap", fetch_m=fetch).declares.notes for fetch in (1e4, 1e5))
    assert young == ()
    assert any("fully developed" in note for note in old)
    assert any("under foam" in note for note in sea(30.0).declares.notes)


def test_repeated_views_give_the_same_and_do_not_pile_up(monkeypatch):
    model, nu, nodes = sea(), np.array([900.0]), np.array([0.3, 0.8])
    made, first_of = [], Reflection.first

    def recorded(*arguments):
        found = first_of(*arguments)
        made.append(weakref.ref(found))
        return found

    monkeypatch.setattr(Reflection, "first", recorded)
    first = model.reflection_weights(nu, np.array([0.5]), nodes)
    for mu in np.linspace(0.1, 0.9, 100):
        model.reflection_weights(nu, np.array([mu]), nodes)
    np.testing.assert_array_equal(model.reflection_weights(nu, np.array([0.5]), nodes), first)
    assert len(made) >= 100
    assert sum(each() is not None for each in made) <= 64


@pytest.mark.parametrize("slopes", ["isotropic", "upwind-crosswind"])
def test_a_view_is_folded_once_and_reflects_the_same_alone_and_among_others(slopes, monkeypatch):
    model, nu = sea(slopes=slopes), np.array([900.0, 2500.0])
    mu, nodes, wind = np.array([0.3, 0.6, 0.95]), np.array([0.2, 0.5, 0.9]), np.array([0.1, 1.0, 2.0])
    together = model.reflection_weights(nu, mu, nodes, "linear", wind)
    alone = [sea(slopes=slopes).reflection_weights(nu, mu[[i]], nodes, "linear", wind[[i]])[0] for i in range(3)]
    np.testing.assert_allclose(together, alone, rtol=1e-12, atol=1e-15)
    asked, first = [], Reflection.first
    monkeypatch.setattr(Reflection, "first", lambda of, view, *rest: asked.append(view) or first(of, view, *rest))
    model.reflection_weights(nu, np.append(mu, 0.7), nodes, "linear", np.append(wind, 3.0))
    assert asked == [0.7]
