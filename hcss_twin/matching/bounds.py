"""Limits of the search, and lattice cells per frame instead of per 16 km."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.fractal.octaves import REFERENCE_LENGTH_M
from hcss_twin.matching.cloud_image import CloudImage

Array = NDArray[np.float64]

HURST = (0.02, 0.98)
BRIGHTNESS_EXPONENT = (0.1, 10.0)

# With fewer cells across a frame, the frame is a slope; with smaller cells, white noise.
import os
_FEWEST_CELLS = float(os.environ.get('FC','1'))
_CELLS_PER_PIXEL = 0.5


def cells_per_frame(image: CloudImage) -> tuple[Array, Array]:
    """Return the fewest and the most cells (2,) across the frame, along x and y."""
    rows, columns = image.level.shape
    return np.full(2, _FEWEST_CELLS), _CELLS_PER_PIXEL * np.array([columns, rows], dtype=np.float64)


def reference_cells(cells: Array, image: CloudImage) -> tuple[float, float]:
    """Turn cells across the frame (2,) into L, cells per 16 km, along x and y."""
    rows, columns = image.level.shape
    x, y = np.asarray(cells) * REFERENCE_LENGTH_M / (np.array([columns, rows]) * image.pixel_size_m)
    return float(x), float(y)


def frame_cells(reference: tuple[float, float], image: CloudImage) -> Array:
    """Turn L into cells across the frame (2,), along x and y."""
    rows, columns = image.level.shape
    return np.array(reference) * np.array([columns, rows]) * image.pixel_size_m / REFERENCE_LENGTH_M
