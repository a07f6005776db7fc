"""Squares in an image: the pieces that lie in single pixels, and what others leave of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

_NODE = 0.5 / math.sqrt(3.0)
"""Distance of two points from the middle of a segment of length 1 that have its mean and variance (Gauss)."""

Rectangle = tuple[float, float, float, float]
"""Lowest and highest row, lowest and highest column, in pixels."""


def segments(centre: float, side: float, within: slice, parts: int = 1) -> tuple[NDArray[np.intp], Array, Array, Array]:
    """Cut a segment along one axis at the borders of pixels, and within them.

    Parameters
    ----------
    centre, side : float
        Middle and length of the segment, in pixels; pixel n extends from n to n + 1. With length 0 it is one piece.
    within : slice
        Pixels whose pieces are returned; they do not depend on it.
    parts : int
        Half the number of pieces in each pixel.

    Returns
    -------
    pixel : ndarray of int (N,)
        The pixel of each piece.
    place : ndarray (N,)
        Where it stands as a point: the points of a pixel have mean and variance of the segment in it.
    first, last : ndarray (N,)
        Its ends.
    """
    low, high = centre - 0.5 * side, centre + 0.5 * side
    pixel = np.arange(max(math.floor(low), within.start), min(math.floor(high) + 1, within.stop))
    if side == 0.0:
        same = np.full(pixel.size, centre)
        return pixel, same, same, same
    first, last = np.maximum(low, pixel), np.minimum(high, pixel + 1.0)
    pixel, first, last = (values[last > first] for values in (pixel, first, last))
    half = (last - first)[:, None] / (2 * parts)
    number = np.arange(2 * parts)
    start = first[:, None] + number * half
    off = np.where(number % 2 == 0, 1.0 - 2.0 * _NODE, 2.0 * _NODE)
    return np.repeat(pixel, 2 * parts), (start + off * half).ravel(), start.ravel(), (start + half).ravel()


def share_left(of: Rectangle, others: Sequence[Rectangle]) -> float:
    """Return the share of a rectangle that no other one covers; a rectangle without area is covered or not."""
    low, high, left, right = of
    near = [
        other for other in others if other[0] <= high and other[1] >= low and other[2] <= right and other[3] >= left
    ]
    if not near:
        return 1.0
    rows, columns = (_edges(of[n : n + 2], [rectangle[n : n + 2] for rectangle in near]) for n in (0, 2))
    covered = np.zeros((len(rows) - 1, len(columns) - 1), dtype=bool)
    for rectangle in near:
        inside = [
            (edges[:-1] >= first) & (edges[1:] <= last)
            for edges, first, last in ((rows, rectangle[0], rectangle[1]), (columns, rectangle[2], rectangle[3]))
        ]
        covered |= np.outer(*inside)
    area = np.outer(np.diff(rows), np.diff(columns)) if high > low and right > left else np.ones(covered.shape)
    return float(np.sum(area[~covered]) / np.sum(area))


def _edges(segment: tuple[float, ...], others: Sequence[tuple[float, ...]]) -> Array:
    """Return the edges, within a segment, of all segments; of one without length twice the same."""
    if segment[0] == segment[1]:
        return np.array(segment)
    edges = np.array([*segment, *(edge for other in others for edge in other)])
    return np.unique(np.clip(edges, segment[0], segment[1]))
