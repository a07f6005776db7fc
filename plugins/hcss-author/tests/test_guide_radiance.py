"""The radiance model that the guide for plugin authors shows: the kit accepts it, and a scene runs with it."""

import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hcss_author import RadianceModelContract

import hcss_twin
from hcss_twin import Scenario
from hcss_twin.providers import ProviderSpec, hookimpl
from hcss_twin.providers.registry import Origin, Registry

GUIDE = Path(hcss_twin.__file__).parents[1] / "docs" / "how-to" / "write-a-plugin.md"
pytestmark = pytest.mark.skipif(not GUIDE.exists(), reason="not in an installed package")


def shown_model():
    """Return the class that the guide shows, in a module of its own."""
    section = GUIDE.read_text(encoding="utf-8").partition("\n### Radiance model\n")[2].partition("\n### ")[0]
    (code,) = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    module = ModuleType("model_of_the_guide")
    exec(compile(code, str(GUIDE), "exec"), vars(module))
    return module.AbsorbingClouds


class TestShown(RadianceModelContract):
    def make_provider(self, inputs):
        return shown_model()(inputs, None)


@pytest.fixture
def installed(monkeypatch):
    """Install the model as ``absorbing-clouds``."""
    module = ModuleType("plugin_of_the_guide")
    module.AbsorbingClouds = shown_model()
    spec = ProviderSpec("absorbing-clouds", "plugin_of_the_guide:AbsorbingClouds", None, 3, "the guide's model")
    module.hcss_register_radiance_models = hookimpl(lambda: [spec])
    module.hcss_register_radiance_models.__name__ = "hcss_register_radiance_models"
    monkeypatch.setitem(sys.modules, module.__name__, module)
    registry = Registry.defaults_only()
    registry.add(module, Origin("guide", "hcss-guide", "0.1.0"))
    assert not registry.broken
    monkeypatch.setattr(Registry, "discover", classmethod(lambda cls: registry))


def test_a_scene_runs_with_the_shown_model(installed):
    cheap = {"radiance.model": "absorbing-clouds", "sea.model": "cox-munk", "optics.provider": "mie"}
    small = {"image.rows": 16, "image.columns": 16, "frames.count": 1, "bands": ["lwir-10.8"]}
    cube = hcss_twin.simulate(Scenario.load("stratus", cheap | small))
    radiance, cloudy = cube["radiance"].values[0, 0], cube["cloud_mask"].values[0] > 0
    assert np.all(radiance > 0.0)
    assert radiance[~cloudy].mean() > radiance[cloudy].mean()
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")
