"""Eq 5 as printed: the cloud fraction value of the fractal field, and the pixels that are cloudy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from hcss_twin.providers import Array


def fraction_value(field: Array) -> Array:
    """Return p = (1 + erf(V / sqrt 2)) / 2 of a standard normal field V; any shape."""
    return np.asarray(0.5 * (1.0 + erf(field * np.sqrt(0.5))), dtype=np.float64)


def cloudy_pixels(field: Array, coverage: float) -> NDArray[np.bool_]:
    """Return the pixels with the highest values, as many as the coverage requires; equal ones in their order."""
    mask = np.zeros(field.size, dtype=np.bool_)
    mask[np.argsort(-field.ravel(), kind="stable")[: round(coverage * field.size)]] = True
    return mask.reshape(field.shape)
