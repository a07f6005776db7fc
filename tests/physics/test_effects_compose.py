"""Waves, shadows, parallax and views of a grid together, against formulas and geometry of each."""

from functools import lru_cache

import numpy as np
import pytest
from cheap import CHEAP
from hand_made import with_clouds

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.providers import Sun

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
    plan = plan_of(THICK if thick else THIN, **{"sea.waves": "resolved"})
    stripes = STRIPES * (90.0 if thick else 1.0)
    made = []
    for shadows in (True, False):
        slant = SlantPaths(shadows, False, plan.view, np.array([SUN.zenith_deg]), np.array([SUN.azimuth_deg]))
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
    plan = plan_of(THICK, **{"sea.waves": "resolved", "image.samples_per_pixel": 2} | HALF)
    slant = SlantPaths(True, False, plan.view, np.array([SUN.zenith_deg]), np.array([SUN.azimuth_deg]))
    shape = lambda y, x: np.where(y > 200, (STRIPES * 90.0)[x % 4], 0.0)  # noqa: E731
    planned = with_clouds(plan, [shape], slant, SUN, shadows=True, waves=True)
    coarse = next(stream(planned, compile_tables(planned)))
    for name in ("radiance", "radiance_sea_reflected_sun"):
        blocks = fine[name].astype(float).reshape(2, 12, 2, 20, 2)
        np.testing.assert_allclose(coarse[name], blocks.mean(axis=(2, 4)), rtol=1e-5, atol=1e-8)


HALF = {"image.rows": 12, "image.columns": 20, "image.pixel_size": 4.0}
