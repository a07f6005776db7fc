"""The platform that carries the sensor: its height, its optics in terms of directions, and how it moves."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from hcss_twin.errors import closest
from hcss_twin.scenario.section import Section
from hcss_twin.scenario.units import Angle, InstrumentLength, Length, Speed, parse_quantity
from hcss_twin.scenario.wording import shown

ORBIT = "orbit"
LOWEST_M, HIGHEST_M = 100e3, 42_000e3
FASTEST_M_S = 1e5


def _platform_speed(value: object) -> object:
    if value == ORBIT:
        return value
    allowed = f'allowed: -{FASTEST_M_S:g} to {FASTEST_M_S:g} m/s, or "{ORBIT}"'
    if isinstance(value, str) and closest(value, (ORBIT,)):
        raise PydanticCustomError(
            "platform_speed", f"{shown(value)} is not a speed; {allowed}; closest is '{ORBIT}'"
        )
    number = parse_quantity(value, "speed")
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise PydanticCustomError("platform_speed", f"{shown(value)} is not a speed; {allowed}")
    if not -FASTEST_M_S <= number <= FASTEST_M_S:
        nearest = (
            ""
            if number != number
            else f"; closest valid choice is {FASTEST_M_S if number > 0 else -FASTEST_M_S:g}"
        )
        raise PydanticCustomError("platform_speed", f"{shown(value)} is out of range; {allowed}{nearest}")
    return float(number)


PlatformSpeed = Annotated[Speed | Literal["orbit"], BeforeValidator(_platform_speed)]
"""Of the footprint, m/s, or ``"orbit"``; a scenario that was read has the number."""


class Platform(Section):
    """The platform and its instrument; without `altitude` the distance to the sensor is not known.

    Other ways of saying `view.zenith`, `image.pixel_size` and `motion.platform_speed`: whoever gives both is told
    (docs/viewing-geometry.md).
    """

    altitude: Length | None = Field(
        None,
        ge=LOWEST_M,
        le=HIGHEST_M,
        description="Altitude of the sensor above the ellipsoid, m; the other keys need it.",
    )
    off_nadir: Angle | None = Field(
        None,
        ge=0,
        lt=90,
        description="Look angle at the sensor between nadir and the image centre, degrees; instead of `view.zenith`.",
    )
    focal_length: InstrumentLength | None = Field(
        None, gt=0, le=100, description="Focal length, m; with detector_pitch instead of `image.pixel_size`."
    )
    detector_pitch: InstrumentLength | None = Field(
        None, gt=0, le=0.01, description="Distance between detectors, m; with focal_length."
    )
    mode: Literal["staring", "push-broom"] | None = Field(
        None,
        description='"staring": the footprint stands still; "push-broom": it moves, by default as fast as a circular '
        "orbit carries it; default: as `motion.platform_speed` says.",
    )
