"""Columns interpolated between temperatures of the sea equal those at the temperature itself to single precision."""

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin import Scenario
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.physics.planck import planck
from hcss_twin.plan.assemble import assemble
from hcss_twin.plan.between_sea_temperatures import (
    ALL_COLUMNS,
    FORESEEN,
    BetweenSeaTemperatures,
    GroupColumns,
    temperatures_between,
)
from hcss_twin.plan.slant_paths import slant_paths
from hcss_twin.providers import RadianceDeclaration, Sun, View

WAVENUMBER = np.array([900.0, 1100.0, 2500.0, 3160.0, 3600.0])
SUN = Sun(40.0, 120.0, 1.0)


class KnownSea:
    """Emission with an emissivity linear in temperature, sunlight with a kink of some size at 290 K."""

    terms = {"sea": "", "sun": ""}  # noqa: RUF012
    solar_terms = frozenset({"sun"})
    declares = RadianceDeclaration(numerical_levels=2)
    calls = 0

    def __init__(self, kelvin, kink=0.0):
        self.kelvin, self.kink = kelvin, kink

    def clear(self, wavenumber_cm1, sun):
        KnownSea.calls += 1
        emitted = (0.98 - 1e-4 * (self.kelvin - 290.0)) * planck(wavenumber_cm1, self.kelvin)
        reflected = 1e-3 + 1e-5 * abs(self.kelvin - 290.0) * self.kink
        return {"sea": emitted, "sun": np.full_like(wavenumber_cm1, reflected)}

    def cloudy(self, wavenumber_cm1, thickness_m, sun):
        through = np.exp(-thickness_m / 100.0)
        return {name: through * each for name, each in self.clear(wavenumber_cm1, sun).items()}


def between(kelvin, columns, nodes_K, kink=0.0):
    return BetweenSeaTemperatures(
        KnownSea(kelvin, kink), lambda node: KnownSea(node, kink), nodes_K, kelvin, columns, (), Catalog()
    )


def test_columns_follow_the_known_law_and_are_computed_once_for_all_temperatures():
    nodes, columns = temperatures_between(np.linspace(288.0, 294.0, 30), "any").nodes_K, GroupColumns()
    thickness = np.array([[20.0], [300.0]])
    between(288.0, columns, nodes).cloudy(WAVENUMBER[1:], thickness, SUN)
    between(288.0, columns, nodes).cloudy(WAVENUMBER, thickness, SUN)  # one wavenumber is new
    before = KnownSea.calls
    for kelvin in (288.0, 290.7, 294.0):
        for name, each in between(kelvin, columns, nodes).cloudy(WAVENUMBER, thickness[::-1], SUN).items():
            np.testing.assert_allclose(each, KnownSea(kelvin).cloudy(WAVENUMBER, thickness[::-1], SUN)[name], 1e-7)
    assert KnownSea.calls == before + 3 * 2  # those of the comparison


def test_wavenumbers_that_other_scenes_will_choose_are_solved_with_those_of_the_first():
    nodes, columns = temperatures_between(np.linspace(288.0, 294.0, 30), "any").nodes_K, GroupColumns()
    chosen = {kelvin: WAVENUMBER[[0, 1 if kelvin < 291.0 else -1]] for kelvin in (290.0, 293.0)}
    asked = []

    def chosen_by(model):
        asked.append(model)
        emitted = model.clear(WAVENUMBER, SUN)
        assert set(emitted) == set(model.terms)
        return chosen[290.0 if len(asked) <= FORESEEN // 2 else 293.0]

    for _ in range(2):
        between(290.0, columns, nodes).foresee("tables", chosen_by)
    assert len(asked) == FORESEEN
    thickness = np.array([[30.0], [60.0]])
    before = KnownSea.calls
    for kelvin, own in chosen.items():
        between(kelvin, columns, nodes).cloudy(own, thickness, SUN)
        assert KnownSea.calls == before + len(nodes)
    between(290.0, columns, nodes).cloudy(WAVENUMBER, thickness, SUN)
    assert KnownSea.calls == before + 2 * len(nodes)


def test_columns_that_are_not_smooth_are_computed_at_the_temperature_itself():
    nodes = temperatures_between(np.linspace(288.0, 294.0, 30), "any").nodes_K
    result = between(290.7, GroupColumns(), nodes, kink=1.0).clear(WAVENUMBER, SUN)
    np.testing.assert_array_equal(result["sun"], KnownSea(290.7, 1.0).clear(WAVENUMBER, SUN)["sun"])


@pytest.mark.parametrize(("kelvin", "count"), [((288.0, 294.0), 4), ((280.0, 290.0), 5), ((275.0, 299.0), 6)])
def test_a_physical_scene_has_the_radiance_it_has_alone_to_a_step_of_single_precision(kelvin, count):
    group = temperatures_between(np.linspace(*kelvin, 30), "any")
    assert len(group.nodes_K) == count
    own = kelvin[0] + 0.71 * (kelvin[1] - kelvin[0])
    known, alone = total(own, group), total(own, None)
    np.testing.assert_allclose(known, alone, rtol=2e-7)
    assert np.any(known != alone)  # it was interpolated


def test_a_certificate_afresh_has_the_model_of_the_scene_alone_and_says_what_was_interpolated():
    group = temperatures_between(np.linspace(288.0, 294.0, 30), "any")
    for afresh in (0, 4):
        assembly = assembled(290.0, replace(group, afresh=afresh))
        assert isinstance(assembly.model, BetweenSeaTemperatures)
        for model in (assembly.for_references.model, assembly.for_references.at_level(2).model):
            assert isinstance(model, BetweenSeaTemperatures) != bool(afresh)
    assert "tables and the reference are" in group.text
    assert "of the tables are" in replace(group, afresh=ALL_COLUMNS).text


def total(kelvin, group):
    assembly = assembled(kelvin, group)
    cloudy = assembly.model.cloudy(WAVENUMBER, np.array([[60.0]]), SUN)
    clear = assembly.model.clear(WAVENUMBER, SUN)
    return np.concatenate([np.sum([*clear.values()], axis=0), np.sum([*cloudy.values()], axis=0)[0]])


def assembled(kelvin, group):
    scenario = Scenario.load("stratus", {"sea.temperature": kelvin})
    catalog = Catalog(base=scenario.base)
    catalog.shelf = ResultCache(several=True)
    sight = slant_paths(scenario.slant, View(scenario.view.zenith, scenario.view.azimuth), np.zeros(1), np.zeros(1))
    return assemble(scenario, catalog, sight, group)


def test_few_scenes_and_wide_ranges_are_not_interpolated():
    assert temperatures_between(np.linspace(288.0, 294.0, 7), "any") is None
    assert temperatures_between(np.linspace(270.0, 300.0, 100), "any") is None
    assert temperatures_between([290.0] * 9, "any") is None
