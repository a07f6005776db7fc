"""Laws of element providers: a pixel is the same in any window."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.laws.law import Inapplicable, Law, require
from hcss_twin.laws.samples import PlainScene, frozen
from hcss_twin.physics.squares import segments
from hcss_twin.providers import ElementInputs, ElementPixels, ElementPoint, ElementProvider

Pixel = dict[tuple[int, int], list[tuple[float, ...]]]
"""Values of each pixel, by row and column, part by part."""

TIMES_S = (0.0, 2.0, 7.5)
"""Times of the calls."""


def a_window_has_the_pixels_of_the_image(
    provider: ElementProvider, inputs: ElementInputs, times_s: Sequence[float] = TIMES_S
) -> None:
    """Windows that cut through elements, and rows outside the image, change no bit of a pixel."""
    rows, columns, appears = inputs.grid.rows, inputs.grid.columns, False
    for time_s in times_s:
        whole, pieces = pixels_of(given(provider, inputs, time_s, (slice(0, rows), slice(0, columns)))), Pixel()
        appears = appears or bool(whole)
        row, column = next(iter(whole), (rows // 7, columns // 2))
        cuts = (
            (slice(-3, row), slice(row, row + 1), slice(row + 1, rows)),
            (slice(0, column + 1), slice(column + 1, columns + 2)),
        )
        for window in ((row_cut, column_cut) for row_cut in cuts[0] for column_cut in cuts[1]):
            found = pixels_of(given(provider, inputs, time_s, window))
            inside = all(one.start <= n < one.stop for at in found for n, one in zip(at, window, strict=True))
            require(inside, f"pixels outside the window {window} at {time_s:g} s")
            pieces |= found
        pieces = {at: piece for at, piece in pieces.items() if 0 <= at[0] < rows and 0 <= at[1] < columns}
        differ = sorted(at for at in pieces.keys() | whole.keys() if pieces.get(at) != whole.get(at))
        require(not differ, f"{len(differ)} pixels differ with the window at {time_s:g} s, first {differ[:1]}")
    if not appears:
        raise Inapplicable("nothing appears in the image at the times of the law")


LAWS: tuple[Law, ...] = (a_window_has_the_pixels_of_the_image,)


def given(
    provider: ElementProvider, inputs: ElementInputs, time_s: float, window: tuple[slice, slice]
) -> list[ElementPixels]:
    """Return the pixels of a window in a plain scene."""
    scene = PlainScene(inputs)
    return in_pixels(provider.pixels(time_s, *window, scene), inputs, *window, scene)


def in_pixels(
    given: Sequence[ElementPixels | ElementPoint], inputs: ElementInputs, rows: slice, columns: slice, scene: PlainScene
) -> list[ElementPixels]:
    """Return what a provider gives, with small elements in the pixels of a window that hold them, as in cubes."""
    area_m2 = inputs.grid.pixel_size_m**2 * math.cos(math.radians(inputs.view.zenith_deg))
    found = []
    for part in given:
        if isinstance(part, ElementPixels):
            found.append(part)
            continue
        covers = 1.0 if part.area_m2 is None else part.area_m2 / area_m2
        side = part.side_m / inputs.grid.pixel_size_m
        if part.area_m2 is not None and covers > 1.0:
            side = max(side, math.sqrt(covers))
        position = scene.project(*(np.array([value]) for value in (part.x_m, part.y_m, part.altitude_m)))
        pieces = [segments(float(at[0]), side, pixels) for at, pixels in zip(position, (rows, columns), strict=True)]
        (y, up), (x, along) = (
            _by_pixel(piece[0], (piece[3] - piece[2]) / side if side else np.ones(piece[0].size)) for piece in pieces
        )
        if not y.size or not x.size:
            continue
        at_y, at_x = (every.ravel() for every in np.meshgrid(y, x, indexing="ij"))
        truth = {name: np.full(at_y.size, value) for name, value in part.truth.items()}
        share = covers * np.outer(up, along).ravel()
        found.append(
            ElementPixels(at_y, at_x, share, part.altitude_m, part.radiance, part.intensity, part.temperature_K, truth)
        )
    return found


def _by_pixel(pixel: NDArray[np.intp], share: Array) -> tuple[NDArray[np.intp], Array]:
    """Return distinct pixels along one axis, and the sum of the shares in each."""
    distinct, which = np.unique(pixel, return_inverse=True)
    total: Array = np.bincount(which, share, distinct.size).astype(np.float64)
    return distinct, total


def pixels_of(parts: list[ElementPixels]) -> Pixel:
    """Return the values of each pixel, part by part."""
    found: Pixel = {}
    for part in parts:
        given = frozen(part.intensity if part.radiance is None else part.radiance)
        values = np.broadcast_to(given, (part.rows.size, given.shape[-1]))
        for n, at in enumerate(zip(part.rows.tolist(), part.columns.tolist(), strict=True)):
            facts = (part.altitude_m, float(part.share[n]), *values[n].tolist())
            found.setdefault(at, []).append((*facts, *(float(truth[n]) for truth in part.truth.values())))
    return found
