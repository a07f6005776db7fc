"""Probes: laws of the kit on providers of other packages before the first frame, kept with the scene's results."""

import json
import sys
import time
from typing import ClassVar

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from hcss_author import PlainGas, PlainSea
from installed_providers import install

import hcss_twin
from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import ProviderDefect
from hcss_twin.plan import probes
from hcss_twin.plan.provider_cost import provider_costs
from hcss_twin.providers import CloudDeclaration
from hcss_twin.providers.registry import ProviderSpec, hookimpl
from hcss_twin.providers.registry.checks import keep_check
from hcss_twin.reports.plan_text import plan_text

SCENE = {**CHEAP, "image.rows": 8, "image.columns": 10, "frames.count": 1, "bands": NARROW[1:]}


class GreySea(PlainSea):
    def __init__(self, inputs, parameters):
        super().__init__(0.95)


class BrightSea(GreySea):
    def brdf(self, *arguments):
        return 1.5 * super().brdf(*arguments)


class KnownSea(BrightSea):
    expected_failures: ClassVar = {"no_more_is_reflected_than_is_not_emitted": "foam is counted twice"}


class ShySea(GreySea):
    def brdf(self, wavenumber_cm1, mu_out, mu_in, relative_azimuth):
        if mu_in.size > 1000:
            raise ValueError("too many directions")
        return super().brdf(wavenumber_cm1, mu_out, mu_in, relative_azimuth)


class SlowSea(GreySea):
    """Takes half a millisecond for each wavenumber of the BRDF."""

    seconds = 0.0

    def brdf(self, wavenumber_cm1, *arguments):
        time.sleep(5e-4 * wavenumber_cm1.size)
        SlowSea.seconds += 5e-4 * wavenumber_cm1.size
        return super().brdf(wavenumber_cm1, *arguments)


class ProductGas(PlainGas):
    """Each leg counts as 1.1 legs in optical depth: transmittances of parts do not join."""

    def __init__(self, inputs, parameters):
        super().__init__(inputs.profile)

    def transmittance(self, wavenumber_cm1, paths):
        legs = np.array([[len(path.legs)] for path in paths])
        return super().transmittance(wavenumber_cm1, paths) * 0.9**legs


class Kilometres:
    """Clouds of which the thickness is in km."""

    declares = CloudDeclaration()

    def __init__(self, inputs, parameters):
        self._layer = inputs.layer

    def thickness_m(self, time_s, rows, columns):
        field = np.zeros((rows.stop - rows.start, columns.stop - columns.start), np.float32)
        field[::2] = 1e-3 * self._layer.thickness_max_m
        return field


class Overcast:
    """A cloud of one thickness, in each of which columns and rows are what was asked for."""

    declares = CloudDeclaration()

    def __init__(self, inputs, parameters):
        self._grid, self._thickness_m = inputs.grid, inputs.layer.thickness_max_m

    def thickness_m(self, time_s, rows, columns):
        assert 0 <= rows.start < rows.stop <= self._grid.rows
        assert 0 <= columns.start < columns.stop <= self._grid.columns
        return np.full((rows.stop - rows.start, columns.stop - columns.start), self._thickness_m, np.float32)


class Plugin:
    @hookimpl
    def hcss_register_sea_models(self):
        seas = ("GreySea", "BrightSea", "KnownSea", "ShySea", "SlowSea")
        return [spec(name.replace("Sea", "-sea").lower(), name) for name in seas]

    @hookimpl
    def hcss_register_transmittance_providers(self):
        return [spec("product-gas", "ProductGas")]

    @hookimpl
    def hcss_register_cloud_generators(self):
        return [spec("kilometres", "Kilometres"), spec("overcast", "Overcast")]


def spec(name, target):
    return ProviderSpec(name, f"{__name__}:{target}", None, 3, "for a test")


@pytest.fixture(autouse=True)
def installed(monkeypatch, tmp_path):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    return install(monkeypatch, Plugin(), "odd")


def scene(**changes):
    return Scenario.load("stratus", {**SCENE, **changes})


@pytest.mark.parametrize(
    ("key", "name", "message"),
    [
        (
            "sea.model",
            "bright-sea",
            "sea model 'bright-sea' of hcss-odd 1.0 breaks the law 'no more is reflected than is not emitted' .*"
            r"albedo at mu = 1.0 is 0.075; expected at most 0.051",
        ),
        (
            "atmosphere.provider",
            "product-gas",
            "transmittance provider 'product-gas' .* breaks the law 'leg without length transmits everything' .*"
            "is 0.81; expected 1 within 1e-12",
        ),
        (
            "clouds.generator",
            "kilometres",
            "breaks the law 'thickness stays within the layer' .*thickness of cloud in m is .*; expected at least",
        ),
    ],
)
def test_nonsense_is_refused_by_name_with_law_and_numbers_before_the_first_frame(key, name, message):
    with pytest.raises(ProviderDefect, match=message):
        make_plan(scene(**{key: name}))


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (1, 40), (3, 2), (8, 8)])
def test_windows_that_probes_ask_for_lie_within_small_images(rows, columns):
    size = {"image.rows": rows, "image.columns": columns, "clouds.coverage": 1.0, "clouds.coverage_mode": "field"}
    (probe,) = make_plan(scene(**{"clouds.generator": "overcast", **size})).probes
    assert not probe.expected


def test_a_second_plan_of_the_same_version_and_parameters_asks_nothing(monkeypatch):
    first = make_plan(scene(**{"sea.model": "grey-sea"})).probes
    asked = []
    monkeypatch.setattr(probes, "probe", lambda *arguments: asked.append(arguments))
    assert make_plan(scene(**{"sea.model": "grey-sea", "seed": 5, "clouds.coverage": 0.4})).probes == first
    assert asked == []
    assert first[0].count["passed"] >= 4


def test_a_declared_failure_and_a_refusal_to_answer_are_told_and_do_not_stop_a_scene():
    known = make_plan(scene(**{"sea.model": "known-sea"}))
    assert known.probes[0].count["expected failure"] == 1
    (note,) = [note for note in known.notes if "as it declares" in note]
    assert note.startswith(
        "sea breaks a law, as it declares: no more is reflected than is not emitted: foam is counted"
    )
    shy = make_plan(scene(**{"sea.model": "shy-sea"}))
    assert any("too many directions" in each for each in shy.probes[0].unanswered)


def test_a_cube_tells_probes_and_the_last_check_of_a_plugin_and_nothing_of_shipped_providers(installed):
    chosen = scene(**{"sea.model": "grey-sea"})
    told = json.loads(hcss_twin.simulate(chosen).attrs["hcss_provider_laws"])
    assert set(told) == {"sea"}
    assert told["sea"]["hcss check"] == "not checked"
    assert told["sea"]["probes"]["passed"] >= 4
    keep_check(installed.resolve("sea", "grey-sea"), None, {"passed": 17, "failed": 1})
    told = json.loads(hcss_twin.simulate(chosen).attrs["hcss_provider_laws"])
    assert told["sea"]["hcss check"] == {"passed": 17, "failed": 1}
    assert "hcss_provider_laws" not in hcss_twin.simulate(scene()).attrs


def test_the_plan_predicts_the_cost_of_a_plugin_to_a_factor_of_four_and_of_no_shipped_provider():
    SlowSea.seconds = 0.0
    plan = make_plan(scene(**{"sea.model": "slow-sea"}))
    hcss_twin.simulate(scene(**{"sea.model": "slow-sea"}))
    taken = SlowSea.seconds
    (cost,) = provider_costs(plan)
    assert (cost.label, cost.member) == ("sea", "brdf")
    assert cost.seconds / 4.0 < taken < cost.seconds * 4.0
    assert provider_costs(make_plan(scene())) == ()
    assert "cost" in plan_text(plan)


def test_a_scene_of_shipped_providers_loads_no_law(monkeypatch):
    for name in [each for each in sys.modules if each.startswith(("hcss_author", "hcss_twin.plan.probes"))]:
        monkeypatch.delitem(sys.modules, name)
    assert make_plan(scene()).probes == ()
    assert not [name for name in sys.modules if name.startswith(("hcss_author", "hcss_twin.plan.probes"))]
