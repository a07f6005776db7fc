"""Footprints of a pixel along a pass: the octaves that they leave, and the time between keyframes of the sky."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_payload.live.octaves import SeenOctaves, blended, keyframe_interval_s, seen_octaves, shape_of
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array

_POINT_STEPS = 4
"""Steps of the distance of points for a factor of 2."""

_CHANGE = 0.1
"""Largest relative change of the width of a footprint between two keyframes of a long pass."""


class PassFootprints:
    """What pixels see of the sky along a pass.

    Parameters
    ----------
    times_s : ndarray (T,)
        Times at which footprints are known.
    footprints_m : ndarray (T, 2, 2)
        As in :func:`hcss_payload.live.octaves.separations`.
    fineness : float
        Points of the sky per width of a footprint.

    Attributes
    ----------
    interval_s : float
        Between keyframes.
    removed : (float, float)
        Smallest and largest share of the field's variance that is inside pixels.
    """

    def __init__(self, plan: Plan, times_s: Array, footprints_m: Array, fineness: float) -> None:
        self._plan, self._times, self._footprints, self._fineness = plan, times_s, footprints_m, fineness
        widths = np.hypot(footprints_m[:, 0], footprints_m[:, 1])
        every = [
            self._seen(float(time), float(width[0]) / fineness) for time, width in zip(times_s, widths, strict=True)
        ]
        self.removed = min(octaves.removed for octaves in every), max(octaves.removed for octaves in every)
        change = np.abs(np.diff(np.log(widths), axis=0)).max(initial=0.0)
        longest = _CHANGE * (times_s[-1] - times_s[0]) / max(change * (times_s.size - 1), 1e-9)
        self.interval_s = min(keyframe_interval_s(octaves.octaves, longest) for octaves in every)

    def point_m(self, keyframe: int) -> float:
        """Return the distance of the points of tiles: in steps of a factor, so that most keyframes share it."""
        x, y = np.hypot(*self._footprint_m(keyframe * self.interval_s))
        return float(2.0 ** (np.round(_POINT_STEPS * np.log2(np.sqrt(x * y) / self._fineness)) / _POINT_STEPS))

    def of_tiles(self, time_s: float, keyframe: int) -> SeenOctaves:
        """Return the octaves at a time, at the points of the tiles of a keyframe."""
        return self._seen(time_s, self.point_m(keyframe))

    def of_frame(self, time_s: float) -> SeenOctaves:
        """Return the octaves of a frame, which are those of the keyframes before and after it."""
        number = int(np.floor(time_s / self.interval_s))
        before, after = (self.of_tiles(keyframe * self.interval_s, number) for keyframe in (number, number + 1))
        between = blended(before, after, time_s / self.interval_s - number)
        return replace(between, footprint=self._footprint_m(time_s))

    def _seen(self, time_s: float, point_m: float) -> SeenOctaves:
        motion = self._plan.assembly.motion
        return seen_octaves(shape_of(self._plan), motion, point_m, self._footprint_m(time_s))

    def _footprint_m(self, time_s: float) -> Array:
        position = np.interp(time_s, self._times, np.arange(self._times.size))
        first = min(int(position), max(0, self._times.size - 2))
        after = min(first + 1, self._times.size - 1)
        change = self._footprints[after] - self._footprints[first]
        footprint: Array = self._footprints[first] + (position - first) * change
        return footprint
