"""Simulations that the figures show: by the paper's equations, and by the corrected physics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr

Model = Literal["as-printed", "physical"]

BANDS = {"swir-2.7-3.0": "2.7-3.0 um", "mwir": "3.0-5.0 um", "lwir": "8.0-14.0 um"}
"""The paper's bands by their names in the catalog."""

_MODELS: Mapping[Model, Mapping[str, Any]] = {
    "as-printed": {
        "radiance": {"model": "as-printed", "parameters": {"glint_scale": 0.162, "cloud_sun_scale": 0.0}},
        "optics": {"provider": "mie", "parameters": {"phase_function": "henyey-greenstein"}},
        "sea.model": "cox-munk",
    },
    "physical": {
        "radiance": {"model": "physical", "parameters": {}},
        "optics": {"provider": "bulk", "parameters": {}},
        "sea.model": "rough-sea",
    },
}

_ACCURACY = {"as-printed": 1e-3, "physical": 1e-2}
"""Share of the radiance: what a picture shows, without waiting for more."""

RADIANCE_INPUTS = (
    "sea 291.4 K, wind 10 m/s (fitted to Tables II and IV with the rest of scenario baseline)",
    "as-printed: glint_scale .162 and no sunlight on the cloud (cloud_sun_scale 0), fitted to Tables II and IV",
)
"""What every picture of radiance takes besides its own choices."""


def scenario_of(name: str, model: Model, overrides: Mapping[str, Any]) -> Scenario:
    """Return a shipped scenario with one of the two models of radiance and further overrides."""
    common = {"frames.count": 1, "accuracy": _ACCURACY[model], "output.certificate": 0}
    return Scenario.load(name, {**common, **_MODELS[model], **overrides})


def simulated(name: str, model: Model, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return the cube of :func:`scenario_of`."""
    return simulate(scenario_of(name, model, overrides))


