"""Even spacing of the pixels of a cube's frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError

_EVEN = 1e-6
"""Largest deviation of a coordinate from even spacing, in steps."""


@dataclass(frozen=True)
class PixelGrid:
    """Pixel centres of a frame in the local plane, even in both directions; rows grow north and columns east.

    Attributes
    ----------
    west_m, south_m : float
        Centre of the first pixel of the first row, relative to the centre of the frame.
    step_x_m, step_y_m : float
        Width and height of a pixel.
    """

    west_m: float
    south_m: float
    step_x_m: float
    step_y_m: float


def first_and_step(name: str, centres_m: NDArray[np.float64], fallback_m: float | None) -> tuple[float, float]:
    """Return first value and step of a coordinate, to place pixels by their numbers.

    Parameters
    ----------
    name : str
        For messages.
    centres_m : ndarray (N,)
    fallback_m : float or None
        Step for a single pixel.

    Raises
    ------
    CubeError
        If steps are uneven or not positive, or the step of a single pixel is unknown.
    """
    if centres_m.size == 1:
        if fallback_m is None:
            raise CubeError(f"{name} has one value, which does not determine the size of a pixel")
        return float(centres_m[0]), fallback_m
    step = float(centres_m[-1] - centres_m[0]) / (centres_m.size - 1)
    if not step > 0.0:
        raise CubeError(f"{name} does not increase with the pixel number; in a cube it does")
    even = centres_m[0] + step * np.arange(centres_m.size)
    if np.max(np.abs(centres_m - even)) > _EVEN * step:
        raise CubeError(f"{name} has uneven steps; those of a cube are even")
    return float(centres_m[0]), step
