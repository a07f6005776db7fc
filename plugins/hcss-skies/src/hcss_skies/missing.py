"""Missing pixels of images: filled by interpolation if they are few, avoided by a crop otherwise."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Array, CatalogError

Missing = Literal["auto", "fill", "crop"]

MAX_FILLED = 0.05
"""Largest share of pixels that may be filled: smooth filling lacks texture."""

MIN_KEPT, MIN_CROP_SIDE = 0.25, 64
"""Smallest share of the pixels that a crop may keep, and smallest side, half of that of images below 128 pixels."""

# A crop that costs fewer pixels than this is better than filling.
_SMALL_LOSS = 0.1


def without_missing(image: Array, how: Missing) -> tuple[tuple[slice, slice], Array, str]:
    """Return a part of an image without missing pixels: its rows and columns, its values, and what was done.

    Filled pixels solve Laplace's equation with the values around them.

    Parameters
    ----------
    image : ndarray (rows, columns)
        NaN where missing.
    how : {"auto", "fill", "crop"}
        "crop" keeps the largest rectangle without missing pixels; "auto" crops if that costs at most a tenth of the
        pixels, fills if at most 5 % are missing, and else crops.

    Raises
    ------
    CatalogError
        If too many pixels are missing; without the name of the file.
    """
    known = np.isfinite(image)
    share = 1.0 - float(known.mean())
    whole = slice(0, image.shape[0]), slice(0, image.shape[1])
    if share == 0.0:
        return whole, image, ""
    crop = largest_rectangle(known)
    rows, columns = (span.stop - span.start for span in crop)
    kept = rows * columns / known.size
    if how == "fill" or (how == "auto" and kept < 1.0 - _SMALL_LOSS and share <= MAX_FILLED):
        if share > MAX_FILLED:
            raise CatalogError(
                f"{share:.1%} of the pixels are missing; allowed: {MAX_FILLED:.0%} to be filled; a crop without them "
                f"would have {rows} x {columns} pixels"
            )
        return whole, filled(image), f"{share:.2%} of the pixels are filled by interpolation"
    if kept < MIN_KEPT or min(rows, columns) < min(MIN_CROP_SIDE, 0.5 * min(image.shape)):
        raise CatalogError(
            f"{share:.1%} of the pixels are missing; allowed: {MAX_FILLED:.0%} to be filled, or a crop without them of "
            f"{MIN_KEPT:.0%} of the pixels and sides of {MIN_CROP_SIDE}; the largest has {rows} x {columns} pixels "
            f"({kept:.1%})"
        )
    text = f"cropped to {rows} x {columns} pixels ({kept:.1%}), because {share:.2%} of all pixels are missing"
    return crop, image[crop], text


def filled(image: Array) -> Array:
    """Return an image whose missing pixels are the means of their neighbours: the solution of Laplace's equation."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import spsolve

    missing = ~np.isfinite(image)
    number = np.full(image.shape, -1, dtype=np.int64)
    number[missing] = np.arange(missing.sum())
    row, column = np.nonzero(missing)
    count, known_sum = np.zeros(row.size), np.zeros(row.size)
    entries: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        i, j = row + down, column + right
        inside = (i >= 0) & (i < image.shape[0]) & (j >= 0) & (j < image.shape[1])
        unknown_index = np.flatnonzero(inside)
        i, j = i[inside], j[inside]
        count[unknown_index] += 1.0
        unknown = missing[i, j]
        known_sum[unknown_index[~unknown]] += image[i[~unknown], j[~unknown]]
        entries.append((unknown_index[unknown], number[i[unknown], j[unknown]]))
    unknown_index, other = (np.concatenate(indices) for indices in zip(*entries, strict=True))
    diagonal = np.arange(row.size)
    matrix = coo_matrix(
        (
            np.concatenate((count, np.full(unknown_index.size, -1.0))),
            (np.concatenate((diagonal, unknown_index)), np.concatenate((diagonal, other))),
        )
    )
    result: Array = image.copy()
    result[missing] = spsolve(matrix.tocsc(), known_sum)
    return result


def largest_rectangle(known: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the largest rectangle of true pixels: rows and columns.

    For each row, the heights of columns of true pixels above it form a histogram, whose largest rectangle is that
    between each bar and the next lower ones.
    """
    best, found = 0, (slice(0, 0), slice(0, 0))
    height = np.zeros(known.shape[1] + 1, dtype=np.int64)
    for row, line in enumerate(known):
        height[:-1] = np.where(line, height[:-1] + 1, 0)
        starts: list[tuple[int, int]] = []  # first column and height of the open rectangles, ascending
        for column, tall in enumerate(height.tolist()):
            first = column
            while starts and starts[-1][1] > tall:
                first, tallest = starts.pop()
                if tallest * (column - first) > best:
                    best = tallest * (column - first)
                    found = slice(row + 1 - tallest, row + 1), slice(first, column)
            if not starts or starts[-1][1] < tall:
                starts.append((first, tall))
    return found
