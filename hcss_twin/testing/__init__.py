"""Conformance kit for plugin authors: one test class per kind of provider, and sample inputs.

Inherit the class of your kind in your test suite and define how to create your provider::

    class TestMySea(SeaModelContract):
        def make_provider(self, inputs):
            return MySea(inputs, MyParameters())

pytest then checks every rule of the contract. Requires pytest.
"""

import pytest

# The classes are defined outside the test files that inherit them; this enables full assert messages.
pytest.register_assert_rewrite(
    *(
        f"hcss_twin.testing.{name}"
        for name in (
            "atmosphere_laws",
            "clouds",
            "elements",
            "optics",
            "particle_laws",
            "radiance",
            "radiance_laws",
            "registration",
            "samples",
            "sea",
            "sea_laws",
            "sensor",
            "sensor_laws",
            "surfaces",
        )
    )
)

from hcss_twin.testing.clouds import CloudGeneratorContract  # noqa: E402
from hcss_twin.testing.elements import ElementContract, KnownElement, PlainScene  # noqa: E402
from hcss_twin.testing.optics import OpticsContract, TransmittanceContract  # noqa: E402
from hcss_twin.testing.radiance import RadianceModelContract  # noqa: E402
from hcss_twin.testing.registration import assert_registered  # noqa: E402
from hcss_twin.testing.samples import (  # noqa: E402
    PlainGas,
    PlainOptics,
    PlainSea,
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
from hcss_twin.testing.sea import SeaModelContract  # noqa: E402
from hcss_twin.testing.sensor import SensorContract  # noqa: E402
from hcss_twin.testing.surfaces import SurfaceContract  # noqa: E402

__all__ = [
    "CloudGeneratorContract",
    "ElementContract",
    "KnownElement",
    "OpticsContract",
    "PlainGas",
    "PlainOptics",
    "PlainScene",
    "PlainSea",
    "RadianceModelContract",
    "SeaModelContract",
    "SensorContract",
    "SurfaceContract",
    "TransmittanceContract",
    "assert_registered",
    "sample_atmosphere_inputs",
    "sample_cloud_inputs",
    "sample_element_inputs",
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
    "sample_wavenumbers",
]
