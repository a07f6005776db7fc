"""Limits of the search, and lattice cells per frame instead of per 16 km."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.fractal.octaves import REFERENCE_LENGTH_M
from hcss_twin.matching.cloud_image import CloudImage

Array = NDArray[np.float64]

HURST = (0.02, 0.98)
BRIGHTNESS_EXPONENT = (0.1, 10.0)

# With fewer cells across the frame each frame has another mean and another range, and its histogram,
# which eq 5 takes to be that of the whole sky, is anything.
FEWEST_CELLS = 1.0

# Cells of less than two pixels are white noise at k = 0.
_CELLS_PER_PIXEL = 0.5


def cells_per_frame(image: CloudImage) -> tuple[Array, Array]:
    """Return the fewest and the most cells (2,) across the frame, along x and y."""
    rows, columns = image.level.shape
    return np.full(2, FEWEST_CELLS), _CELLS_PER_PIXEL * np.array([columns, rows], dtype=np.float64)


def reference_cells(cells: Array, image: CloudImage) -> tuple[float, float]:
    """Turn cells across the frame (2,) into L, cells per 16 km, along x and y."""
    x, y = np.asarray(cells) * REFERENCE_LENGTH_M / _sides_m(image)
    return float(x), float(y)


def frame_cells(reference: tuple[float, float], image: CloudImage) -> Array:
    """Turn L into cells across the frame (2,), along x and y."""
    cells: Array = np.array(reference) * _sides_m(image) / REFERENCE_LENGTH_M
    return cells


def _sides_m(image: CloudImage) -> Array:
    rows, columns = image.level.shape
    return np.array([columns, rows]) * image.pixel_size_m
