"""What fails while a plan probes the radiance model and the clouds is attributed to what is wrong."""

import pytest
from cheap import CHEAP

from hcss_twin import ProviderError, Scenario, ScenarioError, make_plan
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.radiance.as_printed import AsPrinted

SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 2, "bands": ["lwir-10.8"]}


def plan():
    return make_plan(Scenario.load("stratus", SMALL))


def test_a_broken_radiance_model_is_no_problem_of_the_time(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("by a plugin")

    monkeypatch.setattr(AsPrinted, "columns", broken)
    with pytest.raises(ProviderError, match=r"as-printed.*columns\(\) raised ZeroDivisionError: by a plugin") as caught:
        plan()
    assert "allowed: times with the sun" not in str(caught.value)


def test_a_model_that_refuses_a_low_sun_is_a_problem_of_the_time(monkeypatch):
    columns = AsPrinted.columns

    def up_to_35_deg(self, states, wavenumber):
        if any(setting.sun is not None and setting.sun.zenith_deg > 35.0 for setting in states.settings):
            raise ProviderError("no sun so low")
        return columns(self, states, wavenumber)

    monkeypatch.setattr(AsPrinted, "columns", up_to_35_deg)
    with pytest.raises(ScenarioError, match=r"time: .*no sun so low; allowed: times"):
        make_plan(Scenario.load("stratus", {**SMALL, "time": "2024-04-20T16:30:00+10:00"}))


def test_a_generator_that_fails_at_every_time_is_no_problem_of_the_frames(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("by a plugin")

    monkeypatch.setattr(FractalClouds, "thickness_m", broken)
    with pytest.raises(ProviderError, match=r"thickness_m\(\) raised ZeroDivisionError: by a plugin"):
        make_plan(
            Scenario.load(
                "stratus", {**SMALL, "clouds.coverage_mode": "field", "slant.shadows": "off", "slant.parallax": "off"}
            )
        )
