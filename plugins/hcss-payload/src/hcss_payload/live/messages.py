"""What other processes may ask of a server of live frames: commands as JSON, checked before anything is done.

Everything that a stranger may send ends as a :class:`Command` or as a :class:`PayloadError` that names the field.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hcss_payload.checks import PayloadError
from hcss_payload.live.ring import MOST_BANDS, MOST_TARGETS, NUMBERS
from hcss_payload.live.target import PointTarget
from hcss_twin.providers import choose_from

MOST_BYTES = 65536
"""Of a command; 64 targets of 16 bands take a quarter of it."""

_SHOWN = 60
"""Characters of a value in errors."""

Number = Annotated[float, Field(allow_inf_nan=False)]


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class TargetMessage(_Message):
    """A point target, as :class:`~hcss_payload.live.target.PointTarget`."""

    latitude_deg: Number
    longitude_deg: Number
    altitude_m: Number
    intensity: Annotated[list[Number], Field(min_length=1, max_length=MOST_BANDS)]
    velocity_m_s: Annotated[list[Number], Field(min_length=3, max_length=3)] = [0.0, 0.0, 0.0]

    def target(self) -> PointTarget:
        """Return the target."""
        east, north, up = self.velocity_m_s
        place = self.latitude_deg, self.longitude_deg, self.altitude_m
        return PointTarget(*place, intensity=tuple(self.intensity), velocity_m_s=(east, north, up))


class _WithTargets(_Message):
    targets: Annotated[list[TargetMessage], Field(max_length=MOST_TARGETS)] | None = None

    def point_targets(self) -> list[PointTarget] | None:
        """Return the targets; None: those of the server."""
        return None if self.targets is None else [message.target() for message in self.targets]


class PoseCommand(_WithTargets):
    """Asks for the frame of a pose; the reply has its image."""

    command: Literal["pose"]
    time_s: Number
    position_m: Annotated[list[Number], Field(min_length=3, max_length=3)]
    quaternion: Annotated[list[Number], Field(min_length=4, max_length=4)]
    pose_number: Annotated[int, Field(ge=0, lt=NUMBERS)] = 0

    def values(self) -> NDArray[np.float64]:
        """Return time, position and quaternion (8,)."""
        return np.array([self.time_s, *self.position_m, *self.quaternion])


class ElementsCommand(_WithTargets):
    """Sets the targets of all later frames whose pose brings none; without targets, those of the start again."""

    command: Literal["elements"]


class AssimilateCommand(_Message):
    """Lets the scene take the image of a file as its state."""

    command: Literal["assimilate"]
    file: Annotated[str, Field(min_length=1, max_length=4096)]
    begins_s: Number | None = None


class DescribeCommand(_Message):
    """Asks for shape, type and times of frames, the states of the scene, and the counts."""

    command: Literal["describe"]


class StopCommand(_Message):
    """Ends the server."""

    command: Literal["stop"]


Command = PoseCommand | ElementsCommand | AssimilateCommand | DescribeCommand | StopCommand

COMMANDS: dict[str, type[Command]] = {
    "pose": PoseCommand,
    "elements": ElementsCommand,
    "assimilate": AssimilateCommand,
    "describe": DescribeCommand,
    "stop": StopCommand,
}


def command_of(parts: Sequence[bytes]) -> Command:
    """Return the command of a message.

    Raises
    ------
    PayloadError
        If it is none; names the field, its value and what is allowed.
    """
    if len(parts) != 1:
        raise PayloadError(f"message: {len(parts)} parts; allowed: one, the command as JSON")
    if len(parts[0]) > MOST_BYTES:
        raise PayloadError(f"message: {len(parts[0])} bytes; allowed: up to {MOST_BYTES}")
    try:
        values = json.loads(parts[0].decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise PayloadError(f"message: no JSON ({_short(str(error))}); allowed: an object in UTF-8") from error
    if not isinstance(values, dict):
        raise PayloadError(f"message: {_short(values)}; allowed: an object with 'command'")
    name = values.get("command")
    if not isinstance(name, str) or name not in COMMANDS:
        shown = name if isinstance(name, str) else repr(name)
        raise PayloadError(f"command: {_short(name)}; {choose_from(shown[:_SHOWN], tuple(COMMANDS))}")
    try:
        return COMMANDS[name].model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        field = ".".join(_short(part).strip("'") for part in first["loc"]) or "message"
        if first["type"] == "extra_forbidden":
            allowed = choose_from(str(first["loc"][-1])[:_SHOWN], tuple(COMMANDS[name].model_fields))
            raise PayloadError(f"{field}: no key of '{name}'; {allowed}") from error
        if first["type"] == "missing":
            raise PayloadError(f"{field}: is missing; allowed: a value, which '{name}' needs") from error
        allowed = first["msg"].removeprefix("Input should be ").removeprefix("List should have ")
        raise PayloadError(f"{field}: {_short(first['input'])}; allowed: {allowed}") from error


def _short(value: Any) -> str:
    text = ascii(value) if not isinstance(value, str) or not value.isprintable() else f"'{value}'"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
