"""Instants of a scene with computed tables, between which radiance is interpolated in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.plan.axis import Axis, place
from hcss_twin.providers import View

LONGEST_TIME_STEP_S = 3600.0
"""Maximum interval between time nodes if the motion of the sun matters: the noons of three days agree."""


def time_nodes(columns: BandColumns, views: Sequence[View], tolerance: float) -> tuple[tuple[float, ...], float]:
    """Choose the frames with computed tables; those between are linearly interpolated.

    Evaluated for the clear column and for the thinnest and thickest clouds of each layer and of both, which bound the
    weight of the solar terms, toward some views. Returns one frame if the sun does not matter. The columns may have few
    streams: how they change as the sun moves hardly depends on the numerical level.
    """
    plan, times = columns.plan, columns.plan.frame_times_s
    middle = (float(times[times.size // 2]),)
    if not plan.sun_matters or times.size == 1:
        return middle, 0.0

    def of_frames(time_s: Array) -> Array:
        """Return the columns of some frames (N, ..., 1, B), computed together."""
        suns = [plan.sun_at(time) for time in time_s.tolist()]
        found = columns.probe([plan.assembly.setting(sun, view) for sun in suns for view in views])
        return found.reshape(time_s.size, -1, 1, found.shape[-1])

    ends = _ends(times, plan.sun_zenith_deg < 90.0)
    if ends.size == 2:
        first, last = of_frames(times[[0, -1]])
        change = 0.6 * largest_error(last, first)
        if change <= tolerance:
            # Half the change on either side; over less than an hour the change is nearly linear.
            return middle, change
    axis = Axis(float(times[0]), float(times[-1]), ends[1:-1].tolist())
    placed = place(axis, of_frames, tolerance, orders=(1,), most=4 * times.size, fewest=True, nearest=times)
    return tuple(placed.nodes.tolist()), placed.error


def _ends(times: Array, up: NDArray[np.bool_]) -> Array:
    """Return the frames before and after each rise and set of the sun, and others at most an hour apart."""
    risen = np.flatnonzero(up[1:] != up[:-1])
    fixed = np.unique(np.concatenate((times[[0, -1]], times[risen], times[risen + 1])))
    hours = [
        np.linspace(low, high, math.ceil((high - low) / LONGEST_TIME_STEP_S) + 1)
        for low, high in pairwise(fixed.tolist())
    ]
    every = np.concatenate(hours)
    return np.unique(times[np.searchsorted(0.5 * (times[1:] + times[:-1]), every)])
