"""A process that computes keyframes of one state of a scene, and that prepares the next state from an image.

It has a processor of its own where there are several, and gives way to the process that makes frames: neither the
analysis of an image nor the tables of a new state hold those up.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import os
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from hcss_payload.build import Payload
from hcss_payload.live.ring import attached
from hcss_payload.live.scene_pass import ScenePass
from hcss_twin import Scenario
from hcss_twin.plan.few_columns import Omission
from hcss_twin.providers import HcssError

FOLLOWERS = "hcss_payload.followers"
"""Entry point group: the name is that of a generator of clouds."""

NICE = 10
"""By how much the process gives way to others."""


class Follower(Protocol):
    """How a scene follows images; packages name theirs by the entry point group :data:`FOLLOWERS`."""

    def read(self, path: Path) -> tuple[Any, datetime]:
        """Return an image and its time."""

    def assimilated(self, scenario: Scenario, image: Any, time: datetime) -> Scenario:
        """Return the scenario of the next state: the same for the same scenario, image and time."""


@dataclass(frozen=True)
class Image:
    """What the next state is made of.

    Attributes
    ----------
    follower : str
        ``"module:object"``.
    image : object
        None: that of ``file``.
    """

    follower: str
    image: Any
    time: datetime | None
    file: str | None = None


@dataclass(frozen=True)
class Setup:
    """What a process needs.

    Attributes
    ----------
    scenario : str
        As JSON: that of the state, or of the one before, if there is an image to be assimilated.
    payload : Payload
        Of keyframes: a larger camera, without jitter.
    memory : str
        Where keyframes are written.
    slots : int
    """

    scenario: str
    base: str
    payload: Payload
    start_s: float
    end_s: float
    shape: tuple[int, int, int]
    image: Image | None = None
    memory: str = ""
    slots: int = 0

    def with_memory(self, name: str, slots: int) -> Setup:
        """Return what another process needs, with the name of the memory."""
        return replace(self, memory=name, slots=slots)


@dataclass(frozen=True)
class Ready:
    """A state that can be computed.

    Attributes
    ----------
    height_m : float
        Where the lines of sight of keyframes meet the scene.
    """

    scenario: str
    height_m: float
    omissions: tuple[Omission, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Wanted:
    """A keyframe, and the slot in which it is written; it comes back when it is there."""

    number: int
    time_s: float
    slot: int


@dataclass(frozen=True)
class Failed:
    """Why there is no state or keyframe."""

    error: str


def follower_of(name: str) -> Follower:
    """Return the object of a name ``"module:object"``."""
    module, _, attribute = name.partition(":")
    follower: Follower = getattr(importlib.import_module(module), attribute)
    return follower


def follower_named(scenario: Scenario) -> str | None:
    """Return the name of the follower of the generator of a scenario's clouds; None if none follows images."""
    of = {entry.name: entry.value for entry in importlib.metadata.entry_points(group=FOLLOWERS)}
    names = [layer.generator.rpartition("/")[2] for layer in scenario.clouds.layers]  # without the distribution
    return next((of[name] for name in names if name in of), None)


def scenario_after(setup: Setup) -> Scenario:
    """Return the scenario of a state."""
    scenario = Scenario.from_dict(json.loads(setup.scenario), base=Path(setup.base))
    image = setup.image
    if image is None:
        return scenario
    follower = follower_of(image.follower)
    if image.file is not None:
        return follower.assimilated(scenario, *follower.read(Path(image.file)))
    assert image.time is not None
    return follower.assimilated(scenario, image.image, image.time)


def work(connection: Connection) -> None:
    """Prepare the state, and compute keyframes until the other side ends."""
    setup: Setup = connection.recv()
    scenario = scenario_after(setup)
    computed = ScenePass(scenario, setup.payload, setup.start_s, setup.end_s, (), 0.0)
    memory = attached(setup.memory)
    frames = np.ndarray((setup.slots, *setup.shape), np.float32, memory.buf)
    connection.send(Ready(scenario.to_json(), computed.height_m, computed.omissions, computed.notes))
    while (wanted := connection.recv()) is not None:
        computed.frame(wanted.time_s, out=frames[wanted.slot], targets=())
        connection.send(wanted)


def main() -> None:
    """Work for the process at the other end of the pipe whose number is the argument."""
    with suppress(OSError):
        os.nice(NICE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the server, which ends this
    with Connection(int(sys.argv[1])) as connection:
        try:
            work(connection)
        except (EOFError, BrokenPipeError):
            pass
        except Exception as error:
            with suppress(OSError):
                connection.send(Failed(str(error) if isinstance(error, HcssError) else repr(error)))
            if not isinstance(error, HcssError):
                raise
