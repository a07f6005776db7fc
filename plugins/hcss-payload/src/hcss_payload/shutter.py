"""Shutter of a camera: the instants within its integration time, and lines that are read in turn.

A pixel is the mean over the integration time. Each of its points stands for one instant, such that every row and every
column of points has all of them: then the mean covers area and time at the cost of the area alone. Two instants for
each pixel of smear suffice, since more would be closer than the points.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hcss_payload.attitude import Attitude
from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError
from hcss_payload.jitter import Jitter
from hcss_payload.pose import Pose, pose_at
from hcss_payload.rays import meet
from hcss_payload.trajectory import Trajectory
from hcss_twin.providers import Array

PoseAt = Callable[[float], Pose]

LEAST_SMEAR_PX = 0.1
"""Smear below which the scene stands still: the contrast between neighbouring pixels would change by 0.4 %."""

MOST_INSTANTS = 16
"""Largest number of instants: half as many pixels of smear."""

_PER_PIXEL = 2.0
"""Instants for each pixel of smear."""


@dataclass(frozen=True, eq=False)
class LinePoses:
    """Poses of the lines of a detector, between which poses are linear.

    Attributes
    ----------
    position_m : ndarray (rows + 2, 3)
        Of the lines from -1 on.
    turn : ndarray (rows + 2, 3, 3)
        From the body to the Earth.
    """

    position_m: Array
    turn: Array

    def rays(self, row: Array, direction: Array) -> tuple[Array, Array]:
        """Return origins and Earth-fixed directions (..., 3) of directions (..., 3) of the body, at rows (...)."""
        turn, origin = self.at(np.broadcast_to(row, direction.shape[:-1]))
        ray = np.einsum("...ij,...j->...i", turn, direction)
        return origin, ray / np.linalg.norm(ray, axis=-1, keepdims=True)

    def at(self, row: Array) -> tuple[Array, Array]:
        """Return turns (..., 3, 3) and positions (..., 3) at rows (...); those of the first or last line beyond it."""
        position = np.clip(np.nan_to_num(row) + 1.0, 0.0, len(self.turn) - 1.0)
        first = np.minimum(position.astype(np.int64), len(self.turn) - 2)
        share = (position - first)[..., None]
        turn = self.turn[first] + share[..., None] * (self.turn[first + 1] - self.turn[first])
        return turn, self.position_m[first] + share * (self.position_m[first + 1] - self.position_m[first])


@dataclass(frozen=True)
class Shutter:
    """When the pixels of a frame see the scene.

    Parameters
    ----------
    integration_s : float
        Around the time of the frame; 0: an instant.
    line_s : float
        Time from one line to the next, around the time of the frame in the middle line; negative: upward.
    instants : int
        Of the integration time.
    """

    integration_s: float = 0.0
    line_s: float = 0.0
    instants: int = 1

    def times_s(self, time_s: float) -> list[float]:
        """Return the instants of a frame."""
        return [time_s + later for later in _instants_s(self.integration_s, self.instants)]

    def lines(self, time_s: float, camera: Camera, pose_at: PoseAt) -> LinePoses | None:
        """Return the poses of the lines of an instant; None if all lines see the same instant."""
        if self.line_s == 0.0:
            return None
        rows = np.arange(-1.0, camera.rows + 1.0)
        poses = [pose_at(time_s + (row - 0.5 * (camera.rows - 1)) * self.line_s) for row in rows.tolist()]
        turns = Rotation.from_quat([pose.quaternion for pose in poses]).as_matrix()
        return LinePoses(np.array([pose.position_m for pose in poses]), turns)

    def which(self, points: int) -> NDArray[np.int64]:
        """Return the instant (points, points) of each point of a pixel; ``points`` is a multiple of their number."""
        number = np.arange(points)
        instant: NDArray[np.int64] = (number[:, None] + number[None, :]) % self.instants
        return instant


@dataclass(frozen=True, eq=False)
class Exposure:
    """One frame's instants.

    Attributes
    ----------
    pose : Pose
        At the time of the frame.
    instants : tuple of (Pose, LinePoses or None)
        Of each instant; without smear that of the frame.
    """

    shutter: Shutter
    pose: Pose
    instants: tuple[tuple[Pose, LinePoses | None], ...]


def exposure_of(shutter: Shutter, time_s: float, camera: Camera, pose_at: PoseAt) -> Exposure:
    """Return the instants of the frame of a time."""
    times = shutter.times_s(time_s) if shutter.instants > 1 else [time_s]
    exposed = tuple((pose_at(instant), shutter.lines(instant, camera, pose_at)) for instant in times)
    return Exposure(shutter, pose_at(time_s), exposed)


def smear_px(camera: Camera, before: Pose, after: Pose) -> float:
    """Return how far the ground moves through the image between two poses, pixels; 0 if it is not seen."""
    border = (np.linspace(-0.5, size - 0.5, 3) for size in (camera.rows, camera.columns))
    row, column = (numbers.ravel() for numbers in np.meshgrid(*border))
    ground = meet(before.position_m, before.to_earth(camera.directions(row, column)))
    at_row, at_column = camera.pixels(after.to_body(ground - after.position_m))
    moved = np.hypot(at_row - row, at_column - column)
    return float(np.nanmax(moved)) if np.any(np.isfinite(moved)) else 0.0


def largest_smear_px(
    camera: Camera,
    trajectory: Trajectory,
    attitude: Attitude,
    jitter: Jitter | None,
    times_s: Array,
    integration_s: float,
) -> float:
    """Return how far the ground moves through the image within an integration time at most, at times (N,) of a pass.

    With jitter the ends of single exposures say little: what it moves in that time is added.
    """
    if integration_s == 0.0:
        return 0.0
    half, middle = 0.5 * integration_s, 0.5 * float(times_s[0] + times_s[-1])
    # Tables of positions and attitudes may end with the pass.
    first, last = min(float(times_s[0]) + half, middle), max(float(times_s[-1]) - half, middle)
    moved = [
        smear_px(camera, *(pose_at(time + off, trajectory, attitude) for off in (-half, half)))
        for time in np.clip(times_s, first, last).tolist()
    ]
    return max(moved) + (0.0 if jitter is None else jitter.moved_rad(integration_s) / camera.pixel_rad)


def instants_for(smear: float, field: str = "camera.integration_time") -> int:
    """Return how many instants a smear (pixels) needs.

    Raises
    ------
    PayloadError
        If they are too many; names the field.
    """
    count = 1 if smear < LEAST_SMEAR_PX else max(2, math.ceil(_PER_PIXEL * smear))
    if count > MOST_INSTANTS:
        raise PayloadError(
            f"{field}: smears by {smear:.3g} pixels; allowed: up to {MOST_INSTANTS / _PER_PIXEL:g}, "
            "with a shorter time, an attitude that follows the ground, or without smear (smear = false of a sensor)"
        )
    return count


def _instants_s(integration_s: float, count: int) -> list[float]:
    """Return evenly spaced instants around 0 with the variance of an integration time T, T^2 / 12.

    In the middles of equal parts, N instants would have 1 - 1 / N^2 of it. Elements smear over the same instants.
    """
    if count == 1:
        return [0.0]
    step = integration_s / math.sqrt(count**2 - 1.0)
    return [(number - 0.5 * (count - 1)) * step for number in range(count)]
