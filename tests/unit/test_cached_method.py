"""Cached methods: one computation for equal arguments, and no reference cycle that keeps the object alive."""

import gc
import weakref

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario
from hcss_twin.core.array_memory import cached_method
from hcss_twin.models.radiance.physical.execution import cached_by_spectrum
from hcss_twin.plan.make_plan import make_plan


class Owner:
    def __init__(self):
        self.calls = []
        self.twice = cached_method(self._twice, 2)
        self.spectrum = cached_by_spectrum(self._twice, maxsize=2)

    def _twice(self, value):
        self.calls.append(1)
        return 2 * value


def test_equal_arguments_are_computed_once():
    owner = Owner()
    assert [owner.twice(3), owner.twice(3), owner.twice(4)] == [6, 6, 8]
    assert owner.spectrum(np.array([1.0]))[0] == owner.spectrum(np.array([1.0]))[0] == 2.0
    assert len(owner.calls) == 3


def test_an_object_with_caches_ends_with_its_last_reference():
    gc.disable()
    try:
        owner = Owner()
        owner.twice(1)
        owner.spectrum(np.array([1.0]))
        left, twice = weakref.ref(owner), owner.twice
        del owner
        assert left() is None
    finally:
        gc.enable()
    with pytest.raises(ReferenceError, match="_twice"):
        twice(5)


def test_models_of_a_scene_end_with_the_last_reference_to_its_plan():
    gc.disable()
    try:
        plan = make_plan(Scenario.load("stratus", CHEAP | {"image.rows": 4, "image.columns": 4}), keeps_results=False)
        left = [weakref.ref(each) for each in (plan.assembly.built["radiance"], plan.assembly.transmittance)]
        del plan
        assert [each() for each in left] == [None, None]
    finally:
        gc.enable()
