"""Fresnel reflection at the smooth boundary from vacuum into an absorbing medium."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array


def unpolarised_reflectance(index: NDArray[np.complex128] | complex, cos_incidence: Array | float) -> Array:
    """Return the power reflectance, 0 to 1, for unpolarised light that arrives from the vacuum side.

    M. Born and E. Wolf, Principles of Optics, 7th ed., section 1.5.2, eqs (20) and (21), with the refracted cosine
    eliminated by Snell's law: u = sqrt(m^2 - sin^2) is m times that cosine.

    Parameters
    ----------
    index : complex or ndarray
        Refractive index n + i k of the medium, k >= 0; broadcasts with ``cos_incidence``: (V,) and (M, 1) give (M, V).
    cos_incidence : float or ndarray
        Cosine of the angle of incidence, 0 < cos_incidence <= 1; ValueError outside.
    """
    m2 = np.square(np.asarray(index, dtype=np.complex128))
    mu = np.asarray(cos_incidence, dtype=np.float64)
    if not np.all((mu > 0.0) & (mu <= 1.0)):
        raise ValueError(f"cos_incidence between {np.min(mu)} and {np.max(mu)}: allowed above 0, at most 1")
    u = np.sqrt(m2 - (1.0 - mu) * (1.0 + mu))
    perpendicular = _power_ratio(mu, 0.0, u)
    parallel = _power_ratio(m2.real * mu, m2.imag * mu, u)
    return np.asarray(0.5 * (perpendicular + parallel), dtype=np.float64)


def _power_ratio(real: Array, imaginary: Array | float, u: NDArray[np.complex128]) -> Array:
    """Return |z - u|^2 / |z + u|^2 from real parts: complex quotients and moduli take several times as long."""
    minus = (real - u.real) ** 2 + (imaginary - u.imag) ** 2
    plus = (real + u.real) ** 2 + (imaginary + u.imag) ** 2
    return np.asarray(minus / plus)
