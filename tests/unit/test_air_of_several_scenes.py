"""Scenes of one process that have the same air compute it once, and get the same bits as alone."""

import numpy as np
import pytest

from hcss_twin import Scenario
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.result_cache import ArrayMemory, ResultCache
from hcss_twin.plan.assemble import assemble
from hcss_twin.plan.slant_paths import slant_paths
from hcss_twin.providers import Sun, View

WAVENUMBER = np.array([900.0, 2500.0, 3600.0])
THICKNESS = np.array([[60.0], [300.0]])
SUN = Sun(40.0, 120.0, 1.0)


class Counting(ArrayMemory):
    computed = 0

    def get_or_compute(self, key, compute):
        def counted():
            self.computed += 1
            return compute()

        return super().get_or_compute(key, counted)


def columns(shelf, **changes):
    scenario = Scenario.load("stratus", {"sea.temperature": 290.0, **changes})
    catalog = Catalog(base=scenario.base)
    catalog.shelf = shelf
    sight = slant_paths(scenario.slant, View(scenario.view.zenith, scenario.view.azimuth), np.zeros(1), np.zeros(1))
    assembly = assemble(scenario, catalog, sight)
    clear, cloudy = assembly.clear(WAVENUMBER, SUN), assembly.cloudy(WAVENUMBER, THICKNESS, SUN)
    return np.stack([np.concatenate((clear[name][None], cloudy[name])) for name in assembly.model.terms])


@pytest.mark.parametrize(
    ("changes", "same"),
    [
        ({"sea.temperature": 294.0}, True),
        ({"atmosphere.water_vapour_scale": 0.5}, False),
        ({"atmosphere.parameters": {"aerosol": "urban"}}, False),
    ],
)
def test_a_scene_has_the_bits_it_has_alone_after_another_with_the_same_or_other_air(changes, same):
    shelf = ResultCache(several=True)
    shelf.air = Counting()
    columns(shelf)
    before = shelf.air.computed
    after = columns(shelf, **changes)
    np.testing.assert_array_equal(after, columns(ResultCache(), **changes))
    assert before > 0
    assert (shelf.air.computed == before) == same
