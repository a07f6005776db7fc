"""Cached methods: one computation for equal arguments, and no reference cycle that keeps the object alive."""

import gc
import weakref

import numpy as np
import pytest

from hcss_twin.core.cached_method import cached_method
from hcss_twin.models.radiance.physical.execution import cached_by_spectrum


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
