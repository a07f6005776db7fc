"""Motion of what is seen between two images, and images moved along it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_follow.bands import smooth
from hcss_follow.state import Field
from hcss_twin.core.kernels import kernel

_PATCH, _SMOOTH = 16, 3.0
"""Side of the patches that are compared, and smoothing of the flow, pixels."""

STEP_S = 900.0
"""Longest step of a trajectory."""


def flow_between(before: Field, after: Field) -> Field:
    """Return the displacement (2, rows, columns), pixels along rows and columns, from one image to the next.

    Dense inverse search of OpenCV (T. Kroeger et al., "Fast optical flow using dense inverse search", ECCV 2016) down
    to single pixels.
    """
    import cv2

    cv2.setNumThreads(1)  # the same bits on all machines with this library
    low, high = np.percentile(np.stack([before, after]), [0.1, 99.9])
    scale = 255.0 / max(float(high - low), 1e-3)
    grey = [np.clip(np.rint((image - low) * scale), 0, 255).astype(np.uint8) for image in (before, after)]
    search = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    search.setFinestScale(0)
    search.setPatchSize(_PATCH)
    x, y = np.moveaxis(search.calc(grey[0], grey[1], None), -1, 0)
    return np.stack([smooth(np.ascontiguousarray(part), _SMOOTH) for part in (y, x)])


def departures(velocity: Field, time_s: float, y: Any, x: Any) -> tuple[Any, Any]:
    """Return where what is at positions (N,), (M,) at a time was at time 0, two arrays (N, M).

    Midpoint rule in steps of 15 min, the shortest one first, so that time changes the result continuously. Beyond the
    edge the velocity is that at the edge.

    Parameters
    ----------
    velocity : ndarray of float32 (2, rows, columns)
        Pixels per second along rows and columns.
    time_s : float
        Of any sign.
    y, x : ndarray of float64
        Positions in pixels, 0 at the middle of the first one.
    """
    whole = math.floor(abs(time_s) / STEP_S)
    first = math.copysign(abs(time_s) - whole * STEP_S, time_s)
    steps = np.array([first, *[math.copysign(STEP_S, time_s)] * whole])
    out = np.empty((2, y.size, x.size))
    _depart(out, velocity, steps, y, x)
    return out[0], out[1]


def moved(image: Field, velocity: Field, time_s: float) -> Field:
    """Return an image of time 0 as it is at another time, moved along the velocity."""
    rows, columns = (np.arange(side, dtype=np.float64) for side in image.shape)
    out = np.empty(image.shape, np.float32)
    y, x = departures(velocity, time_s, rows, columns)
    interpolate(out, image, y, x, 0, 0)
    return out


@kernel(inner=True, fastmath={"contract"})
def _velocity(velocity: Any, y: float, x: float) -> Any:
    rows, columns = velocity.shape[1], velocity.shape[2]
    y, x = min(max(y, 0.0), rows - 1.000001), min(max(x, 0.0), columns - 1.000001)
    i, j = int(y), int(x)
    fy, fx = y - i, x - j
    a, b, c, d = (1.0 - fy) * (1.0 - fx), (1.0 - fy) * fx, fy * (1.0 - fx), fy * fx
    v = a * velocity[0, i, j] + b * velocity[0, i, j + 1] + c * velocity[0, i + 1, j] + d * velocity[0, i + 1, j + 1]
    u = a * velocity[1, i, j] + b * velocity[1, i, j + 1] + c * velocity[1, i + 1, j] + d * velocity[1, i + 1, j + 1]
    return v, u


@kernel(fastmath={"contract"})
def _depart(out: Any, velocity: Any, steps: Any, y: Any, x: Any) -> None:
    for i in range(y.size):
        for j in range(x.size):
            at_y, at_x = y[i], x[j]
            for step in steps:
                v, u = _velocity(velocity, at_y, at_x)
                v, u = _velocity(velocity, at_y - 0.5 * step * v, at_x - 0.5 * step * u)
                at_y, at_x = at_y - step * v, at_x - step * u
            out[0, i, j], out[1, i, j] = at_y, at_x


@kernel(inner=True, fastmath={"contract"})
def _weights(f: float, w: Any) -> None:
    """Write the four weights of a cubic through the middle two points with the slopes of central differences."""
    w[0] = f * (-0.5 + f * (1.0 - 0.5 * f))
    w[1] = 1.0 + f * f * (1.5 * f - 2.5)
    w[2] = f * (0.5 + f * (2.0 - 1.5 * f))
    w[3] = f * f * (0.5 * f - 0.5)


@kernel(fastmath={"contract"})
def interpolate(out: Any, image: Any, y: Any, x: Any, first_row: int, first_column: int) -> None:
    """Write values (N, M) between the pixels of an image that begins at a row and column: R. Keys, 1981, cubic.

    Beyond the edge they are those at the edge.
    """
    rows, columns = image.shape
    along_y, along_x = np.empty(4), np.empty(4)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            floor_y, floor_x = np.floor(y[i, j]), np.floor(x[i, j])
            _weights(y[i, j] - floor_y, along_y)
            _weights(x[i, j] - floor_x, along_x)
            row, column = int(floor_y) - first_row, int(floor_x) - first_column
            total = 0.0
            for n in range(4):
                k = min(max(row + n - 1, 0), rows - 1)
                line = 0.0
                for m in range(4):
                    line += along_x[m] * image[k, min(max(column + m - 1, 0), columns - 1)]
                total += along_y[n] * line
            out[i, j] = total
