"""Sections of scenarios that plugins own."""

import importlib.metadata
import sys
import types

import pytest
from pydantic import BaseModel, ConfigDict

import hcss_twin
from hcss_twin.core import sections
from hcss_twin.core.commands import hookimpl
from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.core.plugins import Origin
from hcss_twin.scenario.reference import json_schema

SCENE = {"time": "2024-04-20T02:30:00Z", "place": {"latitude": 0.0, "longitude": 0.0}}


class Lamp(BaseModel):
    """A section."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    power: float


@pytest.fixture
def plugins(monkeypatch):
    """Installed plugins with sections: a module for each name, which returns the specs given for it."""

    def install(**specs):
        entries = []
        for name, own in specs.items():
            module = types.ModuleType(f"plugin_of_{name}")
            module.Lamp = Lamp

            module.hcss_sections = hookimpl(lambda own=own: own)
            monkeypatch.setitem(sys.modules, module.__name__, module)
            entry = importlib.metadata.EntryPoint(name, module.__name__, "hcss_twin.sections")
            entries.append((Origin(name, f"dist-{name}", "1"), entry))
        monkeypatch.setattr(sections, "installed", lambda group: iter(entries))

    return install


def spec(name, plugin):
    return sections.SectionSpec(name, f"plugin_of_{plugin}:Lamp", "A lamp.")


def test_a_section_of_a_plugin_is_checked_kept_and_described(plugins):
    plugins(one=[spec("lamp", "one")])
    scenario = hcss_twin.Scenario.from_dict(SCENE | {"lamp": {"power": 3}})
    assert scenario.sections["lamp"].power == 3.0
    again = hcss_twin.Scenario.from_dict(SCENE, {"lamp.power": 3.0})
    assert again == scenario
    assert again != hcss_twin.Scenario.from_dict(SCENE)
    with pytest.raises(ScenarioError, match=r"lamp\.powr: unknown key"):
        hcss_twin.Scenario.from_dict(SCENE | {"lamp": {"powr": 3}})
    from hcss_twin.scenario.plugin_sections import owned_schemas

    assert "power" in json_schema(owned_schemas())["properties"]["lamp"]["properties"]


def test_a_missing_package_is_named_with_the_command_that_installs_it(plugins):
    plugins()
    with pytest.raises(
        ScenarioError, match=r"camera: is a section of hcss-payload.*pip install ./plugins/hcss-payload"
    ):
        hcss_twin.Scenario.from_dict(SCENE | {"camera": {}})
    with pytest.raises(ScenarioError, match="lamp: unknown key"):
        hcss_twin.Scenario.from_dict(SCENE | {"lamp": {}})


def test_two_owners_of_a_section_are_named(plugins):
    plugins(one=[spec("lamp", "one")], two=[spec("lamp", "two")])
    with pytest.raises(
        ProviderError, match=r"sections of dist-two 1 cannot be used.*'lamp' is also a section of dist-one"
    ):
        hcss_twin.Scenario.from_dict(SCENE | {"lamp": {"power": 3}})
