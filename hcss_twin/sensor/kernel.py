"""A measured point-spread function: its file, and the convolution with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import oaconvolve

from hcss_twin.errors import CatalogError

Array = NDArray[np.float64]

LARGEST = 1025
"""Most rows or columns of a kernel."""


def read_kernel(path: Path) -> Array:
    """Read the image of a point on the image's own pixels, and scale it to the sum 1.

    Text: a row of numbers per line, separated by commas or blanks, with ``#`` comments. The first line is the
    southernmost row, as in the image; the point is in the middle.

    Returns
    -------
    ndarray (K, L)
        K and L odd.

    Raises
    ------
    CatalogError
        If the file is malformed, has an even number of rows or columns, or numbers that sum to nothing.
    """
    rows: list[list[float]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise CatalogError(f"{path}: cannot be read as text: {error}") from error
    for number, line in enumerate(lines, start=1):
        plain = line.partition("#")[0].replace(",", " ").split()
        try:
            values = [float(each) for each in plain]
        except ValueError as error:
            raise CatalogError(f"{path}, line {number}: {error}") from error
        if values and rows and len(values) != len(rows[0]):
            raise CatalogError(
                f"{path}, line {number}: {len(values)} numbers, the first row has {len(rows[0])}"
            )
        if values:
            rows.append(values)
    kernel = np.array(rows, dtype=np.float64)
    if kernel.ndim != 2 or any(size % 2 == 0 or size > LARGEST for size in kernel.shape):
        found = " x ".join(map(str, kernel.shape)) if kernel.ndim == 2 else "no rows"
        raise CatalogError(
            f"{path}: {found}; allowed: an odd number of rows and of columns, at most {LARGEST}"
        )
    total = float(kernel.sum())
    if not np.all(np.isfinite(kernel)) or not total > 1e-6 * float(np.abs(kernel).max()):
        raise CatalogError(
            f"{path}: the numbers sum to {total:g}; allowed: finite numbers with a sum above 0"
        )
    result: Array = kernel / total
    return result


def convolve(image: Array, kernel: Array) -> Array:
    """Return the convolution of an image (Y, X) with a kernel (K, L), its mirror image beyond its edges.

    By FFT. A point of the scene becomes the kernel, in the kernel's own orientation.
    """
    reach_y, reach_x = (size // 2 for size in kernel.shape)
    wide = np.pad(image, ((reach_y, reach_y), (reach_x, reach_x)), mode="symmetric")
    result: Array = oaconvolve(wide, kernel, mode="valid")
    return result
