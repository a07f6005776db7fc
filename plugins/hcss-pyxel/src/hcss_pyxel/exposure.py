"""Frames of a cube that contribute to an exposure, and their durations."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Between = Literal["hold", "interpolate"]

BETWEEN: tuple[Between, ...] = ("hold", "interpolate")

_NANOSECONDS = 2e-9
"""Times of a cube are kept to the nanosecond; so much may an exposure reach beyond them."""


def frame_weights(times_s: Array, start_s: float, end_s: float, between: Between) -> Array:
    """Return the weight of each frame in the mean radiance of an exposure; they sum to 1.

    Parameters
    ----------
    times_s : ndarray (F,)
        Time of each frame, increasing.
    start_s, end_s : float
        Begin and end of the exposure on the same clock.
    between : {"hold", "interpolate"}
        ``hold``: a frame is there from its time to that of the next; the last as long as the one before it.
        ``interpolate``: radiance goes in straight lines from frame to frame, and the last ends the cube. The only
        frame of a cube is a still scene, there at all times.

    Returns
    -------
    ndarray (F,)

    Raises
    ------
    ValueError
        If part of the exposure lies outside the cube, with what the cube covers.
    """
    if not end_s > start_s:
        raise ValueError(f"exposure from {start_s:g} to {end_s:g} s: it has to end after it begins")
    if times_s.size == 1:
        return np.ones(1)
    last = times_s[-1] + (times_s[-1] - times_s[-2] if between == "hold" else 0.0)
    if start_s < times_s[0] - _NANOSECONDS or end_s > last + _NANOSECONDS:
        raise ValueError(
            f"exposure from {start_s:.9g} to {end_s:.9g} s after the scenario's start: the cube covers "
            f"{times_s[0]:.9g} to {last:.9g} s (frames: {between}); change the readout times or time_offset, or "
            "simulate more frames"
        )
    edges = np.append(times_s, last) if between == "hold" else times_s
    # the part of the exposure in each interval between edges
    low = np.clip(start_s, edges[:-1], edges[1:])
    high = np.clip(end_s, edges[:-1], edges[1:])
    length = high - low
    weights = np.zeros(times_s.size)
    if between == "hold":
        weights += length
    else:
        # mean place of that part in its interval: 0 at the earlier frame, 1 at the later
        share = (0.5 * (low + high) - edges[:-1]) / np.diff(edges)
        weights[:-1] += length * (1.0 - share)
        weights[1:] += length * share
    normalised: Array = weights / weights.sum()
    return normalised
