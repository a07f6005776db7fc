"""A pass whose frames are computed when they are asked for, and what they take."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from time import perf_counter
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload
from hcss_payload.checks import PayloadError
from hcss_payload.earth import SEMI_MAJOR_AXIS_M
from hcss_payload.frames import Frame
from hcss_payload.live.target import PointTarget
from hcss_payload.pose import Pose
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.plan import Plan

_ROUNDING = 1e-9
"""Of sums of parts."""

_LATER_S = 0.01
"""Time after the start of a pass of the frame that is measured."""


@dataclass(frozen=True)
class FrameCost:
    """What a frame takes.

    Attributes
    ----------
    seconds : float
        Wall time of a frame.
    parts : mapping of str to float
        Of its parts; what is missing to ``seconds`` is none of them.
    """

    seconds: float
    parts: Mapping[str, float]

    def of_rate(self, rate_hz: float | None = None) -> str:
        """Return how many frames a second there are, and which parts are too slow for as many as are asked for."""
        text = f"{1e3 * self.seconds:.3g} ms a frame, {1.0 / self.seconds:.3g} a second"
        most_s = math.inf if rate_hz is None else (1.0 + _ROUNDING) / rate_hz
        if rate_hz is None or self.seconds <= most_s:
            return text
        slow, rest = list[str](), self.seconds
        for part, seconds in sorted(self.parts.items(), key=lambda item: -item[1]):
            if rest <= most_s:
                break
            slow.append(f"{part} {1e3 * seconds:.3g} ms")
            rest -= seconds
        if rest > most_s:
            slow.append(f"the rest {1e3 * rest:.3g} ms")
        return f"{text}; too slow for {rate_hz:g} ({1e3 / rate_hz:.3g} ms): {', '.join(slow)}"


@dataclass(frozen=True)
class StateChange:
    """A state of the scene.

    Attributes
    ----------
    number : int
        Of the state, from 1.
    begins_s, ends_s : float
        Times between which it takes the place of the one before; given to :meth:`PreparedPass.assimilate`, the first
        one repeats a run bit for bit.
    """

    number: int
    begins_s: float
    ends_s: float


class PreparedPass(ABC):
    """A pass whose frames are computed on demand; close it, or use it in a ``with`` block.

    Frames of the same pose and time have the same bits, whatever was computed before. One thread at a time may call.

    Attributes
    ----------
    method : {"fast", "cube", "keyframes"}
        How frames are computed.
    trajectory, attitude
        Of the nominal pass.
    start_s, end_s : float
    omissions : tuple of Omission
        What frames do not show, with its size.
    notes : tuple of str
        What is doubtful, and how frames are computed.
    state_number : int
        Of the scene of the last frame: how many images it has assimilated.
    errors : mapping of str to float
        Largest errors that were measured in preparation, of fast frames; the certificate of a cube has those of others.
    seconds : mapping of str to float
        Wall time of the parts of the last frame.
    state_number : int
        How many images the scene of the last frame has assimilated.
    """

    method: str
    omissions: tuple[Omission, ...] = ()
    notes: tuple[str, ...] = ()
    errors: Mapping[str, float] = {}
    seconds: Mapping[str, float] = {}
    state_number = 0

    def __init__(
        self, plan: Plan, payload: Payload, start_s: float, end_s: float, targets: Sequence[PointTarget]
    ) -> None:
        self._plan, self._payload, self._targets = plan, payload, targets
        self.trajectory, self.attitude = payload.trajectory, payload.attitude
        self.start_s, self.end_s = start_s, end_s

    @property
    def shape(self) -> tuple[int, int, int]:
        """Bands, rows and columns of frames."""
        camera = self._payload.camera
        return len(self._plan.bands), camera.rows, camera.columns

    @property
    @abstractmethod
    def has_numbers(self) -> bool:
        """Whether frames have digital numbers."""

    @property
    def stalls(self) -> int:
        """Pieces of the sky that frames had to wait for."""
        return 0

    @property
    def states(self) -> tuple[StateChange, ...]:
        """States of images that have begun or whose beginning is known, in their order."""
        return ()

    def frame(
        self,
        time_s: float,
        pose: Pose | None = None,
        out: NDArray[np.float32] | None = None,
        targets: Sequence[PointTarget] | None = None,
    ) -> Frame:
        """Return the frame of a pose.

        Parameters
        ----------
        time_s : float
            Within the pass.
        pose : Pose, optional
            Of the same time; by default that of the pass, with its jitter.
        out : ndarray of float32 (B, rows, columns), optional
            Where the radiance is written; by default a new array.
        targets : sequence of PointTarget, optional
            Those of this frame; by default the prepared ones.

        Raises
        ------
        PayloadError
            If the time is not within the pass, or the camera looks far from what the pass sees.
        """
        if not self.start_s <= time_s <= self.end_s:
            raise PayloadError(f"time_s: {time_s:g} s; allowed: {self.start_s:g} to {self.end_s:g} s, the pass")
        if pose is not None and pose.time_s != time_s:
            raise PayloadError(f"pose.time_s: {pose.time_s!r} s; allowed: {time_s!r} s, the time of the frame")
        radius = SEMI_MAJOR_AXIS_M if pose is None else float(np.linalg.norm(pose.position_m))
        if radius < SEMI_MAJOR_AXIS_M:
            raise PayloadError(
                f"pose.position_m: {1e-3 * radius:.6g} km from the Earth's centre; allowed: outside the Earth, in m"
            )
        shape = self.shape
        radiance = np.empty(shape, np.float32) if out is None else out
        if radiance.shape != shape or radiance.dtype != np.float32 or not radiance.flags.c_contiguous:
            raise PayloadError(f"out: {radiance.dtype} {radiance.shape}; allowed: contiguous float32 of shape {shape}")
        return self._frame(time_s, pose, radiance, self._targets if targets is None else targets)

    def warm_up(self, out: NDArray[np.float32] | None = None) -> FrameCost:
        """Compute a frame, which may compile for seconds, and measure what another one takes."""
        self.frame(self.start_s, out=out)
        began = perf_counter()
        self.frame(min(self.start_s + _LATER_S, self.end_s), out=out)
        return FrameCost(perf_counter() - began, dict(self.seconds))

    def assimilate(
        self, image: Any, time: datetime | None = None, begins_s: float | None = None, file: str | None = None
    ) -> int:
        """Let the scene take an image as its state, and return the number of this state; keyframes alone can.

        Raises
        ------
        PayloadError
            If the scene follows no images.
        """
        raise PayloadError(
            f"assimilate: frames of method '{self.method}' follow no images; allowed: method = 'keyframes'"
        )

    def look(self) -> list[str]:
        """Take up states that have been prepared, and return why others could not be, since the last call."""
        return []

    @abstractmethod
    def _frame(
        self, time_s: float, pose: Pose | None, radiance: NDArray[np.float32], targets: Sequence[PointTarget]
    ) -> Frame:
        """Write the radiance of a frame, and return the frame; without a pose, that of the pass."""

    def close(self) -> None:  # noqa: B027  # most have nothing to end
        """End what works beside the caller."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
