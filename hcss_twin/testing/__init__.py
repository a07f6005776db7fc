"""Conformance kit for plugin authors: one class of tests per kind of provider, and inputs to try it on.

Inherit the class of your kind in your own test-suite and say how your provider is made::

    class TestMySea(SeaModelContract):
        def make_provider(self, inputs):
            return MySea(inputs, MyParameters())

pytest then checks every law of the contract. Needs pytest.
"""

import pytest

# The classes live outside the test files that inherit them; this gives their asserts full messages.
pytest.register_assert_rewrite(
    *(
        f"hcss_twin.testing.{name}"
        for name in ("clouds", "optics", "radiance", "registration", "samples", "sea", "sensor")
    )
)

from hcss_twin.testing.clouds import CloudGeneratorContract  # noqa: E402
from hcss_twin.testing.optics import OpticsContract, TransmittanceContract  # noqa: E402
from hcss_twin.testing.radiance import RadianceModelContract  # noqa: E402
from hcss_twin.testing.registration import assert_registered  # noqa: E402
from hcss_twin.testing.samples import (  # noqa: E402
    PlainGas,
    PlainOptics,
    PlainSea,
    sample_atmosphere_inputs,
    sample_cloud_inputs,
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
    sample_wavenumbers,
)
from hcss_twin.testing.sea import SeaModelContract  # noqa: E402
from hcss_twin.testing.sensor import SensorContract  # noqa: E402

__all__ = [
    "CloudGeneratorContract",
    "OpticsContract",
    "PlainGas",
    "PlainOptics",
    "PlainSea",
    "RadianceModelContract",
    "SeaModelContract",
    "SensorContract",
    "TransmittanceContract",
    "assert_registered",
    "sample_atmosphere_inputs",
    "sample_cloud_inputs",
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
    "sample_wavenumbers",
]
