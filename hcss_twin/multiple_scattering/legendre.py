"""Associated Legendre functions, normalised so that none grows with its degree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def normalised_legendre(mu: Array, order: int, degrees: int) -> Array:
    """Evaluate sqrt((l - m)! / (l + m)!) P_l^m(mu), without the sign (-1)^m.

    By the addition theorem P_l(cos(angle between two directions)) is the sum over m of (2 - delta_m0)
    times the product of these functions of both cosines times cos(m azimuth difference).

    Parameters
    ----------
    mu : ndarray (D,)
        Cosines in [-1, 1].
    order : int
        m, 0 or more.
    degrees : int
        Functions of degree 0 to ``degrees`` - 1 are returned; those below m are 0.

    Returns
    -------
    ndarray (degrees, D)

    References
    ----------
    Recurrence over the degree at constant order: J. V. Dave and B. H. Armstrong, J. Quant. Spectrosc.
    Radiat. Transfer 10, 557 (1970), whose stability for all l the bound |value| <= 1 keeps.
    """
    m = order
    result = np.zeros((degrees, mu.size))
    if m >= degrees:
        return result
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    first = np.ones_like(mu)
    for k in range(1, m + 1):
        first = first * sine * np.sqrt((2 * k - 1) / (2 * k))
    result[m] = first
    if m + 1 < degrees:
        result[m + 1] = np.sqrt(2 * m + 1) * mu * first
    for l in range(m + 1, degrees - 1):  # noqa: E741
        before = np.sqrt(l * l - m * m) * result[l - 1]
        result[l + 1] = ((2 * l + 1) * mu * result[l] - before) / np.sqrt((l + 1) ** 2 - m * m)
    return result
