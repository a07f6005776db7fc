"""Henyey-Greenstein phase function."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def henyey_greenstein(scattering_cosine: Array | float, asymmetry: Array | float) -> Array:
    """Phase function whose mean over the sphere is 1, eq 13 of the HCSS paper.

    Parameters
    ----------
    scattering_cosine : ndarray or float
        Cosine of the scattering angle, 1 is forward.
    asymmetry : ndarray or float
        Asymmetry parameter g in (-1, 1), broadcast against ``scattering_cosine``.

    Returns
    -------
    ndarray
        Dimensionless; divide by 4 pi for the density per steradian. Its Legendre moments are g^n.

    Raises
    ------
    ValueError
        If |g| is not below 1 or a cosine lies outside [-1, 1].

    References
    ----------
    L. G. Henyey and J. L. Greenstein, Astrophys. J. 93, 70 (1941).
    """
    mu = np.asarray(scattering_cosine, dtype=np.float64)
    g = np.asarray(asymmetry, dtype=np.float64)
    if not np.all(np.abs(g) < 1.0):
        raise ValueError(f"asymmetry {np.max(np.abs(g)):g}: allowed above -1 and below 1")
    if not np.all(np.abs(mu) <= 1.0):
        raise ValueError(f"scattering_cosine {mu[np.abs(mu) > 1.0][0] if mu.ndim else mu}: allowed -1 to 1")
    # (1 - g)^2 + 2 g (1 - mu) is 1 + g^2 - 2 g mu without its cancellation near the forward peak.
    result: Array = (1.0 - g * g) / ((1.0 - g) ** 2 + 2.0 * g * (1.0 - mu)) ** 1.5
    return result
