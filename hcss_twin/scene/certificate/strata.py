"""Kinds of pixels, so that a sample of a frame has some of each: clear; thin, edge and thick of each choice of layers.

A pixel is at an edge where some layer's cloud ends in it or beside it (the next pixel up, down, left or right). Other
cloudy pixels are thick if some layer is there at least as thick as the geometric mean of its limits; otherwise thin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import CloudLayer
from hcss_twin.scene.footprint import pixel_sums

Thickness = NDArray[np.float32]

CLEAR = "clear"
PARTS = ("thin", "edge", "thick")
CHOICES = ("low only", "high only", "both")


def stratum_names(layers: int) -> tuple[str, ...]:
    """Return the names of the strata of a scene with so many layers, (S,), in the order of their numbers."""
    if layers == 0:
        return (CLEAR,)
    if layers == 1:
        return (CLEAR, *PARTS)
    return (CLEAR, *(f"{part} ({choice})" for choice in CHOICES for part in PARTS))


def strata(
    layers: Sequence[CloudLayer], thickness_m: Sequence[Thickness], shape: tuple[int, int], samples: int
) -> NDArray[np.int8]:
    """Return the stratum of each pixel of a window, (y, x), as a place in :func:`stratum_names`.

    Parameters
    ----------
    thickness_m : sequence of ndarray (y x samples, x x samples)
        Of each layer, at most two, at the points of the window. What lies outside the window is not seen: pixels on
        its rim are at an edge only as far as the window shows it.
    shape : (int, int)
        Rows and columns of the window, in pixels.
    samples : int
        Points along each side of a pixel.
    """
    layer_choice = np.zeros(shape, dtype=np.int8)
    edge, thick = np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.bool_)
    for number, (layer, thickness) in enumerate(zip(layers, thickness_m, strict=True)):
        points = _sums(thickness > 0, samples)
        cloudy, full = points > 0, points == samples**2
        layer_choice += np.int8(number + 1) * cloudy
        edge |= cloudy & _at_or_beside(~full)
        middle = math.sqrt(layer.thickness_min_m * layer.thickness_max_m)
        # Of a pixel with several points those with cloud count.
        least = middle if samples == 1 else middle * points
        thick |= cloudy & (_sums(thickness, samples) >= least)
    # In bytes throughout: a frame has as many as pixels, and numpy's own integers take eight times the room.
    part = np.where(edge, np.int8(1), np.int8(2) * thick.view(np.int8))
    found: NDArray[np.int8] = np.where(
        layer_choice > 0, np.int8(3) * layer_choice + (part - np.int8(2)), np.int8(0)
    )
    return found


def _sums(values: NDArray[Any], samples: int) -> NDArray[Any]:
    return values if samples == 1 else pixel_sums(values, samples)


def _at_or_beside(open_sky: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels that are in the mask or share a side with one that is."""
    found = open_sky.copy()
    found[1:] |= open_sky[:-1]
    found[:-1] |= open_sky[1:]
    found[:, 1:] |= open_sky[:, :-1]
    found[:, :-1] |= open_sky[:, 1:]
    return found
