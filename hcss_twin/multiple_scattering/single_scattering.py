"""Paths of sunlight scattered once by a homogeneous layer, in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def path_back(thickness: Array, mu: Array, mu_sun: Array | float) -> Array:
    """Integral of exp(-t (1/mu + 1/mu_sun)) over the layer: times the kernel of scattering, reflection.

    S. Chandrasekhar, "Radiative Transfer", Dover 1960, section 9, integrated.
    """
    rate = 1.0 / mu + 1.0 / mu_sun
    result: Array = -np.expm1(-thickness * rate) / rate
    return result


def path_through(thickness: Array, mu: Array | float, mu_sun: Array | float) -> Array:
    """Integral of exp(-t / mu_sun - (tau - t) / mu): as :func:`path_back`, transmission.

    (exp(-tau / mu) - exp(-tau / mu_sun)) / (1 / mu_sun - 1 / mu), without 0 / 0 where both are alike.
    """
    view, sun = 1.0 / mu, 1.0 / mu_sun
    x = thickness * np.abs(view - sun)
    # (1 - exp(-x)) / x
    safe = np.where(x > 0.0, x, 1.0)
    mean = np.where(x > 0.0, -np.expm1(-safe) / safe, 1.0)
    result: Array = thickness * np.exp(-thickness * np.minimum(view, sun)) * mean
    return result
