"""Declarations of version 1 become those of their kind, and version 1 means what it meant."""

import dataclasses
import pickle

import numpy as np
import pytest

from hcss_twin import providers
from hcss_twin.providers import Declares, OpticsDeclaration
from hcss_twin.providers.registry import Kind
from hcss_twin.providers.registry.version_1 import adapted

GRID = np.array([500.0, 501.0])
EVERYTHING = Declares(
    depends_on=frozenset({"time", "view_zenith"}),
    valid={"wavenumber_cm1": (400.0, 900.0), "view_zenith": (0.0, 60.0)},
    native_grid_cm1=GRID, resolution_cm1=2.0, evolves=True, tileable=False, notes=("a note",), legs="to_space",
    notes_by_phase={"ice": ("crystals",)}, own_errors=("5 %",), reach_pixels=None, remembers=True,
)  # fmt: skip
SPECTRUM = {"valid": {"wavenumber_cm1": (400.0, 900.0)}}
EXPECTED = {
    "clouds": {"depends_on": {"time"}, "evolves": True, "tileable": False},
    "sea": {"depends_on": {"view_zenith"}, **SPECTRUM},
    "optics": {**SPECTRUM, "materials": {"water", "ice"}, "notes_by_material": {"ice": ("crystals",)}},
    "atmosphere": {
        "valid": EVERYTHING.valid, "native_grid_cm1": GRID, "resolution_cm1": 2.0, "legs": "to_space",
    },
    "radiance": {"depends_on": {"view_zenith"}, "numerical_levels": 1},
    "elements": {},
    "sensors": {"reach_pixels": None, "remembers": True},
}  # fmt: skip


class Old:
    declares = EVERYTHING
    answer = 42


def declaration(kind):
    return getattr(providers, getattr(providers, Kind(kind).protocol).__annotations__["declares"])


@pytest.mark.parametrize("kind", EXPECTED)
def test_each_kind_gets_what_it_can_say(kind):
    provider = adapted(Old(), declaration(kind))
    assert provider.answer == 42
    assert not hasattr(provider, "path_radiance")
    assert type(provider.declares) is declaration(kind)
    found = {each.name: getattr(provider.declares, each.name) for each in dataclasses.fields(provider.declares)}
    assert found == {**EXPECTED[kind], "notes": ("a note",), "own_errors": ("5 %",)}


def test_nothing_declared_means_that_nothing_matters():
    old = Old()
    old.declares = Declares()
    assert adapted(old, declaration("sea")).declares.depends_on == frozenset()
    assert adapted(old, OpticsDeclaration).declares == OpticsDeclaration()


def test_adapted_providers_travel_to_other_processes():
    again = pickle.loads(pickle.dumps(adapted(Old(), declaration("clouds"))))
    assert again.answer == 42
    assert again.declares == adapted(Old(), declaration("clouds")).declares


def test_declares_is_of_version_1_alone():
    assert "Declares" not in providers.__all__
    with pytest.raises(AttributeError):
        _ = providers.Declare
