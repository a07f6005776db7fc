"""What an image goes through before its spectrum is taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def hann(size: int) -> NDArray[np.float64]:
    """Return a Hann window (size,) without its zeros, which would waste the outer pixels."""
    window: NDArray[np.float64] = np.sin(np.pi * np.arange(1, size + 1) / (size + 1)) ** 2
    return window


def without_plane(surface: NDArray[np.float64]) -> NDArray[np.float64]:
    """Subtract the plane of least squares (rows, columns); on a full grid its terms are orthogonal."""
    rows, columns = surface.shape
    y = np.arange(rows) - (rows - 1) / 2.0
    x = np.arange(columns) - (columns - 1) / 2.0
    slope_y = float(surface.sum(axis=1) @ y) / (columns * float(y @ y))
    slope_x = float(surface.sum(axis=0) @ x) / (rows * float(x @ x))
    result: NDArray[np.float64] = surface - surface.mean() - slope_y * y[:, None] - slope_x * x
    return result
