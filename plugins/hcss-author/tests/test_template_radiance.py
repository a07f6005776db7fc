"""The radiance model that ``hcss new-plugin`` writes: the kit accepts it, and a scene runs with it."""

import sys
from types import ModuleType

import numpy as np
import pytest
from hcss_author import RadianceModelContract
from hcss_author.new_plugin.templates.radiance import Parameters, Provider

import hcss_twin
from hcss_twin import Scenario
from hcss_twin.providers import ProviderSpec, hookimpl
from hcss_twin.providers.registry import Origin, Registry


class TestTemplate(RadianceModelContract):
    def make_provider(self, inputs):
        return Provider(inputs, Parameters())


@pytest.fixture
def installed(monkeypatch):
    """Install the model as ``absorbing-clouds``."""
    module = ModuleType("plugin_written")
    module.Provider, module.Parameters = Provider, Parameters
    spec = ProviderSpec("absorbing-clouds", "plugin_written:Provider", "plugin_written:Parameters", 3, "as written")
    module.hcss_register_radiance_models = hookimpl(lambda: [spec])
    module.hcss_register_radiance_models.__name__ = "hcss_register_radiance_models"
    monkeypatch.setitem(sys.modules, module.__name__, module)
    registry = Registry.defaults_only()
    registry.add(module, Origin("written", "hcss-written", "0.1.0"))
    assert not registry.broken
    monkeypatch.setattr(Registry, "discover", classmethod(lambda cls: registry))


def test_a_scene_runs_with_it(installed):
    cheap = {"radiance.model": "absorbing-clouds", "sea.model": "cox-munk", "optics.provider": "mie"}
    small = {"image.rows": 16, "image.columns": 16, "frames.count": 1, "bands": ["lwir-10.8"]}
    cube = hcss_twin.simulate(Scenario.load("stratus", cheap | small))
    radiance, cloudy = cube["radiance"].values[0, 0], cube["cloud_mask"].values[0] > 0
    assert np.all(radiance > 0.0)
    assert radiance[~cloudy].mean() > radiance[cloudy].mean()
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
