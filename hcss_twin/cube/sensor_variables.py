"""The table of variables that a sensor's cube holds beside the truth layers."""

from __future__ import annotations

import numpy as np

from hcss_twin.cube.spec import BAND_FRAME
from hcss_twin.cube.variables import TERM_PREFIX, VARIABLES, VariableSpec

SENSOR_ATTRIBUTE = "hcss_sensor"
"""Global attribute of a sensor's cube: what the sensor is (JSON)."""

MEASURED_RADIANCE = VariableSpec(
    name="radiance",
    dims=BAND_FRAME,
    dtype="float32",
    units="W m-2 sr-1",
    long_name="band-integrated radiance as measured",
    kind="radiance",
    description="Band-integrated radiance at the sensor after its optics, detector and converter; noise may make it "
    "negative. The radiance without them is in the clean cube.",
)

SENSOR_VARIABLES: tuple[VariableSpec, ...] = (
    VariableSpec(
        name="photon_rate",
        dims=BAND_FRAME,
        dtype="float32",
        units="s-1",
        long_name="photons per second on the detector of the pixel",
        kind="derived",
        description="Rate at which photons of the scene reach the detector of the pixel through the optics, after blur "
        "and smear, before noise and quantum efficiency.",
    ),
    VariableSpec(
        name="digital_number",
        dims=BAND_FRAME,
        dtype="int32",
        units="1",
        long_name="digital number",
        kind="derived",
        description="Number that the converter reads out.",
        lowest=0.0,
    ),
    VariableSpec(
        name="saturated",
        dims=BAND_FRAME,
        dtype="uint8",
        units="1",
        long_name="flag of values beyond the range of the sensor",
        kind="derived",
        description="1 where detector or converter are at their upper end, 2 where the converter is at 0; the radiance "
        "there is that of the end.",
        attributes={
            "flag_values": np.array([0, 1, 2], dtype=np.uint8),
            "flag_meanings": "within_range saturated cut_at_zero",
        },
        lowest=0.0,
        highest=2.0,
    ),
)


def measured_variables(names: tuple[str, ...]) -> tuple[VariableSpec, ...]:
    """Return radiance as measured and the variables of these names, in the order of the table."""
    return (MEASURED_RADIANCE, *(spec for spec in SENSOR_VARIABLES if spec.name in names))


def is_replaced(name: str) -> bool:
    """Whether a variable of the clean cube is of radiance, so that a sensor's cube does not repeat it."""
    of_radiance = {spec.name for spec in VARIABLES if spec.needs_radiance}
    return name in of_radiance or name.startswith(TERM_PREFIX)
