"""Waves, shadows, parallax and views of a grid together, against formulas and geometry of each."""

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import pytest
from cheap import CHEAP
from hand_made import paths_of, with_clouds
from surface_files import write_half

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.engine import stream as stream_module
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import PartMaker, stream
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan import scene_analysis
from hcss_twin.plan.windows import windows
from hcss_twin.providers import Sun, View

THIN = {"type": "cumulus", "base": 1000.0, "top": 1010.0, "thickness_min": 1.0, "anchor": "base"}
THICK = THIN | {"top": 1900.0}
SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 24, "columns": 40, "pixel_size": 2.0},
    "frames": {"count": 1},
    "view": {"zenith": 40.0, "azimuth": 160.0},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
    "sea": {"temperature": 291.4, "wind_speed": 8.0, "temperature_texture": 0.0, "model": "rough-sea"},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "accuracy": 3e-3,
    "output": {"variables": ["all"], "certificate": 0},
    "seed": 3,
}
SUN = Sun(45.0, 0.0, 1.0)
STRIPES = np.array([0.0, 1.0, 3.0, 10.0])
"""Thickness of the cloud over every fourth column, north of the image on the paths of the sun."""


def plan_of(layer, **changes):
    clouds = {"layers": [{"coverage": 0.4, "coverage_mode": "field"} | layer]}
    return make_plan(Scenario.from_dict(SCENE | {"clouds": clouds}, {**CHEAP, "sea.model": "rough-sea", **changes}))


@lru_cache
def waves_below(thick):
    """Resolved waves in the shadow of stripes, and in full sun."""
    plan = plan_of(THICK if thick else THIN, **{"sea.waves": "on"})
    stripes = STRIPES * (90.0 if thick else 1.0)
    made = []
    for shadows in (True, False):
        slant = paths_of(shadows, False, plan.view, np.array([SUN.zenith_deg]), np.array([SUN.azimuth_deg]))
        shape = lambda y, x: np.where(y > 200, stripes[x % 4], 0.0)  # noqa: E731
        planned = with_clouds(plan, [shape], slant, SUN, shadows=shadows, waves=True)
        made.append((planned, next(stream(planned, compile_tables(planned)))))
    return made


def tilted(plan, upwind, crosswind):
    """Spectra of the terms over a sea that waves tilt, clockwise from the wind."""
    sea = plan.assembly.sea.tilted(upwind, crosswind, plan.grid.pixel_size_m)
    return plan.assembly.over_sea(sea).clear(plan.spectral_grid.wavenumber_cm1, SUN)


def along_and_across(plan, x, y):
    """Slopes along the wind and across it; the models count from the sensor toward the sun, here anticlockwise."""
    wind = np.radians(plan.scenario.sea.wind_from)
    return x * np.sin(wind) + y * np.cos(wind), -(x * np.cos(wind) - y * np.sin(wind))


def mean_over_waves(plan, name):
    """Bands of a term, averaged over Gaussian slopes."""
    places, weights = np.polynomial.hermite_e.hermegauss(9)
    spectrum = sum(
        a * b * tilted(plan, u * plan.waves.rms[0], c * plan.waves.rms[1])[name]
        for u, a in zip(places, weights, strict=True)
        for c, b in zip(places, weights, strict=True)
    )
    return plan.spectral_grid.weights_cm1 @ spectrum / np.sum(weights) ** 2


@pytest.mark.long
def test_a_wave_in_shadow_loses_the_share_of_its_own_glint_that_the_cloud_keeps():
    """The glint of tilted facets, from the formulas of sea and air, behind a cloud of Bouguer at each wavenumber."""
    plan, made = waves_below(False)[0]
    weights, wavenumber = plan.spectral_grid.weights_cm1, plan.spectral_grid.wavenumber_cm1
    extinction = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, wavenumber).extinction_m1
    mean_sea = weights @ plan.assembly.clear(wavenumber, SUN)["sea_reflected_sun"]
    level = mean_sea / mean_over_waves(plan, "sea_reflected_sun")
    total = made["radiance"].astype(float)
    rows, columns = np.random.default_rng(1).integers((0, 0), (24, 10), (12, 2)).T
    for number, thickness in enumerate(STRIPES):
        for y, x in zip(rows, 4 * columns + number, strict=True):
            slopes = along_and_across(plan, float(made["sea_slope_x"][y, x]), float(made["sea_slope_y"][y, x]))
            glint = tilted(plan, *slopes)["sea_reflected_sun"]
            behind = np.exp(-extinction * thickness / np.cos(np.radians(SUN.zenith_deg)))
            expected = level * (weights @ (glint * behind))
            error = np.abs(made["radiance_sea_reflected_sun"][:, y, x] - expected) / total[:, y, x]
            assert np.max(error) < 5e-4
            assert made["shadow_mask"][y, x] == (thickness > 0)


def test_behind_an_opaque_cloud_only_the_thermal_change_of_waves_is_left():
    (_, shaded), (_, sunlit) = waves_below(True)
    opaque = np.s_[:, :, 3::4]
    glint = sunlit["radiance_sea_reflected_sun"][opaque].astype(float)
    assert glint[0].std() > 0.1 * glint[0].mean()
    assert np.max(shaded["radiance_sea_reflected_sun"][opaque]) <= 1e-7 * np.max(glint)
    expected = sunlit["radiance"][opaque] - glint
    np.testing.assert_allclose(shaded["radiance"][opaque], expected, rtol=1e-6)
    thermal = shaded["radiance_sea_emission"]
    np.testing.assert_array_equal(thermal, sunlit["radiance_sea_emission"])
    assert thermal[1].std() > 1e-3 * thermal[1].mean()


@pytest.mark.parametrize("thick", [False, True])
def test_waves_in_shadow_are_the_sum_of_their_terms_and_none_is_negative(thick):
    made = waves_below(thick)[0][1]
    terms = [values.astype(float) for name, values in made.items() if name.startswith("radiance_")]
    assert min(values.min() for values in terms) >= 0.0
    np.testing.assert_allclose(np.sum(terms, axis=0), made["radiance"], rtol=1e-6)


def test_a_pixel_of_waves_in_half_shadow_counts_its_points():
    """Of four points two are in shadow: the pixel is their mean, each with its own slope."""
    fine = waves_below(True)[0][1]
    plan = plan_of(THICK, **{"sea.waves": "on", "image.samples_per_pixel": 2} | HALF)
    slant = paths_of(True, False, plan.view, np.array([SUN.zenith_deg]), np.array([SUN.azimuth_deg]))
    shape = lambda y, x: np.where(y > 200, (STRIPES * 90.0)[x % 4], 0.0)  # noqa: E731
    planned = with_clouds(plan, [shape], slant, SUN, shadows=True, waves=True)
    coarse = next(stream(planned, compile_tables(planned)))
    for name in ("radiance", "radiance_sea_reflected_sun"):
        blocks = fine[name].astype(float).reshape(2, 12, 2, 20, 2)
        np.testing.assert_allclose(coarse[name], blocks.mean(axis=(2, 4)), rtol=1e-5, atol=1e-8)


HALF = {"image.rows": 12, "image.columns": 20, "image.pixel_size": 4.0}


# --- lines of sight of their own ----------------------------------------------------------

EARTH_M = 6_371_008.8
HIGH = {"type": "cirrus", "base": 9000.0, "top": 10_000.0, "thickness_min": 1.0, "anchor": "top"}
LOW_ORBIT = {
    "view": {"zenith": 20.0, "azimuth": 250.0},
    "platform.altitude": "100 km",
    "image": {"rows": 60, "columns": 80, "pixel_size": 500.0},
    "accuracy": 1e-2,
    "sea.waves": "off",
}


def displaced_m(x, y, height, zenith=20.0, azimuth=250.0, altitude=100e3):
    """East and north from a point of the plane to where its line of sight passes a height, above a sphere."""
    zenith, azimuth = np.radians((zenith, azimuth))
    along = np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)
    down = EARTH_M * np.cos(zenith)
    distance = -down + np.sqrt(down**2 + altitude * (2.0 * EARTH_M + altitude))
    sensor = np.array([0.0, 0.0, EARTH_M]) + distance * np.array(along)
    bearing, arc = np.arctan2(x, y), np.hypot(x, y) / EARTH_M
    outward = np.array([np.sin(bearing), np.cos(bearing), 0.0])
    up = np.sin(arc) * outward + np.cos(arc) * np.array([0.0, 0.0, 1.0])
    ahead = np.cos(arc) * outward - np.sin(arc) * np.array([0.0, 0.0, 1.0])
    aside = np.array([np.cos(bearing), -np.sin(bearing), 0.0])
    ray = sensor - EARTH_M * up
    ahead_m, aside_m = (height * (ray @ axis) / (ray @ up) for axis in (ahead, aside))
    return ahead_m * outward[:2] + aside_m * aside[:2]


def middle_of(row, column, image):
    """Place of a pixel in the plane, east and north of its centre."""
    size = image["pixel_size"]
    return (column + 0.5 - 0.5 * image["columns"]) * size, (row + 0.5 - 0.5 * image["rows"]) * size


NAMES = "sun_zenith_deg", "sun_azimuth_deg"


def with_slant(plan, shapes, sun=SUN, **options):
    """The plan with clouds that functions give, and slant paths of some kinds."""
    angles = np.array([sun.zenith_deg]), np.array([sun.azimuth_deg])
    on = {name: options.get(name, False) for name in ("shadows", "parallax")}
    slant = replace(
        paths_of(**on, view=plan.view, **dict(zip(NAMES, angles, strict=True))), sight=plan.assembly.slant.sight
    )
    return with_clouds(plan, shapes, slant, sun, shadows=slant.shadows, waves=plan.waves.varies)


CORNERS = [(2, 2), (2, 77), (57, 2), (57, 77), (30, 40)]


@pytest.mark.parametrize(("row", "column"), CORNERS)
def test_a_small_cloud_appears_where_trigonometry_by_hand_puts_it(row, column):
    image = LOW_ORBIT["image"]
    plan = plan_of(HIGH, **LOW_ORBIT)
    assert plan.views.varies
    away = displaced_m(*middle_of(row, column, image), 10_000.0)
    right, down = np.rint(away / image["pixel_size"]).astype(int)
    block = lambda y, x: np.where((abs(y - row - down) <= 1) & (abs(x - column - right) <= 1), 500.0, 0.0)  # noqa: E731
    made = next(stream(*compiled(with_slant(plan, [block], parallax=True))))
    seen = np.argwhere(made["cloud_mask"])
    # Nearer to the sensor, it seems larger: neighbours may see a row or column of points twice.
    np.testing.assert_allclose(seen.mean(axis=0), (row, column), atol=0.51)
    assert made["cloud_mask"][row, column]
    assert 9 <= len(seen) <= 16
    # Beside the same cloud in the view of the middle, which is elsewhere by far, but for the middle.
    middle = np.rint(displaced_m(0.0, 0.0, 10_000.0) / image["pixel_size"])
    assert (row, column) == (30, 40) or np.hypot(*(middle - (right, down))) > 3.0


def compiled(plan):
    return plan, compile_tables(plan)


def test_the_displacement_of_every_point_is_that_of_its_line_of_sight():
    """To half a point by rounding, and 1e-3 of a point for the sphere in place of the ellipsoid."""
    plan = plan_of(HIGH, **LOW_ORBIT, **{"slant.parallax": "on", "image.samples_per_pixel": 2})
    shifts = plan.assembly.slant.of_view(plan.layers[0], 250.0).at(slice(0, 120), slice(0, 160))
    points = {"rows": 120, "columns": 160, "pixel_size": 250.0}
    for row, column in [(0, 0), (0, 159), (119, 0), (119, 159), *np.random.default_rng(0).integers(0, 120, (20, 2))]:
        east, north = displaced_m(*middle_of(row, column, points), 10_000.0) / 250.0
        assert abs(shifts[0, row, column] - north) < 0.501
        assert abs(shifts[1, row, column] - east) < 0.501


def test_clouds_are_displaced_the_same_whether_or_not_radiance_needs_several_views():
    mask = LOW_ORBIT | {"slant.parallax": "on", "output.variables": ["cloud_mask"]}
    alone, beside = plan_of(HIGH, **mask), plan_of(HIGH, **mask | {"output.variables": ["cloud_mask", "radiance"]})
    assert not alone.views.varies
    assert beside.views.varies
    made = next(stream(alone, None))["cloud_mask"], next(stream(*compiled(beside)))["cloud_mask"]
    np.testing.assert_array_equal(*made)
    assert 0.1 < made[0].mean() < 0.9


@pytest.mark.long
def test_windows_see_the_parts_of_the_whole(monkeypatch):
    changes = {**LOW_ORBIT, "slant.parallax": "on", "slant.shadows": "on", "image.samples_per_pixel": 2}
    plan, tables = compiled(plan_of(HIGH, **changes))
    whole = next(stream(plan, tables))
    part = plan_of(HIGH, **changes, **{"image.window": {"rows": [17, 55], "columns": [3, 36]}})
    assert 0.0 < whole["cloud_mask"].mean() < 1.0
    cut = next(stream(part, tables))
    monkeypatch.setattr(stream_module, "windows", partial(windows, most_points=77))
    strips = next(stream(plan, tables))
    for name, values in whole.items():
        np.testing.assert_array_equal(cut[name], values[..., 17:55, 3:36])
        np.testing.assert_array_equal(strips[name], values)


def test_an_element_appears_where_its_line_of_sight_meets_the_sea():
    plan = plan_of(HIGH, **LOW_ORBIT, **{"slant.parallax": "on"})
    x, y = np.array([-9e3, 12e3, 14e3]), np.array([8e3, -13e3, 11e3])
    row, column = plan.rays.project(x, y, np.full(3, 8000.0), 0.0)
    image = LOW_ORBIT["image"]
    for at_row, at_column, east, north in zip(row, column, x, y, strict=True):
        place = middle_of(at_row - 0.5, at_column - 0.5, image)
        np.testing.assert_allclose(place + displaced_m(*place, 8000.0), (east, north), atol=1.0)


# --- shadows in a wide field --------------------------------------------------------------

WIDE = {
    "view": {"zenith": 35.0, "azimuth": 30.0},
    "platform.altitude": "800 km",
    "image": {"rows": 30, "columns": 40, "pixel_size": 3000.0},
    "accuracy": 1e-2,
    "sea.waves": "off",
}
ICE = np.array([0.0, 20.0, 100.0, 900.0])


def view_of(plan, row, column):
    """The line of sight of one pixel."""
    scenario = plan.scenario
    place, view, altitude = scenario.place, scenario.view, scenario.platform.altitude
    lines = LinesOfSight(place.latitude, place.longitude, view.zenith, view.azimuth, altitude)
    x, y = middle_of(row, column, vars(scenario.image))
    seen = lines.from_points(np.array(x), np.array(y))
    return View(float(seen.zenith_deg), float(seen.plane_azimuth_deg))


@pytest.mark.parametrize("parallax", [False, True])
def test_a_shadow_in_a_wide_field_takes_the_glint_of_the_pixel_s_own_view(parallax):
    """The dense spectrum of the glint toward each pixel, behind a cloud of Bouguer on the path of the sun."""
    plan = plan_of(HIGH, **WIDE)
    sun = plan.sun_track.at(0.0)
    away = 9500.0 * np.tan(np.radians(sun.zenith_deg)) / 3000.0
    down, right = (int(np.rint(away * part(np.radians(sun.azimuth_deg)))) for part in (np.cos, np.sin))
    assert down == -1
    shape = lambda y, x: np.where(y // 3 % 2 == 1, ICE[x % 4], 0.0)  # noqa: E731
    planned = with_slant(plan, [shape], sun, shadows=True, parallax=parallax)
    made = next(stream(*compiled(planned)))
    y, x = np.mgrid[:30, :40]
    through = np.where(made["cloud_mask"] > 0, 0.0, shape(y + down, x + right))
    np.testing.assert_array_equal(made["shadow_mask"], through > 0)
    assert len(compile_tables(planned).over) == len(plan.views.places) >= 9
    weights, wavenumber = plan.spectral_grid.weights_cm1, plan.spectral_grid.wavenumber_cm1
    extinction = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, wavenumber).extinction_m1
    worst, one_view = 0.0, 0.0
    shaded = np.argwhere(through > 0)
    for row, column in shaded[np.linspace(0, len(shaded) - 1, 24).astype(int)]:
        behind = np.exp(-extinction * through[row, column] / np.cos(np.radians(sun.zenith_deg)))
        expected = []
        for view in (view_of(plan, row, column), plan.view):
            terms = plan.assembly.toward(view).clear(wavenumber, sun)
            kept = terms["sea_reflected_sun"] * (1.0 - behind)
            expected.append(weights @ (np.sum(list(terms.values()), axis=0) - kept))
        error, other = (np.max(np.abs(made["radiance"][:, row, column] / each - 1.0)) for each in expected)
        worst, one_view = max(worst, error), max(one_view, other)
    assert worst < 0.5 * plan.accuracy.relative
    assert one_view > 5.0 * plan.accuracy.relative


def test_behind_an_opaque_cloud_no_glint_is_left_in_a_wide_field():
    plan = plan_of(THICK | {"base": 8000.0, "top": 8900.0}, **WIDE)
    shape = lambda y, x: np.where(y // 3 % 2 == 1, 900.0, 0.0)  # noqa: E731
    sun = plan.sun_track.at(0.0)
    shaded, sunlit = (next(stream(*compiled(with_slant(plan, [shape], sun, shadows=on)))) for on in (True, False))
    where = shaded["shadow_mask"] > 0
    assert where.any()
    glint, left = (made["radiance_sea_reflected_sun"][:, where].astype(float) for made in (sunlit, shaded))
    # The states of the tables lose up to 1e-5.
    assert np.max(left / glint) < 2e-5
    assert np.min(shaded["radiance_sea_reflected_sun"]) >= 0.0
    np.testing.assert_allclose(shaded["radiance"][:, where], sunlit["radiance"][:, where] - glint, rtol=2e-4)


# --- waves in a wide field ----------------------------------------------------------------

SEA = {
    "view": {"zenith": 35.0, "azimuth": 30.0},
    "platform.altitude": "100 km",
    "image": {"rows": 1500, "columns": 2000, "pixel_size": 10.0},
    "accuracy": 1e-2,
    "sea.waves": "on",
}
PARTS = [(slice(y, y + 6), slice(x, x + 8)) for y in (0, 400, 1100, 1494) for x in (200, 770, 1600)]
"""At an edge and between the nodes of the view."""


@lru_cache
def sea_in_parts():
    """Parts of a wide sea with resolved waves."""
    plan = plan_of(THIN | {"coverage": 0.0}, **SEA)
    tables = compile_tables(plan)
    return plan, tables, [PartMaker(plan, tables).part(0, part)[0] for part in PARTS]


def over_tilted_sea(plan, view, sun, upwind, crosswind):
    """Bands of the terms of clear sky over a sea that waves tilt, crosswind clockwise from upwind."""
    clockwise = (sun.azimuth_deg - view.azimuth_deg) % 360.0 < 180.0
    sea = plan.assembly.sea.tilted(upwind, crosswind if clockwise else -crosswind, plan.grid.pixel_size_m)
    terms = plan.assembly.over_sea(sea).toward(view).clear(plan.spectral_grid.wavenumber_cm1, sun)
    return {name: plan.spectral_grid.weights_cm1 @ spectrum for name, spectrum in terms.items()}


def toward(plan, view, sun, upwind, crosswind):
    """Radiance of a pixel with the level of the mean sea, term by term, as in a narrow field."""
    here = over_tilted_sea(plan, view, sun, upwind, crosswind)
    places, shares = np.polynomial.hermite_e.hermegauss(7)
    mean = dict.fromkeys(here, 0.0)
    for u, a in zip(places, shares, strict=True):
        for c, b in zip(places, shares, strict=True):
            tilted_here = over_tilted_sea(plan, view, sun, u * plan.waves.rms[0], c * plan.waves.rms[1])
            mean = {name: mean[name] + a * b * bands / shares.sum() ** 2 for name, bands in tilted_here.items()}
    spectra = plan.assembly.toward(view).clear(plan.spectral_grid.wavenumber_cm1, sun)
    level = {name: plan.spectral_grid.weights_cm1 @ spectrum for name, spectrum in spectra.items()}
    return sum(here[name] * level[name] / mean[name] for name in here if np.all(mean[name] > 0.0))


def test_a_wave_in_a_wide_field_is_a_tilted_sea_in_the_pixel_s_own_view():
    plan, tables, parts = sea_in_parts()
    assert len(tables.over) == len(plan.views.places) >= 9
    sun, wind = plan.sun_track.at(0.0), np.radians(plan.scenario.sea.wind_from)
    errors, one_view = [], []
    for (rows, columns), made in zip(PARTS, parts, strict=True):
        y, x = np.unravel_index(np.argmax(np.abs(made["sea_slope_y"])), made["sea_slope_y"].shape)
        slope = float(made["sea_slope_x"][y, x]), float(made["sea_slope_y"][y, x])
        upwind = slope[0] * np.sin(wind) + slope[1] * np.cos(wind)
        crosswind = slope[0] * np.cos(wind) - slope[1] * np.sin(wind)
        view, found = view_of(plan, rows.start + y, columns.start + x), made["radiance"][:, y, x]
        errors.append(np.max(np.abs(found / toward(plan, view, sun, upwind, crosswind) - 1.0)))
        one_view.append(np.max(np.abs(found / toward(plan, plan.view, sun, upwind, crosswind) - 1.0)))
    assert max(errors) < 0.5 * plan.accuracy.relative
    assert max(one_view) > 5.0 * plan.accuracy.relative


def test_terms_of_waves_in_a_wide_field_sum_to_the_total_and_none_is_negative():
    for made in sea_in_parts()[2]:
        terms = [values.astype(float) for name, values in made.items() if name.startswith("radiance_")]
        assert min(values.min() for values in terms) >= 0.0
        np.testing.assert_allclose(np.sum(terms, axis=0), made["radiance"], rtol=1e-4)


def test_all_effects_of_a_wide_field_go_together_in_whatever_windows(monkeypatch):
    on = {"slant.shadows": "on", "slant.parallax": "on", "image.rows": 60, "image.pixel_size": 20.0}
    plan, tables = compiled(plan_of(THICK, **{**SEA, **on}))
    area = slice(0, 60), slice(100, 200)
    whole = PartMaker(plan, tables).part(0, area)[0]
    assert 0.0 < whole["shadow_mask"].mean() < 1.0
    assert whole["radiance"].min() > 0.0
    monkeypatch.setattr(stream_module, "windows", partial(windows, most_points=310))
    strips = PartMaker(plan, tables).part(0, area)[0]
    part = PartMaker(plan, tables).part(0, (slice(10, 50), slice(120, 190)))[0]
    for name, values in whole.items():
        np.testing.assert_array_equal(strips[name], values)
        np.testing.assert_array_equal(part[name], values[..., 10:50, 20:90])


def test_the_sea_beside_land_has_the_waves_and_shadows_of_a_sea_without(tmp_path):
    write_half(tmp_path / "half.nc")
    on = {"slant.shadows": "on", "slant.parallax": "on", "accuracy": 1e-3}
    image = {"image": {"rows": 60, "columns": 80, "pixel_size": 40.0}}
    clouds = {"clouds": {"layers": [THICK | {"coverage": 0.3, "coverage_mode": "field"}]}}
    changes = {**CHEAP, "sea.model": "rough-sea", **SEA, **on, **image}
    surfaces = {
        "provider": "raster",
        "parameters": {"file": str(tmp_path / "half.nc"), "classes": {0: "sea", 1: "sand"}},
    }
    alone, beside = (
        make_plan(Scenario.from_dict(SCENE | clouds | more, changes)) for more in ({}, {"surfaces": surfaces})
    )
    assert alone.views.varies
    assert beside.views.varies
    (sea, half) = (next(stream(*compiled(plan))) for plan in (alone, beside))
    west = half["surface_class"] == 0
    assert 0.3 < west.mean() < 0.7
    assert 0.0 < half["shadow_mask"][west].mean() < 1.0
    assert np.std(half["sea_slope_x"]) > 0.003
    np.testing.assert_allclose(half["radiance"][:, west], sea["radiance"][:, west], rtol=1e-3)
    for name in ("cloud_mask", "shadow_mask"):
        np.testing.assert_array_equal(half[name][west], sea[name][west])


def test_pixels_in_shadow_pass_the_certificate_in_a_wide_field():
    on = {"slant.shadows": "on", "slant.parallax": "on", "output.certificate": 12}
    plan = plan_of(HIGH, **{**LOW_ORBIT, **on})
    tables, sample = compile_tables(plan), PixelSample(plan)
    list(stream(plan, tables, sample))
    found = certify(plan, tables, sample.frames)
    assert found.passed
    assert found.checked == 12
    in_shadow = next(stratum for stratum in found.strata if stratum.name == "clear in shadow")
    assert in_shadow.checked >= 2
    assert not any(stratum.left_out for stratum in found.strata)


def test_waves_left_to_the_plan_are_not_resolved_if_they_need_more_views_than_there_can_be(monkeypatch):
    choose = scene_analysis.choose_views

    def choose_views(scenario, assembly, suns, tolerance, left, waves):
        if waves:
            raise ScenarioError([Problem("accuracy", "too many views")])
        return choose(scenario, assembly, suns, tolerance, left, waves)

    monkeypatch.setattr(scene_analysis, "choose_views", choose_views)
    changes = {**SEA, "image.rows": 60, "image.columns": 80, "accuracy": 2e-2}
    plan = plan_of(THIN | {"coverage": 0.0}, **changes | {"sea.waves": "auto"})
    assert not plan.waves.varies
    (omitted,) = (omission for omission in plan.omissions if omission.what == "waves as shapes")
    assert "more views" in omitted.why
    assert omitted.bound > 0.02
    for wanted in ({"sea.waves": "on"}, {"sea.waves": "auto", "output.variables": ["radiance", "sea_slope_x"]}):
        with pytest.raises(ScenarioError, match="too many views"):
            plan_of(THIN | {"coverage": 0.0}, **changes | wanted)
