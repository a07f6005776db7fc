"""The sun at the frames of a scene, and a few of its positions that stand for all."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Sun, View
from hcss_twin.scene.sun_track import SunTrack

Array = NDArray[np.float64]

SAME_DEG = 0.25
"""Suns closer to each other than this count as one, the first asked for."""


@dataclass(frozen=True)
class SunFrames:
    """The sun at the frames of a scene.

    Attributes
    ----------
    track : SunTrack
    time_s, zenith_deg, azimuth_deg : ndarray (F,)
        Of each frame.
    """

    track: SunTrack
    time_s: Array
    zenith_deg: Array
    azimuth_deg: Array

    @property
    def up(self) -> NDArray[np.intp]:
        """Frames with the sun above the horizon."""
        return np.flatnonzero(self.zenith_deg < 90.0)

    def at(self, frames: Iterable[int]) -> list[tuple[float, Sun | None]]:
        """Return time and sun, None below the horizon, of some frames; of those with the sun at one place the first."""
        found: list[tuple[float, Sun | None]] = []
        for frame in frames:
            time_s = float(self.time_s[frame])
            position = self.track.at(time_s)
            sun = position if position.is_up else None
            if not any(_same(sun, other) for _, other in found):
                found.append((time_s, sun))
        return found

    def evenly(self, count: int) -> list[tuple[float, Sun | None]]:
        """Time and sun of at most so many frames from the first to the last."""
        frames = np.linspace(0, self.time_s.size - 1, count).round().astype(np.intp)
        return self.at(np.unique(frames).tolist())

    def telling(self, view: View) -> list[tuple[float, Sun | None]]:
        """Time and sun where it is nearest to the mirror direction, highest and lowest, and of a frame without it."""
        up = self.up
        frames = list(np.flatnonzero(self.zenith_deg >= 90.0)[:1])
        if up.size:
            highest, lowest = up[np.argmin(self.zenith_deg[up])], up[np.argmax(self.zenith_deg[up])]
            frames = [self.mirror(view), highest, lowest, *frames]
        return self.at(int(frame) for frame in frames)

    def mirror(self, view: View) -> int:
        """Frame whose sun, above the horizon, has its mirror image nearest to the view."""
        up = self.up
        sun, seen = np.radians(self.zenith_deg[up]), math.radians(view.zenith_deg)
        turn = np.radians(view.azimuth_deg - self.azimuth_deg[up])
        # Cosine between the view and the sun's mirror image, whose bearing is opposite to the sun's.
        nearness = math.cos(seen) * np.cos(sun) - math.sin(seen) * np.sin(sun) * np.cos(turn)
        return int(up[np.argmax(nearness)])


def _same(one: Sun | None, other: Sun | None) -> bool:
    """Whether two suns are at one place, or both below the horizon."""
    if one is None or other is None:
        return one is other
    turn = (one.azimuth_deg - other.azimuth_deg + 180.0) % 360.0 - 180.0
    across = abs(turn) * math.sin(math.radians(one.zenith_deg))
    return max(abs(one.zenith_deg - other.zenith_deg), across) <= SAME_DEG
