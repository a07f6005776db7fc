"""Instants of a scene with computed tables, between which radiance is interpolated in time."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.columns import BandColumns
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import View

LONGEST_TIME_STEP_S = 3600.0
"""Maximum interval between time nodes if the motion of the sun matters."""


def time_nodes(columns: BandColumns, views: Sequence[View], tolerance: float) -> tuple[tuple[float, ...], float]:
    """Choose the frames with computed tables; those between are linearly interpolated.

    Evaluated for the clear column and for the thinnest and thickest clouds of each layer and of both, which bound the
    weight of the solar terms, toward some views. Returns one frame if the sun does not matter. The columns may have few
    streams: how they change as the sun moves hardly depends on the numerical level.
    """
    plan, times = columns.plan, columns.plan.frame_times_s
    middle, last = times.size // 2, times.size - 1
    if not plan.sun_matters or times.size == 1:
        return (float(times[middle]),), 0.0

    def of_frames(frames: Sequence[int]) -> dict[int, Array]:
        """Return the columns of some frames, computed together."""
        suns = [plan.sun_at(float(times[frame])) for frame in frames]
        found = columns.probe([plan.assembly.setting(sun, view) for sun in suns for view in views])
        return dict(zip(frames, found.reshape(len(frames), -1, found.shape[-1]), strict=True))

    known = of_frames([0, last])
    change = largest_error(known[last], known[0])
    near = times[-1] - times[0] <= LONGEST_TIME_STEP_S
    if 0.6 * change <= tolerance and near and _is_up(plan, 0) == _is_up(plan, last):
        # Half the change on either side; over less than an hour the change is nearly linear.
        return (float(times[middle]),), 0.6 * change
    pending, worst = [(0, last)], 0.0
    while intervals := [(low, high) for low, high in pending if high - low > 1]:
        pending, between = [], of_frames([(low + high) // 2 for low, high in intervals])
        for (low, high), (middle, exact) in zip(intervals, between.items(), strict=True):
            weight = (times[middle] - times[low]) / (times[high] - times[low])
            error = largest_error((1 - weight) * known[low] + weight * known[high], exact)
            # Over days, agreement at the middle alone proves nothing: the noons of three days agree.
            near = times[high] - times[low] <= LONGEST_TIME_STEP_S
            if error <= tolerance and near and _is_up(plan, low) == _is_up(plan, high):
                worst = max(worst, error)
                continue
            known[middle] = exact
            pending += [(low, middle), (middle, high)]
    return tuple(float(times[frame]) for frame in sorted(known)), worst


def _is_up(plan: Plan, frame: int) -> bool:
    return bool(plan.sun_zenith_deg[frame] < 90.0)
