"""Cases of the thermal benchmark: complete and consistent files, laws that their radiance keeps, and our scores."""

import importlib.util
import os
import re
import sys
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from hcss_light.cases import (
    FOLDER,
    MODELS,
    case_names,
    load_case,
    read_results,
    score,
    scores,
    scores_of_results,
    table,
)
from hcss_light.monte_carlo import radiance
from hcss_light.voxels import LightError

import hcss_twin
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

NAMES = case_names()
FEW = ("step-published", "stratocumulus-day", "two-layers-night")
"""By day and night, of one and two layers, conservative and absorbing: all others are campaigns of the dear laws."""
MOST = [name if name in FEW else pytest.param(name, marks=pytest.mark.campaign) for name in NAMES]
PLUGIN = Path(__file__).parents[1]
PAGE = Path(hcss_twin.__file__).parents[1] / "docs" / "development" / "light.md"
PUBLISHED = Path(os.environ.get("HCSS_SAMPLE_DATA", "")) / "i3rc-case1"


@pytest.fixture(scope="module")
def recipe():
    """The script that writes the cases."""
    for package in ("miepython", "PythonicDISORT"):
        pytest.importorskip(package)
    path = PLUGIN / "benchmarks" / "cases.py"
    if not path.exists():
        pytest.skip("not in an installed package")
    spec = importlib.util.spec_from_file_location("recipe_of_cases", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look for their module while they are made
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def each_radiance(case):
    return np.ndindex(case.radiance.shape[:2])


def mean_noise(case, band, view):
    return np.sqrt(np.mean(case.noise[band, view] ** 2) / case.column_of.size)


def test_eight_small_cases_of_all_kinds_are_shipped():
    cases = [load_case(name) for name in NAMES]
    assert len(cases) == 8
    assert all((FOLDER / f"{name}.nc").stat().st_size <= 105_000 for name in NAMES)
    assert all(max(case.column_of.shape) <= 64 and len(case.views) <= 2 and len(case.bands) == 2 for case in cases)
    assert {float(each) for case in cases for each in case.wavelength_um} == {0.67, 3.7, 8.5, 10.8, 12.0}
    assert sum(case.sun is not None for case in cases) == 4


@pytest.mark.parametrize("name", NAMES)
def test_a_file_describes_each_of_its_numbers(name):
    with netCDF4.Dataset(FOLDER / f"{name}.nc") as file:
        assert {"title", "comment", "license"} <= set(file.ncattrs())
        numbers = [variable for variable in file.variables.values() if variable.dtype is not str]
        assert not [each.name for each in numbers if not hasattr(each, "units") or not hasattr(each, "long_name")]


@pytest.mark.parametrize("name", NAMES)
def test_the_numbers_of_a_case_agree_with_each_other(name):
    case = load_case(name)
    np.testing.assert_array_equal(case.extinction_m1, case.columns[case.column_of])
    assert np.all(np.diff(case.edges_m) > 0.0)
    assert case.edges_m[0] == 0.0
    assert np.all((case.albedo > 0.0) & (case.albedo <= 1.0))
    np.testing.assert_allclose(0.5 * np.trapezoid(case.phase, case.cosine), 1.0, rtol=1e-12)
    # Both are moments of the function that is linear between its points.
    c, p = case.cosine, case.phase
    first = (
        np.sum(np.diff(c) * (p[..., 1:] * (2.0 * c[1:] + c[:-1]) + p[..., :-1] * (2.0 * c[:-1] + c[1:])), axis=-1) / 12
    )
    np.testing.assert_allclose(case.moments[..., 1], first, rtol=1e-9)
    degrees = 2.0 * np.arange(case.moments.shape[-1]) + 1.0
    middle = np.abs(c) < np.cos(np.radians(10.0))
    for kind, band in np.ndindex(case.albedo.shape):
        series = np.polynomial.legendre.legval(c[middle], degrees * case.moments[kind, band])
        np.testing.assert_allclose(series, p[kind, band][middle], rtol=2e-3, atol=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_noise_of_the_means_is_within_what_the_benchmark_promises(name):
    case = load_case(name)
    for band, view in each_radiance(case):
        noise, mean = mean_noise(case, band, view), case.radiance[band, view].mean()
        if case.is_sunlit(band):
            assert noise < 0.003 * mean
        else:
            assert case.kelvin(band, mean + noise) - case.kelvin(band, mean) < 0.05


@pytest.mark.parametrize("name", [each for each in NAMES if "published" not in each])
def test_thermal_radiance_lies_between_that_of_the_coldest_and_the_warmest_body(name):
    case = load_case(name)
    for band, view in each_radiance(case):
        if not case.is_sunlit(band):
            lowest = case.black(band, case.temperature_K.min()) * (1.0 - case.albedo[:, band].max())
            assert case.radiance[band, view].min() > lowest
            ground = float(case.black(band, case.surface_K))
            assert np.all(case.radiance[band, view] <= ground * (1.0 + 1e-5))  # rounded to five digits


def mean_of(found):
    mean, error = found
    return mean.mean(), np.sqrt(np.sum(error**2)) / mean.size


def test_clouds_that_do_not_absorb_lose_no_light():
    """Reflected sunlight, and what reaches the ground of the light of the reversed path, add up to all."""
    case = load_case("step-published")
    assert case.albedo[0, 0] == 1.0
    dark = replace(case.voxels(0), source=np.zeros(case.kind.size), surface_source=0.0)
    given = {"scattering": case.scattering(0), "photons": 2000}
    reflected, noise = mean_of(radiance(dark, view_zenith_deg=None, sun=case.sunlight(0), seed=1, **given))
    lit = replace(dark, surface_source=1.0)
    sun = {"view_zenith_deg": case.sun.zenith_deg, "view_azimuth_deg": case.sun.azimuth_deg}
    through, other = mean_of(radiance(lit, **sun, seed=2, **given))
    reflected, noise = (np.pi * each / case.sun.vector[2] for each in (reflected, noise))
    assert abs(reflected + through - 1.0) < 4.0 * np.hypot(noise, other)
    assert np.hypot(noise, other) < 0.01


def uniform_radiance(case, band, view, column):
    """Monte Carlo radiance of a homogeneous cloud."""
    toward = case.views[view]
    own = case.voxels(band, np.broadcast_to(case.columns[column], (4, 4, case.kind.size)))
    return mean_of(
        radiance(
            own, case.scattering(band), view_zenith_deg=toward.zenith_deg, view_azimuth_deg=toward.azimuth_deg,
            sun=case.sunlight(band), photons=5000 if case.is_sunlit(band) else 1000, seed=7,
        )
    )  # fmt: skip


@pytest.mark.parametrize("name", MOST)
def test_homogeneous_clouds_have_their_plane_parallel_radiance(name):
    """By Monte Carlo and by discrete ordinates; a thinner cloud, the control, has another one."""
    case, told_apart = load_case(name), 0
    column = int(np.median(case.column_of[case.column_of > 0]))
    for band, view in each_radiance(case):
        mean, noise = uniform_radiance(case, band, view, column)
        exact = case.column_radiance[band, view]
        assert abs(mean - exact[column]) < 3.5 * noise + 2e-3 * exact[column]
        told_apart += abs(mean - exact[column // 2]) > 3.5 * noise + 2e-3 * exact[column]
    assert told_apart >= 3


@pytest.mark.filterwarnings("ignore:Some delta-scaled")
@pytest.mark.parametrize(
    ("name", "kind", "band", "depth"),
    [
        pytest.param("cumulus-night", 0, 0, 3.0, marks=pytest.mark.campaign),
        ("step-night", 0, 1, 15.0),
        pytest.param("cumulus-night", 0, 1, 0.5, marks=pytest.mark.campaign),
        ("two-layers-night", 1, 0, 3.0),
    ],
)
def test_emission_with_a_gradient_of_temperature_is_that_of_discrete_ordinates(recipe, name, kind, band, depth):
    """Which take the Planck radiance as a polynomial; a line and a parabola between the same ends are told apart."""
    case, exact = load_case(name), {}
    for curved in (False, True):
        cloud = recipe.Gradient(name, kind, band, depth, curved)
        exact[curved], (found, noise) = cloud.ordinates(case), cloud.traced(case, 8000, seed=3)
        assert np.all(np.abs(found - exact[curved]) < 3.5 * noise + 2e-4 * exact[curved])
    apart = exact[False] - exact[True]
    assert np.all(apart > 0.0)
    assert np.max(apart / noise) > 10.0


def test_sunlight_of_plane_parallel_clouds_is_that_of_adding_and_doubling():
    case = load_case("step-published")
    (sun,) = [float(case.sun.vector[2])]
    for band, view in each_radiance(case):
        toward = case.views[view]
        turned = np.radians(180.0 - abs(180.0 - abs(toward.azimuth_deg - case.sun.azimuth_deg)))
        depth = case.columns[1:] @ np.diff(case.edges_m)
        brdf, _ = solve_sun(
            depth[:, None], case.albedo[:, band], case.moments[0, band][:, None], np.array([toward.vector[2]]), sun,
            np.array([turned]), 32, 32, kept_moments=64,
        )  # fmt: skip
        np.testing.assert_allclose(case.column_radiance[band, view][1:], brdf.ravel() * sun, rtol=1e-3)


@pytest.mark.filterwarnings("ignore:Some delta-scaled")
@pytest.mark.parametrize("name", MOST)
def test_the_recipe_makes_the_clouds_optics_and_columns_of_the_file(recipe, name):
    case, made = load_case(name), recipe.case_of(name, recipe.recipes()[name])
    for field in ("edges_m", "temperature_K", "extinction_m1", "relative", "albedo", "phase", "moments", "irradiance",
                  "columns", "column_of", "photons", "kind"):  # fmt: skip
        np.testing.assert_allclose(getattr(made, field), getattr(case, field), rtol=1e-9, atol=1e-12)
    for band, column in ((0, 1), (1, len(case.columns) - 1)):
        again = recipe.plane_parallel(case, band, case.columns[column])
        # Without absorption, processors differ by 4e-8 of the irradiance that is scattered.
        np.testing.assert_allclose(again, case.column_radiance[band, :, column], rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    "name", [pytest.param("cumulus-night", marks=pytest.mark.campaign), "stratocumulus-day", "two-layers-night"]
)
def test_other_photons_find_the_radiance_of_the_file(recipe, name):
    case = load_case(name)
    few = recipe.traced(replace(case, photons=np.maximum(case.photons // 100, 10)), seed=5)
    for band, view in each_radiance(case):
        noise = np.hypot(mean_noise(case, band, view), mean_noise(few, band, view))
        assert abs(few.radiance[band, view].mean() - case.radiance[band, view].mean()) < 4.5 * noise


@pytest.mark.skipif(not PUBLISHED.is_dir(), reason="needs the published case, HCSS_SAMPLE_DATA")
@pytest.mark.parametrize(("band", "view", "file"), [(0, 1, "exp2_I602"), (1, 0, "exp4_I601")])
def test_each_cell_of_the_step_cloud_has_the_published_radiance(band, view, file):
    """The consensus of the intercomparison; mirrored, the control, it differs."""
    case = load_case("step-published")
    published = np.loadtxt(PUBLISHED / f"I3RC_cons_res_case1_{file}.txt")
    ours, noise = (np.pi * each[band, view, :, 0] / case.sun.vector[2] for each in (case.radiance, case.noise))
    mean_error = np.sqrt(np.mean(noise**2) / noise.size)
    assert abs(ours.mean() - published.mean()) < 3e-3 * published.mean() + 3.0 * mean_error
    assert mean_error < 2.5e-3 * published.mean()
    away = np.sqrt(max(np.mean((ours - published) ** 2) - np.mean(noise**2), 0.0)) / published.mean()
    assert away < 0.015
    assert np.sqrt(np.mean((np.roll(ours, 2) - published) ** 2)) / published.mean() > 0.05


@pytest.fixture(scope="module")
def ours():
    return [each for name in NAMES for each in scores(load_case(name), list(MODELS))]


def numbers(text):
    return [float(each) for each in re.findall(r"[-+]?\d+\.\d+", text)]


@pytest.mark.skipif(not PAGE.exists(), reason="not in an installed package")
def test_the_page_has_the_scores_of_our_models(ours):
    text = PAGE.read_text(encoding="utf-8").partition("<!-- benchmark -->")[2].partition("<!-- end -->")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.strip().splitlines()]
    made = table(ours)
    assert rows[0] == made[0]
    assert len(rows) == len(made) + 1
    for shown, now in zip(rows[2:], made[1:], strict=True):
        assert shown[:4] == now[:4]
        for one, other in zip(shown[4:], now[4:], strict=True):
            np.testing.assert_allclose(numbers(one), numbers(other), atol=0.11 if "%" in one else 0.011)


def test_light_between_columns_is_better_than_columns_in_slanted_views(ours):
    found = {(each.case, each.band, each.view_deg, each.azimuth_deg, each.model): each for each in ours}
    slanted = [key[:-1] for key in found if key[-1] == "source" and key[2] > 0.0]
    assert len(slanted) >= 16
    for key in slanted:
        columns, source = found[*key, "columns"], found[*key, "source"]
        assert source.rms < columns.rms


def test_scores_tell_a_radiance_that_is_off_and_no_other():
    """Monte Carlo with its own noise scores nothing; an offset scores as much as it is."""
    case = load_case("cumulus-night")
    draw = np.random.default_rng(1)
    for band, view in each_radiance(case):
        true = case.radiance[band, view] + case.noise[band, view] * draw.standard_normal(case.column_of.shape)
        right = score(case, band, view, "right", true)
        assert abs(right.bias) < 4.0 * right.noise
        assert right.rms < 2.0 * right.least
        wrong = score(case, band, view, "wrong", case.radiance[band, view] * 1.05)
        assert wrong.bias == pytest.approx(0.05)
        mean = case.radiance[band, view].mean()
        assert wrong.bias_K == pytest.approx(case.kelvin(band, 1.05 * mean) - case.kelvin(band, mean))
        assert wrong.rms > 2.0 * wrong.least


def write_results(path, values, unit="W m-2 sr-1 um-1", name="radiance"):
    with netCDF4.Dataset(path, "w") as file:
        axes = [file.createDimension(f"d{number}", size).name for number, size in enumerate(values.shape)]
        variable = file.createVariable(name, "f8", axes)
        variable.units, variable[...] = unit, values


def test_results_of_another_code_are_scored(tmp_path):
    case = load_case("step-night")
    write_results(tmp_path / "mine.nc", case.radiance)
    np.testing.assert_allclose(read_results(case, tmp_path / "mine.nc"), case.radiance, rtol=1e-6)
    found = list(scores_of_results(case, tmp_path / "mine.nc", "mine"))
    assert [each.model for each in found] == ["mine"] * 4
    assert all(each.bias == 0.0 for each in found)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"unit": "mW"}, r"radiance\.units: 'mW'; allowed: 'W m-2 sr-1 um-1'"),
        ({"name": "intensity"}, "variables intensity; allowed: radiance among them"),
        ({"values": np.ones((2, 2, 3, 1))}, r"shape \(2, 2, 3, 1\); allowed: \(2, 2, 32, 1\)"),
        ({"values": np.full((2, 2, 32, 1), np.nan)}, "allowed: finite, from 0 on"),
    ],
)
def test_results_that_cannot_be_scored_are_named(tmp_path, changes, named):
    case = load_case("step-night")
    write_results(tmp_path / "mine.nc", **({"values": case.radiance} | changes))
    with pytest.raises(LightError, match=named):
        read_results(case, tmp_path / "mine.nc")


def test_an_unknown_case_is_named():
    with pytest.raises(LightError, match=r"case: 'cumulus'; allowed: cumulus-day"):
        load_case("cumulus")


def test_slanted_rays_are_of_one_layer():
    with pytest.raises(LightError, match="model 'slant': case two-layers-night has 2 layers; allowed: 1"):
        MODELS["slant"](load_case("two-layers-night"), 0, 0)
