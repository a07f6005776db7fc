"""Clouds solved toward several views at once are those solved toward each view alone."""

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.plan.views import EDGES, EXTREMES, views_over_image
from hcss_twin.providers.column_states import spectra_of

WAVENUMBER_CM1 = np.array([850.0, 2500.0, 2900.0, 3450.0])
DAY, NIGHT = "2024-04-20T12:30:00+10:00", "2024-04-20T00:30:00+10:00"


def plan_of(time, pixel_m, accuracy=1e-3):
    keys = {"image.rows": 50, "image.columns": 50, "image.pixel_size": pixel_m, "frames.count": 1, "time": time}
    keys |= {"platform.altitude": "800 km", "bands": ["swir-2.7-3.0"], "accuracy": accuracy}
    return make_plan(Scenario.load("stratus", keys))


@pytest.mark.long
@pytest.mark.parametrize(
    ("time", "steps"), [(DAY, 0), (DAY, 2), (NIGHT, 0), pytest.param(NIGHT, 2, marks=pytest.mark.campaign)]
)
def test_columns_do_not_depend_on_the_views_solved_with_them(time, steps):
    # They share no models. The level is given below: a coarse accuracy saves its choice.
    plan, other = (plan_of(time, 100.0, 0.05) for _ in range(2))
    alone, together = (each.assembly.at_level(1).with_finer_sunlight(steps) for each in (plan, other))
    views = views_over_image(plan.assembly).at(EXTREMES)
    sun, thickness = plan.sun_up_at(0.0), np.geomspace(20.0, 900.0, 6)[:, None]
    assert together.model is not alone.model
    spectra = spectra_of(together.model, [together.setting(sun, view) for view in views], WAVENUMBER_CM1, thickness)
    for view, of_view in zip(views, spectra, strict=True):
        exact = alone.toward(view).cloudy(WAVENUMBER_CM1, thickness, sun)
        found, whole = dict(zip(together.model.terms, np.moveaxis(of_view, 1, 0), strict=True)), sum(exact.values())
        for name, values in exact.items():
            np.testing.assert_allclose(found[name], values, rtol=0.0, atol=2e-5 * np.max(whole), err_msg=name)


@pytest.mark.long
def test_the_numerical_level_suffices_toward_all_views():
    """Toward the image centre, at a rainbow, the error of the level chosen there vanishes by chance."""
    plan = plan_of(DAY, 5000.0)
    assert plan.numerics.enough
    assert plan.numerics.sunlight_steps > 0
    thickness, sun = np.array([[967.0]]), plan.sun_up_at(0.0)
    views = views_over_image(plan.assembly).at(EDGES)[:2]
    found, exact = (
        spectra_of(each.model, [each.setting(sun, view) for view in views], WAVENUMBER_CM1[3:], thickness).sum(axis=2)
        for each in (plan.assembly, plan.assembly.at_level(7))
    )
    assert np.abs(found / exact - 1.0).max() < 0.5e-3


def test_sunlight_toward_many_views_is_that_toward_each_alone():
    albedo, moments = np.array([0.99, 0.8]), np.array([0.85, 0.7]) ** np.arange(64)[:, None]
    layers = np.array([[0.3], [4.0], [40.0]]) * np.ones(2), albedo, moments
    zenith, azimuth = np.radians(np.linspace(1.0, 25.0, 40)), np.linspace(0.0, np.pi, 40)
    together = solve_sun(*layers, np.cos(zenith), 0.8, azimuth, streams=24, modes=24)
    for place in (0, 7, 18, 39):
        alone = solve_sun(*layers, np.cos(zenith[[place]]), 0.8, azimuth[[place]], streams=24, modes=24)
        for many, one in zip(together, alone, strict=True):
            np.testing.assert_allclose(many[..., place], one[..., 0], rtol=1e-5)
