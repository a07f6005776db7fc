"""Conformance kit for plugin authors: one test class per kind of provider, and sample inputs.

Inherit the class of your kind in your test suite and define how to create your provider::

    class TestMySea(SeaModelContract):
        def make_provider(self, inputs):
            return MySea(inputs, MyParameters())

pytest then checks every rule of the contract. The contract classes require pytest; ``laws`` and ``samples`` do not.
"""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_twin.testing.clouds import CloudGeneratorContract
    from hcss_twin.testing.contract import assert_registered
    from hcss_twin.testing.elements import ElementContract, KnownElement, PlainScene
    from hcss_twin.testing.optics import OpticsContract, TransmittanceContract
    from hcss_twin.testing.radiance import RadianceModelContract
    from hcss_twin.testing.samples import (
        PlainGas,
        PlainOptics,
        PlainSea,
        StillScene,
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
        sample_radiance_inputs,
        sample_sea_inputs,
        sample_sensor_inputs,
        sample_surface_inputs,
        sample_wavenumbers,
    )
    from hcss_twin.testing.sea import SeaModelContract
    from hcss_twin.testing.sensor import SensorContract
    from hcss_twin.testing.surfaces import KnownSurface, SurfaceContract
    from hcss_twin.testing.variables import VariableContract, sample_fields, sample_variable_inputs

__all__ = [
    "CloudGeneratorContract",
    "ElementContract",
    "KnownElement",
    "KnownSurface",
    "OpticsContract",
    "PlainGas",
    "PlainOptics",
    "PlainScene",
    "PlainSea",
    "RadianceModelContract",
    "SeaModelContract",
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
    "sample_sea_inputs",
    "sample_sensor_inputs",
    "sample_surface_inputs",
    "sample_variable_inputs",
    "sample_wavenumbers",
]

_HOME = {
    "CloudGeneratorContract": "clouds",
    "ElementContract": "elements",
    "KnownElement": "elements",
    "KnownSurface": "surfaces",
    "OpticsContract": "optics",
    "PlainScene": "elements",
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
"""Modules of the names that need pytest or a module of their own; all others are in ``samples``."""

_REWRITTEN = (*sorted(set(_HOME.values())), "sensor_laws")
"""Modules with classes that test files inherit; pytest is to show the values in their assert statements."""


def __getattr__(name: str) -> Any:
    """Import a name of the kit when it is first used: laws and samples alone need no pytest."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    if name in _HOME:
        import pytest

        modules = (f"{__name__}.{each}" for each in _REWRITTEN)
        pytest.register_assert_rewrite(*(each for each in modules if each not in sys.modules))
    return getattr(importlib.import_module(f"{__name__}.{_HOME.get(name, 'samples')}"), name)
