"""Windows of the image that fit into memory, and averages over the points of a pixel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Grid

POINTS_AT_ONCE = 2**20
"""Points per window of thickness and look-up; 4 MB for each layer, which are reused: new memory takes longer to get."""


Window = tuple[slice, slice]
"""Row and column ranges, in pixels of the image."""


def windows(
    grid: Grid, samples: int, most_points: int = POINTS_AT_ONCE, inside: Window | None = None
) -> Iterator[Window]:
    """Divide an image into windows (rows, columns), in pixels, of limited size: strips if a row fits.

    Parameters
    ----------
    grid : Grid
        The image, in pixels.
    samples : int
        Points along each side of a pixel.
    inside : (slice, slice), optional
        Part of the image to divide, by default all of it.
    """
    whole = (slice(0, grid.rows), slice(0, grid.columns)) if inside is None else inside
    pixels = max(1, most_points // samples**2)
    columns = min(length(whole[1]), pixels)
    rows = min(length(whole[0]), max(1, pixels // columns))
    yield from cut(whole, rows, columns)


def cut(window: Window, rows: int, columns: int) -> Iterator[Window]:
    """Divide a window into windows of at most so many rows and columns, row by row."""
    for row in range(window[0].start, window[0].stop, rows):
        for column in range(window[1].start, window[1].stop, columns):
            yield (slice(row, min(row + rows, window[0].stop)), slice(column, min(column + columns, window[1].stop)))


def strips_around(inner: Window, outer: Window) -> Iterator[Window]:
    """Yield what a window has around another one inside it: below, above, left and right."""
    (rows, columns), (inner_rows, inner_columns) = outer, inner
    candidates = (
        (slice(rows.start, inner_rows.start), columns),
        (slice(inner_rows.stop, rows.stop), columns),
        (inner_rows, slice(columns.start, inner_columns.start)),
        (inner_rows, slice(inner_columns.stop, columns.stop)),
    )
    yield from (window for window in candidates if length(window[0]) and length(window[1]))


def length(pixels: slice) -> int:
    """Number of pixels of a range."""
    return int(pixels.stop - pixels.start)


def relative(window: Window, outer: Window) -> Window:
    """Position of a window within another, counted from the first row and column of the latter."""
    rows, columns = (
        slice(inner.start - around.start, inner.stop - around.start)
        for inner, around in zip(window, outer, strict=True)
    )
    return rows, columns


def points_of(pixels: slice, samples: int) -> slice:
    """Points, along one axis, of a range of pixels."""
    return slice(pixels.start * samples, pixels.stop * samples)


def pixel_sums(values: NDArray[Any], samples: int) -> NDArray[np.float64]:
    """Sum over the points of each pixel.

    Parameters
    ----------
    values : ndarray (y x samples, x x samples)
        Numbers or booleans.

    Returns
    -------
    ndarray (y, x)
    """
    sums: NDArray[np.float64] = _sums(np.ascontiguousarray(values), samples)
    return sums


@kernel()
def _sums(values, samples):  # type: ignore[no-untyped-def]
    rows, columns = values.shape[0] // samples, values.shape[1] // samples
    sums = np.zeros((rows, columns))
    for y in range(rows):
        for i in range(y * samples, (y + 1) * samples):
            for x in range(columns):
                for j in range(x * samples, (x + 1) * samples):
                    sums[y, x] += values[i, j]
    return sums


def whole_image(scenario: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of ``[image]`` of a scenario that a window shares with the whole image."""
    return {name: value for name, value in scenario["image"].items() if name != "window"}
