"""The budget of the total error: figures of providers become a band's, in both units, and unknown ones stay unknown."""

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmark_module import benchmark_module
from cheap import CHEAP
from example_cube import example_frame, example_header
from pages import read_page

import hcss_twin
from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import ProviderDefect
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.error_budget import ENGINE, NUMERICS, ErrorBudget, beyond_accuracy, error_budget, left_out
from hcss_twin.plan.error_contributions import Contribution
from hcss_twin.providers import ModelError

MODELS = Path(__file__).parents[2] / "hcss_twin" / "models"
C2_CM_K = 1.438777
"""Second radiation constant, cm K."""


@pytest.fixture(scope="module")
def plan():
    bands = [[3.7, 3.8], [10.5, 11.0], [8.0, 12.0]]
    return make_plan(Scenario.load("stratus", {**CHEAP, "image.rows": 8, "image.columns": 8, "bands": bands}))


class Stating:
    """A provider that states figures of its errors."""

    def __init__(self, *errors):
        self._errors = errors

    def model_errors(self):
        return self._errors


def of_providers(plan, of, band, **providers):
    """Contributions to a class and band of a scene with other providers, without those of engine and numerics."""
    budget = error_budget(replace(plan, assembly=replace(plan.assembly, **providers)))
    return [each for each in budget.contributions[of, plan.bands[band].name] if each.name not in (ENGINE, NUMERICS)]


def contribution(plan, band, *errors, of="clear"):
    """That of gas."""
    every = of_providers(plan, of, band, transmittance=Stating(*errors))
    (found,) = (each for each in every if each.name == "gas")
    return found


def on_the_page(cell, path):
    """Total error of a class and band, in percent and kelvin, on the page of a cube."""
    attributes = {"hcss_error_budget": json.dumps({"clear": {"x": cell}})}
    header = example_header(variables=tuple(expand(["cloud_mask"], {})), attributes=attributes)
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
    ((of, band, percent, kelvin, _),) = read_page(hcss_twin.report(path, replace=True)).table("class", "band")
    assert (of, band) == ("clear", "x")
    return f"{percent} {kelvin}"


def test_the_total_is_the_root_of_the_sum_of_squares_of_what_is_known():
    own = (Contribution("a", 0.03, 1.5, 1.0), Contribution("b", 0.04, 2.0, 0.5), Contribution("c"))
    budget = ErrorBudget({("clear", "x"): own})
    assert budget.total(("clear", "x")) == pytest.approx((0.05, 2.5))
    assert budget.lines == (
        "clear x: at least 5 % (2.5 K): b 4 % (2 K) of 50 % of the band, a 3 % (1.5 K), "
        "unknown: b in 50 % of the band, c",
    )


@pytest.mark.parametrize(
    ("third", "unknown"),
    [((), []), ((Contribution("gas"),), ["gas"]), ((Contribution("sea", 0.0, 0.0, 0.2),), ["sea in 80 % of the band"])],
)
def test_an_error_of_which_a_part_is_unknown_has_no_total_and_is_at_least_that_wherever_it_is_shown(
    third, unknown, tmp_path
):
    budget = ErrorBudget(
        {("clear", "x"): (Contribution("a", 0.03, 1.5, 1.0), Contribution("b", 0.04, 2.0, 1.0), *third)}
    )
    cell = budget.as_dict()["clear"]["x"]
    (line,), (short,) = budget.lines, budget.totals
    of_earlier_versions = {**cell, "total": 0.05, "total_K": 2.5}
    shown = (line, short, *(on_the_page(each, tmp_path / "cube.nc") for each in (cell, of_earlier_versions)))
    assert [("at least" in text) for text in shown] == [bool(unknown)] * 4
    assert cell["unknown"] == unknown
    assert ("total" in cell, "total_K" in cell) == (not unknown, not unknown)
    assert (cell.get("at_least"), cell.get("total")) == ((0.05, None) if unknown else (None, 0.05))
    assert all(each.split()[0] in short and each in line for each in unknown)


def test_a_provider_that_states_only_other_paths_is_unknown_on_the_way_up(plan):
    sky = ModelError(name="gas", lower_um=8.0, upper_um=14.0, relative=0.1, path="sky")
    assert contribution(plan, 1, sky).unknown == "gas"


def test_kelvin_follow_from_the_derivative_of_planck(plan):
    found = contribution(plan, 1, ModelError(name="gas", lower_um=8.0, upper_um=14.0, relative=0.02))
    x = C2_CM_K * (1e4 / 10.75) / plan.assembly.sea_temperature_K
    per_kelvin = x / (1.0 - math.exp(-x)) / plan.assembly.sea_temperature_K
    assert found.kelvin == pytest.approx(0.02 / per_kelvin, rel=2e-3)
    back = contribution(plan, 1, ModelError(name="gas", lower_um=8.0, upper_um=14.0, kelvin=found.kelvin))
    assert back.relative == pytest.approx(0.02, rel=1e-9)


def test_a_band_has_the_mean_of_its_wavelengths_weighted_with_black_body_radiance(plan):
    errors = [
        ModelError(name="gas", lower_um=8.0, upper_um=9.0, relative=0.1),
        ModelError(name="gas", lower_um=9.0, upper_um=11.0, relative=0.02),
    ]
    found = contribution(plan, 2, *errors)
    um = np.linspace(8.0, 12.0, 4001)
    radiance = um**-5.0 / np.expm1(C2_CM_K * 1e4 / um / plan.assembly.sea_temperature_K)
    low, high = radiance[um <= 9.0].sum(), radiance[(um > 9.0) & (um <= 11.0)].sum()
    assert found.relative == pytest.approx((0.1 * low + 0.02 * high) / (low + high), rel=0.02)
    assert found.known == pytest.approx((low + high) / radiance.sum(), rel=0.02)


def test_only_figures_of_this_column_view_sun_and_path_count(plan):
    fitting = ModelError(name="gas", lower_um=8.0, upper_um=14.0, relative=0.01)
    others = [
        ModelError(name="gas", lower_um=8.0, upper_um=14.0, relative=0.5, **each)
        for each in (
            {"column": "cloudy"},
            {"zenith_deg": (40.0, 90.0)},
            {"sunlight": not plan.sun_matters},
            {"path": "sun"},
        )
    ]
    assert contribution(plan, 1, fitting, *others).relative == pytest.approx(0.01)
    assert contribution(plan, 1, fitting, *others, of="paper-stratus").relative == pytest.approx(0.5)
    assert contribution(plan, 0, fitting).relative is None


def test_a_provider_that_states_nothing_is_unknown(plan):
    for silent in (object(), Stating()):
        gas, particles = Contribution("gas"), Contribution("particles")
        silent_providers = {"transmittance": silent, "optics_of_layers": (silent,)}
        clear, cloudy = (of_providers(plan, of, 0, **silent_providers) for of in ("clear", "paper-stratus"))
        assert gas in clear
        assert gas in cloudy
        assert particles in cloudy
        assert "particles" not in [each.name for each in clear]


def test_figures_without_a_size_are_refused():
    with pytest.raises(ValueError, match="one or both"):
        ModelError(name="gas", lower_um=3.0, upper_um=5.0)
    with pytest.raises(ValueError, match="path 'skies'"):
        ModelError(name="gas", lower_um=3.0, upper_um=5.0, relative=0.1, path="skies")


def test_the_guard_refuses_what_are_no_figures(plan):
    guarded = plan.assembly.transmittance
    provider = type("Bad", (), {"model_errors": lambda self: ["3 %"]})()
    with pytest.raises(ProviderDefect, match="a sequence of ModelError"):
        type(guarded)(provider, "atmosphere 'bad'").model_errors()


def test_the_budget_of_a_scene_names_every_cause_and_the_model_that_avoids_it(plan):
    budget = error_budget(plan)
    names = {cell: [each.name for each in own] for cell, own in budget.contributions.items()}
    bands = [band.name for band in plan.bands]
    assert list(names) == [(of, band) for of in ("clear", "paper-stratus") for band in bands]
    assert names["clear", bands[1]][:4] == ["engine", "numerics", "gas", "sea"]
    assert {"particles", "single scattering", "plane-parallel clouds"} <= set(names["paper-stratus", bands[1]])
    assert "phase function of ice" not in names["paper-stratus", bands[1]]
    assert any("needs radiance.model = 'physical'" in each for each in budget.beyond(plan.accuracy.relative))
    assert all("numerics" not in budget.unknown(cell) for cell in budget.contributions)
    numerics = plan.numerics.error + plan.grid_refinement.error
    measured = error_budget(plan, {bands[0]: 1e-5})
    assert [each.relative for each in measured.contributions["clear", bands[0]][:2]] == [1e-5, numerics]


def test_clouds_that_no_pixel_has_are_no_class(plan):
    clear = Scenario.load("stratus", {**CHEAP, "clouds.coverage": 0.0, "bands": [[10.5, 11.0]]})
    assert {of for of, _ in error_budget(make_plan(clear)).contributions} == {"clear"}
    assert {of for of, _ in error_budget(plan).contributions} == {"clear", "paper-stratus"}


def test_a_scene_is_within_if_nothing_left_out_exceeds_its_share(plan):
    budget = error_budget(plan)
    left = {
        "waves as shapes": beyond_accuracy(plan),
        "shadows of clouds on the sea": left_out(plan, budget),
        "clouds within the footprint of a pixel": left_out(plan, budget),
    }
    for what, texts in left.items():
        assert any(text.startswith(what) and ", needs " in text for text in texts)
    loose = replace(plan, accuracy=RequestedAccuracy(1e3))
    assert not beyond_accuracy(loose)
    assert not left_out(loose, error_budget(loose))


def test_every_figure_has_a_source_and_a_command_or_is_one_of_notes():
    tables = sorted(MODELS.rglob("model_errors.csv"))
    assert len(tables) == 4
    for path in tables:
        for row in csv.DictReader(path.read_text(encoding="utf-8").splitlines()):
            assert row["source"]
            assert row["condition"]
            assert row["command"] or row["name"] in ("gas", "plane-parallel clouds")


def test_the_figures_of_the_sea_are_what_the_command_computes():
    module = benchmark_module("model_errors")
    before = module.read(MODELS / "sea" / "model_errors.csv")
    assert not list(module.differences(before, list(module.sea_rows())))
    wrong = [{**before[0], "relative": "0.5"}, *before[1:]]
    assert len(list(module.differences(wrong, before))) == 1


@pytest.mark.parametrize(("factor", "ratio", "share"), [(1.0, 1.0, 90.0), (0.5, 0.5, 59.0), (2.0, 2.0, 100.0)])
def test_coverage_of_normal_errors_is_ninety_percent_and_shows_a_sigma_that_is_too_small_or_wide(factor, ratio, share):
    found = np.random.default_rng(1).normal(0.0, [0.5, 3.0], (4000, 2))
    stated = factor * np.broadcast_to([0.5, 3.0], found.shape)
    for cell in benchmark_module("seviri_boxes").coverage(found, stated):
        _, of_rms, within, _ = cell.split()
        assert float(of_rms) == pytest.approx(ratio, rel=0.04)
        assert float(within) == pytest.approx(share, abs=2.0)
