"""For authors of plugins: a new package of their own, and the conformance kit.

The kit has one test class per kind of provider, and sample inputs.

Inherit the class of your kind in your test suite and define how to create your provider::

    class TestMySea(SeaModelContract):
        def make_provider(self, inputs):
            return MySea(inputs, MyParameters())

pytest then checks every rule of the contract.
"""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_author.clouds import CloudGeneratorContract
    from hcss_author.contract import assert_registered
    from hcss_author.elements import ElementContract, KnownElement
    from hcss_author.extensions import CommandContract, EffectContract, LightContract, RaysContract, SectionContract
    from hcss_author.optics import OpticsContract, TransmittanceContract
    from hcss_author.radiance import RadianceModelContract
    from hcss_author.samples import (
        sample_atmosphere_inputs,
        sample_cloud_inputs,
        sample_element_inputs,
        sample_grid,
        sample_high_layer,
        sample_layer,
        sample_microphysics,
        sample_motion,
        sample_optics_inputs,
        sample_profile,
        sample_scene,
        sample_sea_inputs,
        sample_sensor_inputs,
        sample_surface_inputs,
        sample_wavenumbers,
    )
    from hcss_author.sea import SeaModelContract
    from hcss_author.sensor import SensorContract
    from hcss_author.surfaces import KnownSurface, SurfaceContract
    from hcss_author.variables import VariableContract, sample_fields, sample_variable_inputs
    from hcss_twin.laws.samples import PlainGas, PlainOptics, PlainScene, PlainSea, StillScene, sample_radiance_inputs

__all__ = [
    "CloudGeneratorContract",
    "CommandContract",
    "EffectContract",
    "ElementContract",
    "KnownElement",
    "KnownSurface",
    "LightContract",
    "OpticsContract",
    "PlainGas",
    "PlainOptics",
    "PlainScene",
    "PlainSea",
    "RadianceModelContract",
    "RaysContract",
    "SeaModelContract",
    "SectionContract",
    "SensorContract",
    "StillScene",
    "SurfaceContract",
    "TransmittanceContract",
    "VariableContract",
    "assert_registered",
    "sample_atmosphere_inputs",
    "sample_cloud_inputs",
    "sample_element_inputs",
    "sample_fields",
    "sample_grid",
    "sample_high_layer",
    "sample_layer",
    "sample_microphysics",
    "sample_motion",
    "sample_optics_inputs",
    "sample_profile",
    "sample_radiance_inputs",
    "sample_scene",
    "sample_sea_inputs",
    "sample_sensor_inputs",
    "sample_surface_inputs",
    "sample_variable_inputs",
    "sample_wavenumbers",
]

_HOME = {
    "CommandContract": "extensions",
    "EffectContract": "extensions",
    "LightContract": "extensions",
    "RaysContract": "extensions",
    "SectionContract": "extensions",
    "CloudGeneratorContract": "clouds",
    "ElementContract": "elements",
    "KnownElement": "elements",
    "KnownSurface": "surfaces",
    "OpticsContract": "optics",
    "RadianceModelContract": "radiance",
    "SeaModelContract": "sea",
    "SensorContract": "sensor",
    "SurfaceContract": "surfaces",
    "TransmittanceContract": "optics",
    "VariableContract": "variables",
    "assert_registered": "contract",
    "sample_fields": "variables",
    "sample_variable_inputs": "variables",
}
"""Modules of the names that need pytest."""

_SHARED = frozenset(("PlainGas", "PlainOptics", "PlainScene", "PlainSea", "StillScene", "sample_radiance_inputs"))
"""Names of ``hcss_twin.laws.samples``; all others are in ``hcss_author.samples``."""

_REWRITTEN = (*sorted(set(_HOME.values())), "sensor_laws")
"""Modules with classes that test files inherit; pytest is to show the values in their assert statements."""


def __getattr__(name: str) -> Any:
    """Import a name of the kit when it is first used: samples alone need no pytest."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    if name in _SHARED:  # spelt out, because whatever imports a computed name depends on all that can be imported
        return getattr(importlib.import_module("hcss_twin.laws.samples"), name)
    if name not in _HOME:
        return getattr(importlib.import_module(f"{__name__}.samples"), name)
    import pytest

    modules = (f"{__name__}.{module}" for module in _REWRITTEN)
    pytest.register_assert_rewrite(*(module for module in modules if module not in sys.modules))
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
