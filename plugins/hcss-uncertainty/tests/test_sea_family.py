"""Columns interpolated between temperatures of the sea equal those at the temperature itself to single precision."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from cheap import NARROW
from hcss_uncertainty.sea_family import SeaFamily, SeaTemperatures, sea_temperatures

from hcss_twin import Scenario, make_plan
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.physics.planck import planck
from hcss_twin.providers import ColumnStates, RadianceDeclaration, Sun, clear_column, cloudy_columns

WAVENUMBER = np.array([900.0, 1100.0, 2500.0, 3160.0, 3600.0])
SUN = Sun(40.0, 120.0, 1.0)
SETTING = sample_radiance_inputs().setting
THICKNESS = np.array([[0.0], [60.0], [300.0]])
NODES = tuple((291.0 + 3.0 * np.polynomial.chebyshev.chebpts1(4)).tolist())


@dataclass(frozen=True)
class SeaOf:
    """A sea that knows its temperature."""

    kelvin: float


class KnownSea:
    """Emission with an emissivity linear in temperature, sunlight with a kink of some size at 290 K."""

    terms = {"sea": "", "sun": ""}  # noqa: RUF012
    solar_terms = frozenset({"sun"})
    declares = RadianceDeclaration(numerical_levels=2)

    def __init__(self, kink=0.0):
        self.kink, self.solved = kink, 0

    def columns(self, states, wavenumber_cm1):
        result = states.empty(self.terms, wavenumber_cm1)
        self.solved += len(states)
        for rows, setting, thickness_m in states.groups():
            kelvin = setting.sea.kelvin
            through = np.exp(-thickness_m / 100.0)
            result["sea"][rows] = through * (0.98 - 1e-4 * (kelvin - 290.0)) * planck(wavenumber_cm1, kelvin)
            result["sun"][rows] = through * (1e-3 + 1e-5 * abs(kelvin - 290.0) * self.kink)
        return result


def setting_at(kelvin):
    return replace(SETTING, sun=SUN, sea=SeaOf(kelvin), sea_temperature_K=kelvin)


def shared(model, family, kelvin):
    own = setting_at(kelvin)
    return family.sharing(model, (1, 0), own, SeaOf), own


def test_columns_follow_the_known_law_and_are_computed_once_for_all_temperatures():
    model, family = KnownSea(), SeaFamily(SeaTemperatures(NODES, "any"))
    for kelvin in (288.2, 290.7, 293.9):
        sharing, own = shared(model, family, kelvin)
        found = cloudy_columns(sharing, own, WAVENUMBER, THICKNESS)
        exact = cloudy_columns(KnownSea(), own, WAVENUMBER, THICKNESS)
        for name in model.terms:
            np.testing.assert_allclose(found[name], exact[name], rtol=1e-7)
    assert model.solved == len(NODES) * len(THICKNESS)


def test_columns_over_another_sea_and_at_one_wavenumber_are_those_of_the_model():
    model, family = KnownSea(), SeaFamily(SeaTemperatures(NODES, "any"))
    sharing, own = shared(model, family, 290.7)
    other = setting_at(280.0)
    together = sharing.columns(ColumnStates.product([own, other], THICKNESS), WAVENUMBER)
    alone = cloudy_columns(KnownSea(), other, WAVENUMBER, THICKNESS)
    np.testing.assert_array_equal(together["sea"][len(THICKNESS) :], alone["sea"])
    one = clear_column(sharing, own, WAVENUMBER[:1])
    np.testing.assert_array_equal(one["sea"], clear_column(KnownSea(), own, WAVENUMBER[:1])["sea"])


def test_columns_that_are_not_smooth_are_computed_at_the_temperature_itself():
    model, family = KnownSea(kink=1.0), SeaFamily(SeaTemperatures(NODES, "any"))
    sharing, own = shared(model, family, 290.7)
    found = clear_column(sharing, own, WAVENUMBER)
    np.testing.assert_array_equal(found["sun"], clear_column(KnownSea(1.0), own, WAVENUMBER)["sun"])


@pytest.mark.parametrize(("kelvin", "count"), [((288.0, 294.0), 4), ((275.0, 299.0), 6)])
def test_a_physical_scene_has_the_radiance_it_has_alone_to_a_step_of_single_precision(kelvin, count):
    own_K = kelvin[0] + 0.71 * (kelvin[1] - kelvin[0])

    def of(value):
        return Scenario.load("stratus", {"sea.temperature": value, "bands": NARROW, "accuracy": 1e-2})

    (temperatures,) = set(sea_temperatures([of(value) for value in np.linspace(*kelvin, 30).tolist()]))
    assert len(temperatures.nodes_K) == count
    scenario, cache = of(own_K), ResultCache()
    known, alone = (
        sum(make_plan(scenario, shelf=cache, family=family).assembly.cloudy(WAVENUMBER[1:], THICKNESS, SUN).values())
        for family in (temperatures.family(cache), None)
    )
    np.testing.assert_allclose(known, alone, rtol=2e-7)
    assert np.any(known != alone)  # it was interpolated


def test_scenes_with_another_key_a_given_surface_or_few_temperatures_are_no_family():
    def of(kelvin, **keys):
        return Scenario.load("stratus", {"sea.temperature": kelvin, **keys})

    many = [of(kelvin, seed=number) for number, kelvin in enumerate(np.linspace(288.0, 294.0, 10).tolist())]
    others = [of(290.0, **{"sea.wind_speed": 7.0}), of(291.0, **{"sea.wind_speed": 7.0})]
    found = sea_temperatures([*many, *others])
    assert len(set(found[:10])) == 1
    assert isinstance(found[0], SeaTemperatures)
    assert found[10:] == [None, None]
