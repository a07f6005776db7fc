"""Scenario sections ``[camera]``, ``[orbit]``, ``[attitude]`` and ``[jitter]``."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import time
from typing import Annotated, Any, Literal, Self

from pydantic import AwareDatetime, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import choose_from


def _hours(value: object) -> object:
    """Convert a time of day, as TOML has it or as text HH:MM, to hours."""
    if isinstance(value, str):
        try:
            value = time.fromisoformat(value.strip())
        except ValueError:
            value = None
    if isinstance(value, time) and value.tzinfo is None:
        return value.hour + (value.minute + value.second / 60.0) / 60.0
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    raise PydanticCustomError("local_time", 'not a local time; allowed: "00:00" to "23:59" without zone, or hours')


LocalTime = Annotated[Quantity.Number, BeforeValidator(_hours)]
"""Hours of a time of day."""

Pair = tuple[Quantity.Number, Quantity.Number]
Quaternion = tuple[Quantity.Number, Quantity.Number, Quantity.Number, Quantity.Number]


class Section(BaseModel):
    """Base of the sections: immutable; rejects unknown keys, NaN and infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class CameraSection(Section):
    """Detector and lens of a camera; needs `[orbit]`."""

    rows: Quantity.Whole = Field(ge=1, le=16384, description="Rows of the detector; the first is the upper one.")
    columns: Quantity.Whole = Field(ge=1, le=16384, description="Columns of the detector.")
    focal_length: Quantity.InstrumentLength = Field(ge=1e-4, le=1000, description="Focal length, m.")
    detector_pitch: Quantity.InstrumentLength = Field(ge=1e-7, le=0.01, description="Distance between detectors, m.")
    principal_point: Pair | None = Field(
        None, description="[row, column] of the optical axis; default: the middle of the detector."
    )
    radial: Pair = Field((0.0, 0.0), description="Radial distortion k1, k2 (Brown).")
    tangential: Pair = Field((0.0, 0.0), description="Tangential distortion p1, p2.")
    mounting: Quaternion = Field(
        (0.0, 0.0, 0.0, 1.0), description="Quaternion x, y, z, w that turns vectors of the camera into the body's."
    )
    integration_time: Quantity.Duration | None = Field(
        None,
        ge=0,
        le=100,
        description="Time over which pixels see the moving scene, s; default: that of [sensor], if motion"
        " smears what it measures.",
    )
    line_time: Quantity.Duration = Field(
        0.0,
        ge=-1,
        le=1,
        description="Rolling shutter: time from one row to the next, s; negative: from the last row on.",
    )
    points: Quantity.Whole | None = Field(
        None, ge=1, le=16, description="n: a pixel is the mean of n x n points; default: 3 to 8, by image.pixel_size."
    )
    climate: Literal["place", "latitude"] = Field(
        "place",
        description='Air and sea of a full disk: "place", those of the scenario, or "latitude", model '
        "atmospheres and the climatology of the sea by latitude and date.",
    )
    beyond: Literal["refuse", "missing", "limb"] = Field(
        "refuse",
        description='Pixels that see the Earth beyond zenith 75 degrees or its limb: "refuse", "missing" '
        'values, or "limb": the ground to 85 degrees, and clear air beyond.',
    )


class _ByProvider(Section):
    """A section whose keys depend on its provider."""

    def _check(self, keys: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]]) -> None:
        provider: str = self.provider  # type: ignore[attr-defined]
        given = {name for name in self.model_fields_set if getattr(self, name) is not None} - {"provider"}
        if provider not in keys:
            if given - {"parameters"}:
                raise PydanticCustomError(
                    "provider",
                    f"provider '{provider}' with {', '.join(sorted(given))}; {choose_from(provider, keys)}; a provider "
                    "of another package has its keys in parameters",
                )
            return
        required, optional = keys[provider]
        missing = [name for name in required if name not in given]
        if missing:
            others = [name for name, (needed, more) in keys.items() if provider != name and given <= {*needed, *more}]
            default = "" if "provider" in self.model_fields_set else ", the default,"
            named = ", ".join(f"'{name}'" for name in others)
            instead = f"; with {', '.join(sorted(given))}: provider = {named}" if given and others else ""
            raise PydanticCustomError("provider", f"'{provider}'{default} needs {', '.join(missing)}{instead}")
        extra = sorted(given - {*required, *optional})
        if extra:
            allowed = ", ".join((*required, *optional)) or "none"
            raise PydanticCustomError(
                "provider", f"{', '.join(extra)} given with provider '{provider}'; its keys are {allowed}"
            )


class OrbitSection(_ByProvider):
    """Trajectory of the camera."""

    provider: str = Field(
        "circular",
        description='"circular", "sun-synchronous", "geostationary", "tle", "omm", "oem", "table", or one of another '
        "package.",
    )
    altitude: Quantity.Length | None = Field(
        None, ge=1e5, le=1e8, description="circular, sun-synchronous: above the equatorial radius, m."
    )
    inclination: Quantity.Angle | None = Field(None, ge=0, le=180, description="circular: inclination, degrees.")
    node_longitude: Quantity.Angle | None = Field(
        None, ge=-360, le=360, description="circular: longitude of the ascending node at the epoch, degrees."
    )
    argument: Quantity.Angle | None = Field(
        None,
        ge=-360,
        le=360,
        description="circular, sun-synchronous: angle from the ascending node along the orbit at the epoch, degrees.",
    )
    above: Pair | None = Field(
        None,
        description="circular, sun-synchronous: [latitude, longitude] that the orbit passes, in place of node and "
        "argument.",
    )
    above_time: Quantity.Duration | None = Field(
        None, ge=-1e6, le=1e6, description="circular: when it does so, s after the epoch; default 0."
    )
    direction: Literal["ascending", "descending"] | None = Field(
        None, description='circular: of the pass above that place; default "ascending".'
    )
    local_time: LocalTime | None = Field(
        None,
        ge=0,
        lt=24,
        description='sun-synchronous: local mean solar time of the node, "13:30" or hours; with `above` it follows '
        "from the pass.",
    )
    node: Literal["ascending", "descending"] | None = Field(
        None, description='sun-synchronous: which node has that local time; default "ascending".'
    )
    epoch: AwareDatetime | None = Field(
        None,
        description="circular, sun-synchronous: instant with zone from which node, argument and above_time count; "
        "default: the start.",
    )
    longitude: Quantity.Angle | None = Field(
        None, ge=-180, le=360, description="geostationary: of the satellite, degrees east."
    )
    lines: tuple[str, ...] | None = Field(
        None, min_length=2, max_length=3, description="tle: the two lines of the elements; a name may come first."
    )
    file: str | None = Field(
        None,
        description="tle, omm: file with two lines, or a mean-elements message (text, XML, JSON, CSV); oem: ephemeris "
        "message (text, XML); table: CSV with time_s, x_m, y_m, z_m (ITRF).",
    )
    dut1: Quantity.Duration | None = Field(
        None, ge=-1, le=1, description="tle, omm, oem in frames that do not turn: UT1 - UTC, s; default 0."
    )
    pole: Pair | None = Field(
        None, description="tle, omm, oem in such frames: coordinates x, y of the pole, arc seconds; default 0."
    )
    parameters: dict[str, Any] | None = Field(None, description="Parameters of a provider of another package.")

    @model_validator(mode="after")
    def _keys(self) -> Self:
        earth = ("dut1", "pole")
        self._check(
            {
                "circular": (
                    ("altitude", "inclination"),
                    ("node_longitude", "argument", "above", "above_time", "direction", "epoch"),
                ),
                "sun-synchronous": (
                    ("altitude",),
                    ("local_time", "node", "argument", "above", "above_time", "direction", "epoch"),
                ),
                "geostationary": (("longitude",), ()),
                "tle": ((), ("lines", "file", *earth)),
                "omm": (("file",), earth),
                "oem": (("file",), earth),
                "table": (("file",), ()),
            }
        )
        if self.provider == "tle" and (self.lines is None) == (self.file is None):
            raise PydanticCustomError("provider", "'tle' needs lines or file; allowed: one of them")
        if self.provider == "sun-synchronous" and self.local_time is None and (self.above is None or self.node):
            raise PydanticCustomError(
                "provider",
                "'sun-synchronous' needs local_time, or above; allowed: local_time of the node, or the pass above a "
                "place at above_time",
            )
        if self.above is None and (self.above_time is not None or self.direction is not None):
            raise PydanticCustomError("provider", "above_time or direction without above; allowed: with it")
        if self.above is not None and (self.node_longitude is not None or self.argument is not None):
            raise PydanticCustomError("provider", "above together with node_longitude or argument; allowed: one way")
        return self


class AttitudeSection(_ByProvider):
    """Orientation of the camera's body."""

    provider: str = Field(
        "nadir", description='"nadir", "track", "push-broom", "aem", "table", or one of another package.'
    )
    latitude: Quantity.Angle | None = Field(
        None, ge=-90, le=90, description="track: of the place, degrees north; default: that of [place]."
    )
    longitude: Quantity.Angle | None = Field(
        None, ge=-180, le=360, description="track: of the place, degrees east; default: that of [place]."
    )
    altitude: Quantity.Length | None = Field(None, ge=-500, le=1e5, description="track: of the place, m; default 0.")
    roll: Quantity.Angle | None = Field(
        None, ge=-180, le=180, description="push-broom: positive looks to the right, degrees."
    )
    pitch: Quantity.Angle | None = Field(None, ge=-180, le=180, description="push-broom: toward the motion, degrees.")
    file: str | None = Field(
        None, description="aem: CCSDS message; table: CSV with time_s, x, y, z, w from the body to ITRF."
    )
    parameters: dict[str, Any] | None = Field(None, description="Parameters of a provider of another package.")

    @model_validator(mode="after")
    def _keys(self) -> Self:
        self._check(
            {
                "nadir": ((), ()),
                "track": ((), ("latitude", "longitude", "altitude")),
                "push-broom": ((), ("roll", "pitch")),
                "aem": (("file",), ()),
                "table": (("file",), ()),
            }
        )
        return self


class JitterLineSection(Section):
    """One vibration."""

    frequency: Quantity.Frequency = Field(ge=0, le=1e5, description="Frequency, Hz.")
    amplitude: tuple[Quantity.Angle, Quantity.Angle, Quantity.Angle] = Field(
        description="Around x, y and z of the body, degrees."
    )
    phase: Quantity.Angle = Field(0.0, ge=-360, le=360, description="At the start, degrees.")


class JitterSection(Section):
    """Small turns of the body: a power-law spectrum and lines."""

    rms: tuple[Quantity.Angle, Quantity.Angle, Quantity.Angle] = Field(
        (0.0, 0.0, 0.0), description='Root mean square around x, y and z, degrees or text ("20 urad"), without lines.'
    )
    lowest: Quantity.Frequency = Field(0.1, gt=0, le=1e5, description="Lower limit of the spectrum, Hz.")
    highest: Quantity.Frequency = Field(100.0, gt=0, le=1e5, description="Upper limit of the spectrum, Hz.")
    exponent: Quantity.Number = Field(2.0, ge=-2, le=6, description="Power spectral density falls as f^-exponent.")
    lines: tuple[JitterLineSection, ...] = Field((), max_length=100, description="Vibrations of single frequencies.")
    seed: Quantity.Whole | None = Field(
        None, ge=0, lt=2**63, description="Seed of the phases; default: that of the scenario."
    )
