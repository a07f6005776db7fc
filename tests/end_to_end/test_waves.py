"""Scenes whose pixels are small enough to see waves, and scenes whose are not."""

import numpy as np
import pytest
from cheap import CHEAP
from refusals import problems_of

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.models.sea.wave_field import MOST, MOST_SIGMAS

BASE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 64, "columns": 96, "pixel_size": 2.0},
    "frames": {"count": 1},
    "view": {"zenith": 40.0, "azimuth": 20.0},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
    "sea": {"temperature": 291.4, "wind_speed": 8.0, "waves": "on"},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "accuracy": 3e-3,
    "output": {"variables": ["all"], "certificate": 0},
    "seed": 3,
}
CLOUDS = {"type": "cumulus", "coverage": 0.4}


def scenario(**overrides):
    return Scenario.from_dict(BASE, {**CHEAP, "sea.model": "rough-sea", **overrides})


def skipped(**overrides):
    return {item.what: item for item in make_plan(scenario(**overrides)).omissions}


@pytest.fixture(scope="module")
def planned():
    plan = make_plan(scenario())
    return plan, compile_tables(plan)


@pytest.fixture(scope="module")
def frame(planned):
    return next(stream(*planned))


def test_each_pixel_is_the_radiance_of_its_tilted_sea_but_for_the_level(planned, frame):
    """Against the radiance model over the sea tilted by the slope in the cube, term by term.

    The level of each term is that of the mean sea: one factor for all pixels.
    """
    plan, tables = planned
    random, wind = np.random.default_rng(0), np.radians(plan.scenario.sea.wind_from)
    sun = plan.sun_track.at(0.0)
    names, ratios = ("sea_emission", "sea_reflected_sun", "path_emission"), []
    for y, x in random.integers(0, 64, (12, 2)):
        slope = float(frame["sea_slope_x"][y, x]), float(frame["sea_slope_y"][y, x])
        upwind = slope[0] * np.sin(wind) + slope[1] * np.cos(wind)
        crosswind = slope[0] * np.cos(wind) - slope[1] * np.sin(wind)
        # The sun is to the left of the bearing toward the sensor or to the right of it: here clockwise from it.
        assert 0.0 < sun.azimuth_deg - plan.view.azimuth_deg < 180.0
        tilted = plan.assembly.over_sea(plan.assembly.sea.tilted(upwind, crosswind, 2.0))
        terms = tilted.clear(plan.spectral_grid.wavenumber_cm1, sun)
        ratios.append(
            [frame[f"radiance_{name}"][:, y, x] / (plan.spectral_grid.weights_cm1 @ terms[name]) for name in names]
        )
    ratios = np.array(ratios)
    np.testing.assert_allclose(ratios, np.broadcast_to(ratios.mean(axis=0), ratios.shape), rtol=1e-3)
    level = [tables.waves.level[0][list(plan.assembly.model.terms).index(name)] for name in names]
    np.testing.assert_allclose(ratios.mean(axis=0), level, rtol=1e-3)
    np.testing.assert_allclose(level, 1.0, atol=0.06)
    assert tables.waves.estimated_error < 3e-4
    assert tables.estimated_error < plan.budget.total


def test_a_sun_on_the_other_side_is_followed(planned):
    """The table is the mirror image where everything is mirrored at the wind's plane."""
    plan = make_plan(scenario(**{"sea.wind_from": 20.0}))
    tables = compile_tables(plan)
    sun = plan.sun_track.at(0.0)
    wavenumber, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1
    # View along the wind: with the sun's bearing mirrored, the crosswind slopes exchange their signs.
    mirrored = type(sun)(sun.zenith_deg, 2.0 * 20.0 - sun.azimuth_deg, sun.distance_au)
    radiance = []
    for position in (sun, mirrored):
        tilted = plan.assembly.over_sea(plan.assembly.sea.tilted(0.05, 0.08, 2.0))
        radiance.append(weights @ np.sum(list(tilted.clear(wavenumber, position).values()), axis=0))
    np.testing.assert_allclose(radiance[0], radiance[1], rtol=1e-12)
    assert not np.allclose(tables.waves.change[0], tables.waves.change[0][:, ::-1], rtol=1e-3)


def test_the_mean_over_waves_is_the_radiance_of_the_mean_sea(planned, frame):
    plan, tables = planned
    for change in tables.waves.change:
        upwind, crosswind = (np.exp(-0.5 * np.linspace(-MOST_SIGMAS, MOST_SIGMAS, n) ** 2) for n in change.shape[:2])
        weights = np.outer(upwind / upwind.sum(), crosswind / crosswind.sum())
        mean = np.einsum("nm,nmc->c", weights, change.astype(np.float64))
        clear = tables.tables[0].clear.ravel()
        np.testing.assert_allclose(mean, 0.0, atol=1e-6 * clear.max())
        assert np.all(np.abs(mean) <= 1e-6 * np.maximum(clear, clear.max() * 1e-3))
    level = next(stream(*_with(plan, "off")))["radiance"][:, 0, 0]
    spread = frame["radiance"].std(axis=(1, 2))
    # Pixels of long waves are alike: some 100 of 6144 are independent.
    assert np.all(np.abs(frame["radiance"].mean(axis=(1, 2)) - level) < 0.3 * spread)
    assert spread[0] > 0.02 * level[0]


def _with(plan, waves):
    other = make_plan(Scenario.from_dict(plan.scenario.model_dump(), {"sea.waves": waves}))
    return other, compile_tables(other)


def test_terms_sum_to_the_total(frame):
    total = sum(values.astype(np.float64) for name, values in frame.items() if name.startswith("radiance_"))
    np.testing.assert_allclose(total, frame["radiance"], rtol=1e-6)


def test_the_bound_of_the_plan_holds_for_every_pixel_and_the_estimate_for_its_share(planned, frame):
    _, tables = planned
    omission = skipped(**{"sea.waves": "off"})["waves as shapes"]
    clear = tables.tables[0].clear[0]
    change = np.max(np.abs(frame["radiance"] / clear[:, None, None] - 1.0), axis=0)
    assert change.max() <= omission.bound
    # within three standard deviations: 1 - exp(-4.5) of a Gaussian sea, less four deviations of the count
    share = 1.0 - np.exp(-4.5)
    assert np.mean(change <= omission.estimate) >= share - 4.0 * np.sqrt(share * (1.0 - share) / change.size)
    assert omission.sense == MOST == f"{100.0 * share:.1f} % of the clear pixels"
    assert change.max() > 0.3 * omission.estimate


def test_waves_are_skipped_with_their_bound_and_the_bound_falls_with_the_pixel():
    bounds = []
    for size in (2.0, 20.0):
        item = skipped(**{"sea.waves": "off", "image.pixel_size": size})["waves as shapes"]
        assert "sea.waves is off" in item.why
        assert item.estimate <= item.bound
        bounds.append(item.estimate)
    assert bounds[0] > 2.0 * bounds[1] > 0.0
    flat = skipped(**{"sea.waves": "off", "image.pixel_size": 200.0})["waves as shapes"]
    assert flat.bound == 0.0
    assert "raises no waves longer" in flat.why
    night = skipped(**{"sea.waves": "off", "time": "2024-04-20T00:30:00+10:00"})["waves as shapes"]
    assert 0.0 < night.estimate < 0.5 * bounds[0]
    cox_munk = skipped(**{"sea.waves": "auto", "sea.model": "cox-munk"})["waves as shapes"]
    assert cox_munk.estimate == pytest.approx(bounds[0], rel=0.3)
    assert "without waves as shapes" in cox_munk.why


def test_auto_draws_what_exceeds_the_accuracy():
    assert "waves as shapes" not in skipped(**{"sea.waves": "auto"})
    item = skipped(**{"sea.waves": "auto", "image.pixel_size": 100.0})["waves as shapes"]
    assert item.bound <= BASE["accuracy"]
    assert "accuracy" in item.why


def test_without_wind_there_are_no_waves():
    calm = skipped(**{"sea.wind_speed": 0.0})["waves as shapes"]
    assert (calm.why, calm.bound) == ("no wind raises waves", 0.0)


def test_wind_whose_waves_no_pixel_resolves_is_not_called_calm():
    breeze = skipped(**{"sea.wind_speed": 3.55, "image.pixel_size": 200.0})["waves as shapes"]
    assert breeze.bound == 0.0
    assert "3.55 m/s" in breeze.why
    assert "200 m" in breeze.why


def test_pixels_of_20_m_see_less(frame):
    coarse = simulate(scenario(**{"image.pixel_size": 20.0})).radiance.values[0]
    fine = frame["radiance"]
    contrast = [(each.std(axis=(1, 2)) / each.mean(axis=(1, 2))) for each in (fine, coarse)]
    assert np.all(contrast[1] < 0.7 * contrast[0])
    assert np.all(contrast[1] > 0.0)


def test_clouds_hide_waves_and_leave_the_rest_as_it_was():
    changes = {"clouds": CLOUDS, "image.rows": 32, "image.columns": 48, "image.samples_per_pixel": 2}
    # Of several frames the glint may need tables at more times, and these are alike within the tolerance only.
    for frames, tolerance, band in ((1, 0.0, "lwir-10.8"), (2, 0.1 * BASE["accuracy"], "mwir-3.7")):
        drawn, averaged = (
            simulate(scenario(**changes, **{"sea.waves": waves, "frames.count": frames, "bands": [band]}))
            for waves in ("on", "off")
        )
        covered = (averaged.cloud_fraction == 1.0).values
        assert covered.any()
        assert (~covered).any()
        a, b = drawn.radiance.values[:, 0], averaged.radiance.values[:, 0]
        np.testing.assert_allclose(a[covered], b[covered], rtol=tolerance)
        assert np.mean(a[~covered] != b[~covered]) > 0.9
    assert "sea_slope_x" not in averaged
    assert "clear sky only" in drawn.attrs["hcss_notes"]
    assert "waves as shapes" not in drawn.attrs["hcss_skipped"]
    assert not np.array_equal(drawn.sea_slope_x.values[0], drawn.sea_slope_x.values[1])


def test_the_same_scene_twice_is_the_same_to_the_bit(planned, frame):
    again = next(stream(*planned))
    assert all(again[name].tobytes() == values.tobytes() for name, values in frame.items())


@pytest.mark.parametrize(
    ("overrides", "field", "message"),
    [
        ({"sea.model": "cox-munk"}, "sea.model", "'rough-sea'"),
        ({"sea.parameters": {"slopes": "gram-charlier"}}, "sea.parameters.slopes", "'upwind-crosswind'"),
        ({"sea.waves": "off", "output.variables": ["sea_slope_x"]}, "output.variables", 'sea.waves = "on"'),
        ({"sea.waves": "drawn"}, "sea.waves", "allowed: auto, off, on"),
    ],
)
def test_waves_that_cannot_be_drawn_are_refused(overrides, field, message):
    assert message in problems_of(lambda: make_plan(scenario(**overrides)))[field]


def test_slopes_can_be_had_without_radiance(frame):
    plan = make_plan(scenario(**{"output.variables": ["sea_slope_x", "sea_slope_y"]}))
    assert not plan.needs_radiance
    alone = next(stream(plan, None))
    assert set(alone) == {"sea_slope_x", "sea_slope_y"}
    assert all(np.array_equal(values, frame[name]) for name, values in alone.items())


@pytest.mark.parametrize("azimuth", [20.0, pytest.param(109.5, marks=pytest.mark.campaign)])
def test_frames_between_the_tables_agree_with_tables_of_their_own(azimuth):
    """The glint moves with the sun, and with the sun across the view from one side of it to the other."""
    changes = {"frames.count": 3, "frames.interval": 40.0, "bands": ["mwir-3.7"], "view.azimuth": azimuth}
    changes |= {"image.rows": 16, "image.columns": 24, "output.variables": ["radiance", "sea_slope_x"]}
    plan = make_plan(scenario(**changes))
    tables = compile_tables(plan)
    assert len(tables.time_s) <= 2
    middle = list(stream(plan, tables))[1]
    alone = make_plan(scenario(**{**changes, "frames.count": 1, "frames.first": 1}))
    exact = next(stream(alone, compile_tables(alone)))
    np.testing.assert_array_equal(middle["sea_slope_x"], exact["sea_slope_x"])
    assert not np.array_equal(middle["radiance"], exact["radiance"])
    np.testing.assert_allclose(middle["radiance"], exact["radiance"], rtol=0.2 * BASE["accuracy"])
