"""How far waves hide one another (Smith 1967).

B. G. Smith, Geometrical shadowing of a random rough surface, IEEE Trans. Antennas Propag. 15, 668-671
(1967): of the facets turned toward a direction, 1 / (1 + Lambda) are seen from it, whatever their slope. The
factor normalises: the projected areas of the facets turned toward the direction sum to 1 + Lambda times the
area of the sea. With two directions, heights being common to both, 1 / (1 + Lambda_out + Lambda_in) are
seen from both (V. Ross and D. Dion, Sea surface slope statistics derived from Sun glint radiance
measurements and their apparent dependence on sensor elevation, J. Geophys. Res. 112, C09015 (2007), use this
form for the sea).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfcx

Shadowing = Literal["none", "separable", "height-correlated"]


def smith_lambda(mu: NDArray[np.float64], variance_along: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return Smith's Lambda for Gaussian slopes.

    Parameters
    ----------
    mu : ndarray
        Cosines of the zenith angle, in (0, 1]; grows like 1 / mu toward the horizon.
    variance_along : float or ndarray
        Variance of the slope in the vertical plane of the direction; broadcasts.

    Returns
    -------
    ndarray
        exp(-v^2) / (2 v sqrt(pi)) - erfc(v) / 2 with v = cot(zenith) / sqrt(2 variance), not negative.
    """
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    with np.errstate(divide="ignore"):
        v = np.divide(mu, np.sqrt(2.0 * np.asarray(variance_along)) * sine)
    # Beyond 26 the value is below the smallest double; the infinity of the zenith becomes a number.
    v = np.minimum(v, 30.0)
    tail = 1.0 / (np.sqrt(np.pi) * v) - erfcx(v)
    return np.asarray(0.5 * np.exp(-(v**2)) * np.maximum(tail, 0.0), dtype=np.float64)


def both_seen(
    lambda_out: NDArray[np.float64], lambda_in: NDArray[np.float64], shadowing: Shadowing
) -> NDArray[np.float64]:
    """Return the share of mirroring facets that both directions see; symmetric in the two.

    ``none`` gives 1, ``separable`` the product of the two shares, ``height-correlated`` Smith's bistatic form.
    """
    if shadowing == "none":
        return np.ones(np.broadcast(lambda_out, lambda_in).shape)
    if shadowing == "separable":
        return np.asarray(1.0 / ((1.0 + lambda_out) * (1.0 + lambda_in)))
    return np.asarray(1.0 / (1.0 + (lambda_out + lambda_in)))


def escape_share(
    lambda_out: NDArray[np.float64] | float, lambda_in: NDArray[np.float64], shadowing: Shadowing
) -> NDArray[np.float64]:
    """Return the share of facets seen from one direction that the other, upward one sees as well."""
    if shadowing == "none":
        return np.ones(np.broadcast(lambda_out, lambda_in).shape)
    if shadowing == "separable":
        return np.asarray(1.0 / (1.0 + lambda_in))
    return np.asarray((1.0 + lambda_out) / (1.0 + (lambda_out + lambda_in)))
