"""An accuracy in kelvin is kept in brightness temperature, in every band."""

import json
from dataclasses import replace

import numpy as np
import pytest
from cheap import APART, CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.core.errors import CertificateWarning
from hcss_twin.engine.compile import compile_tables
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.accuracy import SHARES, share_out
from hcss_twin.plan.description import describe

SMALL = APART | {
    **CHEAP,
    "image.rows": 32,
    "image.columns": 32,
    "frames.count": 2,
    "bands": ["mwir", "lwir"],
    "output.variables": ["radiance", "brightness_temperature"],
}


@pytest.mark.parametrize("kelvin", [1.0, 0.01])
def test_cube_and_certificate_keep_the_kelvin_asked_for(kelvin):
    made = simulate(Scenario.load("stratus", {**SMALL, "accuracy": f"{kelvin:g} K", "output.certificate": 48}))
    assert made.attrs["hcss_accuracy_requested_kelvin"] == kelvin
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    achieved = json.loads(made.attrs["hcss_accuracy_achieved_kelvin"])
    assert set(achieved) == {"mwir", "lwir"}
    assert 0.0 < max(achieved.values()) < kelvin


def test_the_kelvin_achieved_are_those_of_the_worst_pixel(monkeypatch):
    """Radiance of the clear sky 1 % too high: clouds are right."""

    def wrong(plan):
        tables = compile_tables(plan)
        return replace(tables, tables=tuple(replace(each, clear=1.01 * each.clear) for each in tables.tables))

    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", wrong)
    with pytest.warns(CertificateWarning, match="NOT as specified"):
        made = simulate(Scenario.load("stratus", {**SMALL, "accuracy": "0.1 K", "output.certificate": 48}))
    clear = made.radiance.isel(time=0).to_numpy().reshape(2, -1).max(axis=1, keepdims=True)
    temperature = BrightnessTemperature(make_plan(Scenario.load("stratus", SMALL)).spectral_grid, ["mwir", "lwir"])
    off = temperature(clear) - temperature(clear / np.float32(1.01))
    achieved = json.loads(made.attrs["hcss_accuracy_achieved_kelvin"])
    np.testing.assert_allclose([achieved["mwir"], achieved["lwir"]], off[:, 0], rtol=0.05)


def test_a_kelvin_is_the_share_by_which_the_hottest_black_body_of_the_scene_grows():
    plan = make_plan(Scenario.load("stratus", {**SMALL, "accuracy": "0.1 K"}))
    made = simulate(Scenario.load("stratus", SMALL))
    temperature = BrightnessTemperature(plan.spectral_grid, ["mwir", "lwir"])
    radiance = made.radiance.isel(time=0).to_numpy()
    off = temperature(radiance * np.float32(1.0 + plan.accuracy.relative)) - temperature(radiance)
    # Nowhere more than asked for, and not much less where it decides.
    assert 0.08 < off.max() <= 0.101


def test_a_stricter_kelvin_asks_for_a_smaller_share():
    shares = [
        make_plan(Scenario.load("stratus", {**SMALL, "accuracy": text})).accuracy.relative
        for text in ("1 K", "0.1 K", "10 mK")
    ]
    np.testing.assert_allclose(np.array(shares[:2]) / shares[1:], 10.0)


def test_kelvin_that_cannot_be_kept_are_refused_with_some_that_can(monkeypatch):
    monkeypatch.setattr("hcss_twin.plan.accuracy.MIN_ACCURACY", 1e-4)
    with pytest.raises(ScenarioError, match=r"accuracy: '0.001 K' is .* closest valid choice is '0.\d+ K'"):
        make_plan(Scenario.load("stratus", {**SMALL, "accuracy": "1 mK"}))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("0.05 mK", r"accuracy: '0.05 mK' is out of range; .* closest valid choice is '0.001 K'"),
        (0.5, r"accuracy: 0.5 is out of range; allowed: 1e-06 to 0.1 .*'10 K'; closest valid choice is 0.1"),
        (10**400, r"is out of range; .* closest valid choice is 0.1"),
        (-(10**400), r"is out of range; .* closest valid choice is 1e-06"),
        (float("nan"), r"is out of range"),
        ("1 degC", r"'degC' is not a unit of accuracy; allowed: .*; closest is 'K'"),
        ("fine", r"accuracy: 'fine' is not an accuracy; allowed: a number from 1e-06 to 0.1"),
        (True, r"accuracy: true is not an accuracy"),
        ([1e-3], r"is not an accuracy"),
    ],
)
def test_what_is_no_accuracy_is_refused_with_what_is(given, told):
    with pytest.raises(ScenarioError, match=told):
        Scenario.load("stratus", {"accuracy": given})


@pytest.mark.parametrize(("given", "same"), [("0.1 %", 1e-3), ("1e-3", 1e-3), ("50 mK", "0.05 K")])
def test_text_with_a_unit_is_what_it_stands_for(given, same):
    assert Scenario.load("stratus", {"accuracy": given}).accuracy == same


def test_shares_are_those_of_the_budget():
    budget = share_out(1e-3)
    assert vars(budget) == {name: pytest.approx(1e-3 * share) for name, share in SHARES.items()}
    assert budget.total == pytest.approx(1e-3)


def test_plan_and_cube_tell_what_each_approximation_may_err_by_and_what_it_found():
    scenario = Scenario.load("stratus", {**SMALL, "accuracy": 1e-3})
    allowed = describe(make_plan(scenario))["accuracy"]
    found = json.loads(simulate(scenario).attrs["hcss_table_errors"])
    assert allowed["relative"] == 1e-3
    assert set(found) == set(allowed["budget"])
    assert 0.0 < found["thickness"] <= allowed["budget"]["thickness"]
    assert 0.0 < found["wavenumbers"] <= allowed["budget"]["wavenumbers"]
    assert found["layers"] == found["waves"] == found["shadows"] == 0.0
