"""Base class of sections, and key types used in several sections.

Particle limits apply to cloud types and scenarios. Times have a zone: a local time would be ambiguous.
"""

from __future__ import annotations

import re
from datetime import UTC, date, datetime, timedelta
from typing import Annotated, Any, Literal

from pydantic import AwareDatetime, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.errors import Problem
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.core.units import quantity_or_word
from hcss_twin.physics.viewing import GEOSTATIONARY_M


class ScenarioSection(BaseModel):
    """Base of all sections: immutable; rejects unknown keys, NaN and infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def filled(section: type[ScenarioSection], description: str) -> Any:
    """Return the field of a section that has its defaults where it is not given."""
    return Field(default_factory=lambda: section.model_validate({}), description=description)


AGREEMENT = 0.05
"""Relative difference of keys that state the same: that of numbers rounded to two digits."""

Switch = Literal["auto", "on", "off"]
"""An effect: "auto" computes it where it matters and the scene can have it; "on" refuses scenes that cannot."""


def selected(section: ScenarioSection, key: str) -> str:
    """Provider name that a section selects.

    A provider that the user did not name is always the default one, even if a plugin has the same name.
    """
    name: str = getattr(section, key)
    return name if key in section.model_fields_set else own(name)


def own(name: str) -> str:
    """Qualified name of a default provider."""
    return f"{OWN_DISTRIBUTION}/{name}"


Material = Annotated[str, Field(pattern="^[a-z][a-z0-9-]*$", max_length=40)]
"""Name of what particles are made of."""


SMALLEST_UM, LARGEST_UM = 0.001, 500.0
"""Range of effective radius, um: from a few molecules to drizzle."""

NARROWEST, WIDEST = 0.01, 0.4
"""Effective variance; at 0.5 the number of particles of a gamma distribution diverges."""

MIN_WATER_G_M3, MIN_WATER_KG_M3, MAX_WATER_KG_M3 = 1e-6, 1e-9, 0.1
"""Liquid water or ice per volume of cloud: from a thousandth of that of the thinnest cirrus on."""

THINNEST_M = 1e-3
"""Least thickness of a cloudy pixel, m: thickness is stored in single precision."""


ALLOWED = "allowed: a date and time with zone, for example 2024-04-20T12:30:00+10:00"


def parse_instant(value: object) -> datetime:
    """Return a date and time with zone, given as such or as ISO 8601 text.

    Raises
    ------
    PydanticCustomError
        If it is neither, has no zone or one with seconds, or is outside the years 1 to 9999 in UTC.
    """
    instant = _from_text(value) if isinstance(value, str) else value
    if isinstance(instant, datetime):
        offset = instant.utcoffset()
        if offset is None:
            raise _refused(
                value,
                f"has no zone; {ALLOWED}; the same in UTC is {instant.isoformat()}+00:00; local time has the zone of "
                "its place, +10:00 near 150 E",
            )
        if offset % timedelta(minutes=1):
            raise _refused(value, f"has a zone that is not in whole minutes; {ALLOWED}")
        try:
            instant.astimezone(UTC)
        except OverflowError as error:
            raise _refused(value, "is out of range; allowed: years 1 to 9999 in UTC") from error
        return instant
    if isinstance(instant, date):
        day = instant.isoformat()
        raise _refused(
            value, f"has no time of day and no zone; {ALLOWED}; closest valid choice is {day}T00:00:00+00:00"
        )
    raise _refused(value, f"is not a date and time with zone; {ALLOWED}")


def _from_text(text: str) -> datetime:
    try:
        return datetime.fromisoformat(text)
    except ValueError as error:
        leap = re.fullmatch(r"(.*[T ]\d\d:\d\d:)60(\.\d+)?(.*)", text.strip())
        if leap:
            why = f"is within a leap second; {ALLOWED}; closest valid choice is {leap[1]}59{leap[3]}"
            raise _refused(text, why) from error
        raise _refused(text, f"is not a date and time with zone; {ALLOWED}") from error


def _refused(value: object, why: str) -> PydanticCustomError:
    return PydanticCustomError("instant", f"{Problem.shown(value)} {why}")


Instant = Annotated[AwareDatetime, BeforeValidator(parse_instant)]


Range = tuple[Quantity.Whole, Quantity.Whole]


class ImageWindow(ScenarioSection):
    """Rows and columns of the image to compute, bit-identical to that part of the whole image.

    Ground coordinates, sun and clouds do not depend on the window. Numbers count from 0; the end is excluded.
    """

    rows: Range | None = Field(None, description="[first, end] of the rows; default: all.")
    columns: Range | None = Field(None, description="[first, end] of the columns; default: all.")

    def within(self, rows: int, columns: int) -> ImageWindow:
        """Return the window itself.

        Raises
        ------
        PydanticCustomError
            If it is not within an image of so many rows and columns.
        """
        for name, size in (("rows", rows), ("columns", columns)):
            given: Range | None = getattr(self, name)
            if given is None or 0 <= given[0] < given[1] <= size:
                continue
            first = min(max(given[0], 0), size - 1)
            nearest = [first, min(max(given[1], first + 1), size)]
            raise PydanticCustomError(
                "window",
                f"{name} = {Problem.shown(list(given))}; allowed: [first, end] with 0 <= first < end <= {size}, the "
                f"image's {name}; closest valid choice is {nearest}",
            )
        return self

    def slices(self, rows: int, columns: int) -> tuple[slice, slice]:
        """Return rows and columns as slices of an image of so many rows and columns."""
        return slice(*(self.rows or (0, rows))), slice(*(self.columns or (0, columns)))


ORBIT = "orbit"
LOWEST_M, HIGHEST_M = 100e3, 42_000e3
FASTEST_M_S = 1e5


PlatformSpeed = Annotated[
    Quantity.Speed | Literal["orbit"],
    BeforeValidator(quantity_or_word("speed", -FASTEST_M_S, FASTEST_M_S, ORBIT, above=f"{FASTEST_M_S:g}")),
]
"""Speed of the footprint, m/s, or ``"orbit"``, which loading replaces by the speed."""


class Platform(ScenarioSection):
    """The platform and its instrument; without `altitude` the view is orthographic.

    These keys replace `view.zenith`, `image.pixel_size` and `motion.platform_speed`; giving both is an error, unless
    they agree within 0.1 degrees or 5 %.
    """

    altitude: Quantity.Length | None = Field(
        None, ge=LOWEST_M, le=HIGHEST_M, description="Altitude above the ellipsoid, m; the other keys need it."
    )
    off_nadir: Quantity.Angle | None = Field(
        None,
        ge=0,
        lt=90,
        description="Angle at the sensor between nadir and image centre, degrees; replaces `view.zenith`.",
    )
    longitude: Quantity.Angle | None = Field(
        None,
        ge=-180,
        le=360,
        description="Longitude below a geostationary sensor, degrees east; replaces `view.zenith` and "
        "`view.azimuth`, and sets `altitude`.",
    )
    focal_length: Quantity.InstrumentLength | None = Field(
        None, gt=0, le=100, description="Focal length, m; with detector_pitch it replaces `image.pixel_size`."
    )
    detector_pitch: Quantity.InstrumentLength | None = Field(
        None, gt=0, le=0.01, description="Distance between detectors, m; with focal_length."
    )
    mode: Literal["staring", "push-broom"] | None = Field(
        None,
        description='"staring": the footprint does not move; "push-broom": it moves, by default with the speed of a '
        "circular orbit.",
    )

    @model_validator(mode="before")
    @classmethod
    def _geostationary(cls, data: Any) -> Any:
        above = isinstance(data, dict) and data.get("longitude") is not None and data.get("altitude") is None
        return {**data, "altitude": GEOSTATIONARY_M} if above else data
