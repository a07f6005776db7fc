"""The certificate of clear points: each with its wave, behind the clouds on the path of the sun."""

from dataclasses import replace

import numpy as np
import pytest
from cheap import CHEAP
from surface_files import write_half

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import CertificateWarning
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.certificate.clear_points import ClearPoint, ClearPoints, changes
from hcss_twin.engine.certificate.reference_columns import CURVE_SHARE, References
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.simulate import simulate
from hcss_twin.engine.stages.scene_stages import SceneTables
from hcss_twin.engine.stream import stream
from hcss_twin.plan.numerics import reference_level
from hcss_twin.plan.waves import MEAN_SEA

LIT = CHEAP | {
    "sea.model": "rough-sea",
    "sea.waves": "on",
    "slant.shadows": "on",
    "clouds.coverage_mode": "field",
    "image.rows": 60,
    "image.columns": 80,
    "image.pixel_size": 20.0,
    "bands": ["mwir-3.7", "lwir-10.8"],
    "frames.count": 3,
    "view.zenith": 40.0,
}
"""Waves in and out of the shadow of clouds, some of them in the glint of the sun."""
OF_PIXELS = {"image.samples_per_pixel": 2, "output.certificate": 24}
OF_VIEWS = {"platform.altitude": "100 km", "image.rows": 800, "image.columns": 1000, "accuracy": 1e-2}
OF_VIEWS |= {"image.window.rows": [700, 760], "image.window.columns": [820, 900]}
CLEAR = {"clear", "clear in shadow"}
EVEN = np.zeros(2)
"""Perturbation of clear sky without texture."""


def plan_of(**changes):
    return make_plan(Scenario.load("cumulus", LIT | {key.replace("__", "."): each for key, each in changes.items()}))


def checked(plan):
    """The tables of a plan, and the pixels that are drawn."""
    tables, sample = compile_tables(plan), PixelSample(plan)
    list(stream(plan, tables, sample))
    return tables, sample.frames


def strata_of(found):
    return {stratum.name: stratum for stratum in found.strata}


@pytest.mark.parametrize("changes", [{}, OF_PIXELS, OF_VIEWS], ids=["one view", "many points", "many views"])
def test_waves_in_and_out_of_shadow_pass_and_nothing_is_left_out(changes):
    plan = make_plan(Scenario.load("cumulus", LIT | changes))
    tables, frames = checked(plan)
    assert plan.waves.varies
    assert plan.has_shadows
    assert plan.views.varies == (changes is OF_VIEWS)
    found = certify(plan, tables, frames)
    strata = strata_of(found)
    assert set(strata) >= CLEAR | {"edge", "thick"}
    assert all(stratum.checked >= 1 and not stratum.left_out for stratum in strata.values())
    assert found.passed
    # the waves matter: a mean sea would fail
    calm = certify(replace(plan, waves=MEAN_SEA), tables, frames)
    assert "clear" in {stratum.name for stratum in calm.strata if stratum.exceeding}


def test_land_beside_the_sea_has_shadows_and_no_waves(tmp_path):
    write_half(tmp_path / "half.nc")
    classes = {0: "sea", 1: "sand"}
    ground = {"provider": "raster", "parameters": {"file": str(tmp_path / "half.nc"), "classes": classes}}
    plan = plan_of(
        surfaces=ground, place={"latitude": 35.0, "longitude": 150.0}, output__certificate=60, frames__count=1
    )
    found = certify(plan, *checked(plan))
    strata = strata_of(found)
    for surface in ("sea", "sand"):
        for name in CLEAR:
            assert strata[f"{name} over {surface}"].checked >= 3
    assert found.passed
    assert max(strata["clear over sand"].error) < 1e-4


def wrong(kind, factor):
    """Return a compiler whose tables of waves, or of shadows, are wrong by a factor."""

    def tables_of(plan):
        tables = compile_tables(plan)
        waves, shadows = tables.waves, tables.shadows
        if kind == "waves":
            waves = replace(waves, change=tuple(np.float32(factor) * change for change in waves.change))
        else:
            shadows = replace(shadows, **{kind: factor * getattr(shadows, kind)})
        return replace(tables, waves=waves, shadows=shadows)

    return tables_of


@pytest.mark.parametrize(
    ("kind", "factor", "named"),
    [("waves", 1.1, "clear"), ("loss", 0.95, "clear in shadow"), ("depth", 0.7, "clear in shadow")],
)
def test_a_wrong_table_of_waves_or_shadows_fails_and_names_the_stratum(kind, factor, named, monkeypatch):
    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", wrong(kind, factor))
    with pytest.warns(CertificateWarning, match=rf"NOT as specified: .*{named} \(\d"):
        made = simulate(Scenario.load("cumulus", LIT | {"output.certificate": 60}))
    assert "thick (" not in made.attrs["hcss_certificate"].split(";")[0]


IN_VAPOUR = {
    "image.rows": 800,
    "image.columns": 800,
    "image.window.rows": [390, 420],
    "image.window.columns": [390, 420],
    "view.zenith": 28.0,
    "view.azimuth": 200.0,
    "time": "2024-04-20T11:00:00+10:00",
    "bands": [[2.8, 2.9]],
    "atmosphere.water_vapour_texture": 0.2,
    "frames.count": 1,
    "output.certificate": 30,
}
"""Waves at the edge of the glint, where vapour absorbs, in air whose vapour differs."""


def test_the_glint_of_waves_crosses_the_vapour_of_its_pixel_in_and_out_of_shadow(monkeypatch):
    plan = make_plan(Scenario.load("cumulus", LIT | IN_VAPOUR))
    tables, frames = checked(plan)
    found = certify(plan, tables, frames)
    assert strata_of(found)["clear"].checked >= 5
    assert found.passed
    # Without its vapour the sunlight of a wave fails.
    monkeypatch.setattr(type(plan.texture), "changes_sunlight", False)
    tables, frames = checked(plan)
    even = certify(plan, tables, frames)
    assert "clear" in {stratum.name for stratum in even.strata if stratum.exceeding}


def point_of(plan, slope=(0.0, 0.0), path_m=0.0, level=1.0):
    size = len(plan.assembly.model.terms), len(plan.bands)
    return ClearPoint(
        plan.sun_up_at(0.0), plan.view, slope, np.array([path_m]), np.broadcast_to(level, size), (0.0, 0.0)
    )


def mean_column(plan):
    """Terms (K, B) over the mean sea, on the grid and at the level of the scene."""
    terms = plan.assembly.clear(plan.spectral_grid.wavenumber_cm1, plan.sun_up_at(0.0))
    return np.array([plan.spectral_grid.weights_cm1 @ terms[name] for name in plan.assembly.model.terms])


def test_behind_an_opaque_cloud_a_point_has_no_direct_glint_and_all_else():
    plan = plan_of()
    slopes = [(0.0, 0.0), (0.5 * plan.waves.rms[0], -plan.waves.rms[1])]
    points = [point_of(plan, slope, path) for slope in slopes for path in (0.0, 1e6)]
    terms = mean_column(plan) + changes(plan, points, References())
    glint = list(plan.assembly.model.terms).index("sea_reflected_sun")
    others = np.arange(len(plan.assembly.model.terms)) != glint
    for sunlit, shaded in (terms[:2], terms[2:]):
        assert sunlit[glint, 0] > 0.01 * sunlit[:, 0].sum()
        assert np.all(np.abs(shaded[glint]) < 1e-3 * sunlit[glint] + 1e-12)
        np.testing.assert_array_equal(shaded[others], sunlit[others])


def test_a_cloud_of_one_extinction_keeps_back_what_bouguer_says():
    """In a narrow band the extinction hardly changes."""
    plan = plan_of(bands=[{"name": "narrow", "limits": [3.70, 3.71]}])
    layer, wavenumber = plan.layers[0], plan.spectral_grid.wavenumber_cm1
    extinction = plan.assembly.optics.single_scattering(layer.microphysics, wavenumber).extinction_m1
    assert np.ptp(extinction) < 0.01 * extinction.mean()
    paths = np.array([0.3, 1.0, 3.0]) / extinction.mean()
    points = [point_of(plan), point_of(plan, path_m=1e6), *(point_of(plan, path_m=path) for path in paths)]
    found = changes(plan, points, References()).sum(axis=(1, 2))
    lost = (found - found[0]) / (found[1] - found[0])
    np.testing.assert_allclose(lost[2:], 1.0 - np.exp(-np.array([0.3, 1.0, 3.0])), rtol=3e-3)


def test_the_level_of_a_point_multiplies_the_terms_of_its_tilted_sea():
    plan = plan_of()
    slope, level = (-plan.waves.rms[0], 0.3 * plan.waves.rms[1]), 1.03
    one, more = mean_column(plan) + changes(
        plan, [point_of(plan, slope), point_of(plan, slope, level=1.03)], References()
    )
    np.testing.assert_allclose(more, level * one, rtol=1e-3, atol=1e-4 * one.sum(axis=0).min())


def test_waves_too_small_to_tilt_a_sea_far_from_the_glint_leave_the_mean_sea_times_the_level():
    plan = plan_of(image__pixel_size=50.0, view__azimuth=200.0)
    assert 0.0 < max(plan.waves.rms) < 0.01
    found = changes(plan, [point_of(plan), point_of(plan, level=1.05)], References())
    mean = mean_column(plan)
    total = mean.sum(axis=0)
    assert np.all(np.abs(found[0]) < 3e-5 * total)
    assert np.all(np.abs(found[1] - 0.05 * mean) < 1e-4 * total)


def test_the_mean_of_the_reference_over_the_waves_is_the_mean_sea():
    """By quadrature over Gaussian slopes, which does not know how the tables find the level."""
    plan = plan_of()
    tables, _ = checked(plan)
    of_scene = ClearPoints(SceneTables(plan, tables, ()))
    level = of_scene.of_pixel(0.0, 3, 4, plan.view, EVEN)[0].level
    places, weights = np.polynomial.hermite_e.hermegauss(9)
    slopes = [(u * plan.waves.rms[0], c * plan.waves.rms[1]) for u in places for c in places]
    found = changes(plan, [point_of(plan, slope, level=level) for slope in slopes], References())
    mean = np.tensordot(np.outer(weights, weights).ravel() / weights.sum() ** 2, found, 1)
    total = mean_column(plan).sum(axis=0)
    assert np.all(np.abs(mean.sum(axis=0)) < 2e-4 * total)
    assert np.max(np.abs(found.sum(axis=1)) / total) > 1e-2


def test_slopes_of_points_are_those_of_the_cube():
    plan = plan_of()
    tables, frames = checked(plan)
    of_scene = ClearPoints(SceneTables(plan, tables, ()))
    with_slopes = plan_of(output__variables=["sea_slope_x", "sea_slope_y"], output__certificate=0)
    made = list(stream(with_slopes, None))[frames[0].frame]
    wind = np.radians(plan.scenario.sea.wind_from)
    for row, column in ((0, 0), (17, 33), (59, 79)):
        x, y = (float(made[name][row, column]) for name in ("sea_slope_x", "sea_slope_y"))
        (point,) = of_scene.of_pixel(frames[0].time_s, row, column, plan.view, EVEN)
        expected = x * np.sin(wind) + y * np.cos(wind), x * np.cos(wind) - y * np.sin(wind)
        np.testing.assert_allclose(point.slope, expected, atol=1e-6)


class Steep:
    """Waves with one slope everywhere."""

    def slopes(self, time_s, rows, columns):
        return np.full((2, rows.stop - rows.start, columns.stop - columns.start), -9.0, np.float32)


def test_waves_steeper_than_the_scene_draws_them_are_clipped():
    plan = plan_of(sea__wind_from=0.0)
    steep = replace(plan, waves=replace(plan.waves, shapes=Steep()))
    (point,) = ClearPoints(SceneTables(steep, checked(plan)[0], ())).of_pixel(0.0, 5, 6, plan.view, EVEN)
    # The wind comes from the north, along y.
    np.testing.assert_allclose(point.slope, (-4.0 * plan.waves.rms[0], -4.0 * plan.waves.rms[1]))


def test_between_instants_of_the_tables_the_level_is_linear():
    plan = plan_of()
    tables, _ = checked(plan)
    shape = tables.waves.level[0].shape
    waves = replace(tables.waves, level=(np.full(shape, 1.0), np.full(shape, 3.0)))
    scene = SceneTables(plan, replace(tables, time_s=(0.0, 10.0), waves=waves), ())
    for time_s, expected in ((0.0, 1.0), (2.5, 1.5), (10.0, 3.0)):
        (point,) = ClearPoints(scene).of_pixel(time_s, 5, 6, plan.view, EVEN)
        np.testing.assert_allclose(point.level, expected)


def test_the_level_of_a_pixel_is_that_of_tables_toward_its_own_view():
    plan = plan_of(**{key.replace(".", "__"): value for key, value in OF_VIEWS.items()})
    tables = compile_tables(plan)
    row, column = 710, 850
    (view,) = plan.rays.views_of_pixels([row], [column], 0.0)
    (point,) = ClearPoints(SceneTables(plan, tables, ())).of_pixel(0.0, row, column, view, EVEN)
    own = compile_tables(plan.toward(view)).waves.level[0]
    assert np.max(np.abs(point.level - own)) < 1e-5
    assert np.max(np.abs(tables.over[0].waves.level[0] - own)) > 1e-3


def test_what_an_opaque_cloud_keeps_back_is_the_glint_on_the_finer_grid():
    plan = replace(plan_of(), waves=MEAN_SEA)
    found = changes(plan, [point_of(plan, path_m=1e6)], References())[0]
    assembly = plan.assembly.at_level(reference_level(plan.assembly))
    glint = []
    for finer in (0, 1):
        grid = assembly.refined_grid(plan.grid_refinement.refinement + finer)
        glint.append(grid.weights_cm1 @ assembly.clear(grid.wavenumber_cm1, plan.sun_up_at(0.0))["sea_reflected_sun"])
    np.testing.assert_allclose(-found.sum(axis=0), glint[1], rtol=1e-9)
    assert np.all(np.abs(glint[0] / glint[1] - 1.0) > 1e-7)


def test_a_sweep_interpolates_mean_columns_over_warmer_and_colder_seas():
    """Each point over its own sea, against columns of all points solved one by one."""
    scene = Scenario.load("cumulus", LIT | {"sea.temperature_texture": 0.5, "bands": ["mwir-3.7"]})
    plan = make_plan(scene, keeps_results=False)  # so that neither is read from the cache
    assert plan.texture.temperature_K > 0.0
    points = [point_of(plan)._replace(perturbation=(step, 0.0)) for step in (-1.9, -0.3, 0.0, 1.1, 2.3)]
    solved, read = (changes(plan, points, References(from_curves)) for from_curves in (False, True))
    whole = mean_column(plan).sum(axis=0)
    assert np.abs(read - solved).max() < 1e-9 * whole.min()
    # over one sea for all points the curve would be off by more
    even = changes(plan, [point._replace(perturbation=(0.0, 0.0)) for point in points], References(True))
    assert np.abs(even - solved).max() > 1e-7 * whole.min()


def random_points(plan, count=12):
    """Points with waves over warmer and colder sea: in no shadow, in a thin one and in a black one."""
    rng = np.random.default_rng(47)
    slopes = rng.uniform(-1.0, 1.0, (count, 2)) * plan.waves.reach
    paths_m = np.resize([0.0, 2.0, 1e5], count)
    points = [point_of(plan, tuple(slope), path_m) for slope, path_m in zip(slopes.tolist(), paths_m, strict=True)]
    return [
        point._replace(perturbation=(warmer, 0.0)) for point, warmer in zip(points, rng.normal(size=count), strict=True)
    ]


def test_tilted_columns_of_scenes_that_share_them_are_read_between_slopes_and_temperatures():
    plan = plan_of(sea__temperature_texture=0.3)
    points = random_points(plan)
    shared, alone = References(from_curves=True), References()
    read, solved = (changes(plan, points, references) for references in (shared, alone))
    total, allowed = mean_column(plan).sum(axis=0), CURVE_SHARE * plan.accuracy.relative
    assert shared.read == len(points)
    assert 0.0 < shared.curve_error <= allowed
    away = np.abs(read - solved).sum(axis=1) / total
    assert 0.0 < np.max(away) < 2.0 * allowed
    assert np.max(np.abs(solved.sum(axis=1)) / total) > 0.1
    # some scenes of a sweep solve theirs
    some = References(from_curves=True, afresh=4)
    np.testing.assert_array_equal(changes(plan, points, some), solved)


def test_tilted_columns_are_solved_where_few_slopes_do_not_suffice():
    """Pixels of 10 m resolve so many waves that the rest is a narrow glint."""
    plan = plan_of(sea__temperature_texture=0.3, image__pixel_size=10.0)
    points, shared = random_points(plan), References(from_curves=True)
    np.testing.assert_array_equal(changes(plan, points, shared), changes(plan, points, References()))
    assert shared.read == 0
