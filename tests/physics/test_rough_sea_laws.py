"""Laws of the rough sea: limits, balance, reciprocity, what each choice does."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import CoxMunkParameters, RoughSeaParameters
from hcss_twin.models.radiance.physical.directions import column_directions
from hcss_twin.models.radiance.physical.numerics import LEVELS
from hcss_twin.models.radiance.physical.sea_surface import sunlit, unlit_sea_modes, unlit_sea_surface
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.models.sea.facets import incidence_nodes
from hcss_twin.models.sea.reflection import INCIDENCE_COUNT, Reflection
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.models.sea.sea_water import load_sea_water
from hcss_twin.models.sea.slope_statistics import slope_statistics
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.geometry import wind_azimuths
from hcss_twin.providers import SeaInputs, Sun, View

# 14, 11, 8.5, 4, 3.1 and 2.75 um
WAVENUMBER = 1e4 / np.array([14.0, 11.0, 8.5, 4.0, 3.1, 2.75])
PLAIN = {"foam": False, "salinity_psu": 0.0, "water_temperature": False}
SLOPES = ("isotropic", "upwind-crosswind", "gram-charlier")


def inputs(wind, temperature_K=290.0):
    return SeaInputs(wind, 0.0, temperature_K, Catalog())


def sea(wind, temperature_K=290.0, **parameters):
    return RoughSea(inputs(wind, temperature_K), RoughSeaParameters(**parameters))


def reflectance():
    """Fresnel reflectance (incidences, wavenumbers) of the water of :func:`sea`."""
    usual = RoughSeaParameters()
    water = load_sea_water(Catalog(), usual.water_index, 290.0, usual.salinity_psu, by_temperature=True)
    return unpolarised_reflectance(water.at(WAVENUMBER), incidence_nodes(INCIDENCE_COUNT)[:, None])


def first_hits(wind, slopes, view, bearing=None):
    """What facets of the sea reflect into a view: from the sky, and from the sea."""
    reflection = Reflection(slope_statistics(wind, slopes), "height-correlated", re_reflection=True)
    return reflection.first(view, np.ones(1), "linear", bearing)


def hemisphere(mu_count=200, azimuth_count=160):
    """Cosines, relative azimuths and weights of cos(theta) dOmega, both halves of the azimuth."""
    x, w = np.polynomial.legendre.leggauss(mu_count)
    y, v = np.polynomial.legendre.leggauss(azimuth_count)
    mu, azimuth = np.meshgrid(0.5 * (x + 1.0), 0.5 * np.pi * (y + 1.0), indexing="ij")
    weight = mu * (0.5 * w)[:, None] * (np.pi * v)[None, :]
    return mu.ravel(), azimuth.ravel(), weight.ravel()


def test_without_its_additions_it_is_the_cox_munk_sea():
    bare = sea(10.0, **PLAIN, shadowing="none", re_reflection=False)
    plain = CoxMunkSea(inputs(10.0), CoxMunkParameters())
    mu = np.linspace(0.02, 1.0, 9)
    azimuth = np.linspace(0.0, np.pi, 9)
    np.testing.assert_allclose(bare.emissivity(WAVENUMBER, mu), plain.emissivity(WAVENUMBER, mu), atol=1e-9)
    np.testing.assert_allclose(
        bare.brdf(WAVENUMBER, mu, mu[::-1], azimuth), plain.brdf(WAVENUMBER, mu, mu[::-1], azimuth), rtol=1e-12
    )


@pytest.mark.parametrize("slopes", SLOPES)
def test_a_calm_sea_emits_one_minus_fresnel(slopes):
    index = load_refractive_index(Catalog(), "water").at(WAVENUMBER)
    mu = np.cos(np.radians([0.0, 30.0, 60.0]))
    found = sea(0.0, **PLAIN, slopes=slopes).emissivity(WAVENUMBER, mu)
    np.testing.assert_allclose(found, 1.0 - unpolarised_reflectance(index, mu[:, None]), rtol=0.0, atol=0.0015)


@pytest.mark.parametrize("zenith_deg", [0.0, 40.0, 60.0, 70.0])
def test_what_is_not_emitted_is_reflected_once_or_twice(zenith_deg):
    """The BRDF's integral over directions is the slopes' integral over escaping rays; the rest is the second hit."""
    mu, azimuth, weight = hemisphere()
    view = np.array([np.cos(np.radians(zenith_deg))])
    model = sea(10.0, foam=False)
    once = weight @ model.brdf(WAVENUMBER, np.full(mu.size, view[0]), mu, azimuth)
    hits = first_hits(10.0, "isotropic", float(view[0]))
    np.testing.assert_allclose(once, (hits.sky @ reflectance())[0], rtol=0.0, atol=1e-4)
    again = (hits.sea @ reflectance()).sum(axis=0)
    missed = 1.0 - model.emissivity(WAVENUMBER, view)[0] - once
    assert np.all((missed > -1e-4) & (missed < again + 1e-4))


@pytest.mark.parametrize("bearing_deg", [0.0, 50.0, 130.0])
def test_at_every_bearing_the_brdf_reflects_what_escapes_from_the_facets(bearing_deg):
    mu, azimuth, weight = hemisphere()
    view, wind = np.array([np.cos(np.radians(65.0))]), np.array([np.radians(bearing_deg)])
    model = sea(10.0, foam=False, slopes="upwind-crosswind")
    # Each half of the azimuth has its own bearing: the mirror image turns the second into the first.
    halves = [
        0.5 * weight @ model.brdf(WAVENUMBER, np.full(mu.size, view[0]), mu, azimuth, np.full(mu.size, sense * wind))
        for sense in (1.0, -1.0)
    ]
    hits = first_hits(10.0, "upwind-crosswind", float(view[0]), float(wind[0]))
    np.testing.assert_allclose(sum(halves), (hits.sky @ reflectance())[0], rtol=0.0, atol=1e-4)


@pytest.mark.parametrize("wind", [5.0, 15.0])
def test_unshadowed_facets_reflect_more_than_there_is_beyond_80_degrees(wind):
    """A mirror that absorbs nothing shows the energy that the BRDF gains when waves do not hide one another."""
    mu, azimuth, weight = hemisphere(200, 100)
    gained = {}
    for shadowing in ("none", "height-correlated"):
        model = sea(wind, shadowing=shadowing, foam=False)
        view = np.full(mu.size, np.cos(np.radians(85.0)))
        once = weight @ model.brdf(WAVENUMBER, view, mu, azimuth)
        gained[shadowing] = once + model.emissivity(WAVENUMBER, view[:1])[0]
    assert np.all(gained["none"] > 1.01)
    assert np.all(gained["height-correlated"] < 1.0)


@pytest.mark.parametrize("slopes", SLOPES)
@pytest.mark.parametrize("bearing", [None, 0.7])
def test_the_emissivity_does_not_depend_on_what_was_asked_before(slopes, bearing):
    mu = np.cos(np.radians([0.0, 80.0]))
    turn = None if bearing is None else np.full(mu.size, bearing)
    nodes = np.polynomial.legendre.leggauss(8)[0] * 0.5 + 0.5
    asked, fresh = sea(9.0, slopes=slopes), sea(9.0, slopes=slopes)
    asked.reflection_weights(WAVENUMBER, mu, nodes, wind_azimuth=turn)
    # Another bearing is not it.
    asked.reflection_weights(WAVENUMBER, mu, nodes, wind_azimuth=np.full(mu.size, 2.0))
    expected = fresh.emissivity(WAVENUMBER, mu, wind_azimuth=turn)
    np.testing.assert_array_equal(asked.emissivity(WAVENUMBER, mu, wind_azimuth=turn), expected)


def test_a_calm_sea_mirrors_the_sky_at_the_angle_of_view():
    nodes = np.linspace(0.01, 1.0, 100)
    mu = np.array([0.4, 0.7, 0.95])
    weights = sea(0.0).reflection_weights(WAVENUMBER, mu, nodes, "linear")
    seen = np.einsum("mnv,n->mv", weights, nodes) / weights.sum(axis=1)
    np.testing.assert_allclose(seen, np.broadcast_to(mu[:, None], seen.shape), atol=0.02)


def test_emissivity_at_large_angles_rises_with_wind_only_with_the_second_reflection():
    """As Wu and Smith (1997) and Hanafin and Minnett (2005) measured at 55 to 70 degrees."""
    view = np.cos(np.radians([65.0]))
    series = {
        on: [sea(w, foam=False, re_reflection=on).emissivity(WAVENUMBER[1:2], view).item() for w in (5, 10, 15)]
        for on in (True, False)
    }
    assert np.all(np.diff(series[True]) > 0.002)
    assert np.all(np.diff(series[False]) < 0.0)


def test_the_sea_across_the_wind_looks_calmer_than_along_it():
    model = sea(10.0, slopes="upwind-crosswind")
    mu = np.cos(np.radians([80.0, 80.0]))
    along, across = model.emissivity(WAVENUMBER[1:2], mu, np.array([0.0, np.pi / 2]))[:, 0]
    mean = model.emissivity(WAVENUMBER[1:2], mu[:1]).item()
    assert across < mean < along


def test_the_most_probable_facet_rises_downwind():
    """The windward faces of waves are long and gentle, the lee faces short and steep."""
    model = sea(12.0, slopes="gram-charlier", foam=False)
    sun = np.full(1, np.cos(np.radians(20.0)))
    # At nadir, a facet that rises downwind leans toward the wind: it mirrors a sun that stands upwind.
    upwind, downwind = (model.brdf(WAVENUMBER[3:4], np.ones(1), sun, np.zeros(1), np.full(1, a)) for a in (0, np.pi))
    assert upwind.item() > 1.02 * downwind.item()


def test_bearings_follow_from_compass_directions():
    rng = np.random.default_rng(2)
    for sensor, sun, wind in rng.uniform(0.0, 360.0, (50, 3)):
        relative, bearing = wind_azimuths(sensor, sun, wind)
        assert 0.0 <= relative <= np.pi
        cosines = np.cos(np.radians([sensor - sun, sensor - wind, sun - wind]))
        np.testing.assert_allclose(np.cos([relative, bearing, bearing + relative]), cosines, atol=1e-12)


def test_cold_water_and_salt_change_the_emissivity_by_the_amounts_known():
    mu = np.cos(np.radians([55.0]))
    wavenumber = np.array([800.0, 900.0])
    cold, warm = (sea(5.0, t, foam=False).emissivity(wavenumber, mu)[0] for t in (278.15, 303.15))
    # Newman et al. (2005): near 800 cm-1 emissivity falls with cooling, by some thousandths over 25 K.
    assert 0.001 < warm[0] - cold[0] < 0.012
    fresh = sea(5.0, foam=False, salinity_psu=0.0).emissivity(wavenumber, mu)[0]
    salt = sea(5.0, foam=False).emissivity(wavenumber, mu)[0]
    assert np.all((fresh - salt > 0.0) & (fresh - salt < 0.002))


def test_at_the_temperatures_of_the_tables_the_index_is_the_tables():
    for temperature, name in ((273.15, "water-273K"), (298.15, "water")):
        model = sea(0.0, temperature, foam=False, salinity_psu=0.0)
        index = load_refractive_index(Catalog(), name)
        table = RoughSea(
            inputs(0.0, temperature),
            RoughSeaParameters(foam=False, salinity_psu=0.0, water_temperature=False, water_index=name),
        )
        mu = np.array([0.5, 1.0])
        low, high = index.valid_cm1
        wavenumber = WAVENUMBER[(low < WAVENUMBER) & (high > WAVENUMBER)]
        np.testing.assert_allclose(model.emissivity(wavenumber, mu), table.emissivity(wavenumber, mu), atol=1e-12)


def test_foam_shines_in_the_short_waves_and_hides_the_glint():
    calm, storm = sea(20.0, foam=False), sea(20.0)
    away = (np.ones(1), np.full(1, 0.1), np.zeros(1))
    wavenumber = np.array([900.0, 1e4 / 1.0])
    without, with_foam = calm.brdf(wavenumber, *away)[0], storm.brdf(wavenumber, *away)[0]
    expected = storm.foam_coverage * np.array([0.02, 0.11]) / np.pi
    np.testing.assert_allclose(with_foam - without * (1.0 - storm.foam_coverage), expected, rtol=1e-9)
    glint = (np.full(1, 0.8), np.full(1, 0.8), np.full(1, np.pi))
    assert storm.brdf(wavenumber, *glint)[0, 0] < calm.brdf(wavenumber, *glint)[0, 0]


def test_azimuth_modes_of_the_finest_level_give_back_the_glint_of_a_calm_sea():
    """24 modes miss it by 8 % of its peak, and light from a thin cloud over it oscillates from level to level."""
    finest, calm = LEVELS[-1], sea(0.5)
    directions = column_directions(View(53.0, 0.0), None, 0.0, finest.streams)
    modes = unlit_sea_modes(calm, WAVENUMBER[3:4], directions, finest.turned_modes).view[..., 0]
    steep = directions.streams.mu > 0.3
    azimuth = np.linspace(0.0, np.pi, 181)
    pairs = [each.ravel() for each in np.meshgrid(directions.streams.mu[steep], azimuth, indexing="ij")]
    exact = calm.brdf(WAVENUMBER[3:4], np.full(pairs[0].size, np.cos(np.radians(53.0))), *pairs)[:, 0]
    exact = exact.reshape(-1, azimuth.size)
    mean = np.trapezoid(exact, azimuth, axis=1) / np.pi
    turns = np.cos(np.arange(1, finest.turned_modes)[:, None] * azimuth)
    series = mean[:, None] + 2.0 * modes[:, steep].T @ turns
    np.testing.assert_allclose(series, exact, rtol=0.0, atol=1e-3 * exact.max())


@pytest.mark.parametrize("slopes", ["isotropic", "upwind-crosswind"])
@pytest.mark.parametrize("tilt", [None, (0.05, -0.03)])
def test_a_sea_asked_for_its_light_toward_the_view_alone_answers_as_for_all_directions(slopes, tilt):
    whole = sea(8.0, slopes=slopes)
    model = whole if tilt is None else whole.tilted(*tilt, 20.0)
    directions = column_directions(View(35.0, 20.0), Sun(50.0, 190.0, 1.0), 270.0, 6)
    every, seen = (
        sunlit(unlit_sea_surface(model, WAVENUMBER, directions, view_only=only), model, WAVENUMBER, directions)
        for only in (False, True)
    )
    for name in ("emissivity", "reflection", "sun"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(every, name)[:1])
    assert np.all(seen.sun > 0.0)
