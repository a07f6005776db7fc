"""Laws of surface providers: a point is the same in any window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.laws.law import Law, require
from hcss_twin.providers import SurfaceInputs, SurfaceMap, SurfaceProvider

Make = Callable[[SurfaceInputs], SurfaceProvider]

TIMES_S = (0.0, 2.0, 7.5)
"""Times of the calls."""

MARGIN = 5
"""Rows and columns beyond the image that are asked for, as a sensor's blur does."""


def a_window_has_the_points_of_the_image(
    provider: SurfaceProvider, inputs: SurfaceInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """Windows, and rows outside the image, change no bit of a point."""
    rows, columns = inputs.grid.rows, inputs.grid.columns
    inner = (rows // 7, rows // 7 + 1, rows // 2 + 3), (columns // 2, columns // 2 + 5)
    cuts = [
        [slice(*ends) for ends in pairwise((-MARGIN, *sorted({n for n in at if 0 < n < size}), size + MARGIN))]
        for at, size in zip(inner, (rows, columns), strict=True)
    ]
    for time_s in times_s:
        pieces = [[values_of(provider, provider.surface(time_s, y, x)) for x in cuts[1]] for y in cuts[0]]
        together = np.concatenate([np.concatenate(row, axis=-1) for row in pieces], axis=-2)
        inside = together[:, MARGIN:-MARGIN, MARGIN:-MARGIN]
        differ = np.any(inside != values_of(provider, whole(provider, inputs, time_s)), axis=0)
        require(~differ, f"{np.count_nonzero(differ)} of {differ.size} points differ with the window at {time_s:g} s")


def times_may_come_in_any_order(make: Make, inputs: SurfaceInputs, times_s: Sequence[float] = TIMES_S) -> None:
    """Results depend on time alone, not on earlier calls."""
    one, other = make(inputs), make(inputs)
    forward = [values_of(one, whole(one, inputs, time_s)) for time_s in times_s]
    backward = [values_of(other, whole(other, inputs, time_s)) for time_s in reversed(times_s)]
    for first, second in zip(forward, reversed(backward), strict=True):
        differ = np.any(first != second, axis=0)
        require(~differ, f"{np.count_nonzero(differ)} of {differ.size} points differ with the order of the times")


LAWS: tuple[Law, ...] = (a_window_has_the_points_of_the_image, times_may_come_in_any_order)


def whole(provider: SurfaceProvider, inputs: SurfaceInputs, time_s: float) -> SurfaceMap:
    """Return the map of the whole image."""
    return provider.surface(time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))


def values_of(provider: SurfaceProvider, ground: SurfaceMap) -> Array:
    """Return class and temperature (2, y, x), 0 where the class has no field of it."""
    number = ground.number.astype(np.float64)
    fields = [n for n, class_ in enumerate(provider.classes) if isinstance(class_.temperature_K, tuple)]
    kelvin = np.zeros(number.shape)
    if fields and ground.temperature_K is not None:
        kelvin = np.where(np.isin(ground.number, fields), ground.temperature_K, 0.0)
    return np.stack((number, kelvin))
