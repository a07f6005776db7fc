"""Which pixels are cloudy: eq 5 of the HCSS paper and its coverage by sorting."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf


def cloud_fraction_value(field: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map a standard normal field to p, uniform on [0, 1] (eq 5); any shape.

    p is exactly 1 above 8.3; order pixels by the field, not by p.
    """
    p: NDArray[np.float64] = 0.5 * (1.0 + erf(field * np.sqrt(0.5)))
    return p


def cloudy_pixels(field: NDArray[np.float64], coverage: float) -> NDArray[np.bool_]:
    """Return the mask of the pixels with the greatest field values, exactly as many as asked for.

    Sorting p and sorting the field are the same, because eq 5 is monotonic; the field does not
    saturate. A threshold from the normal quantile would hold the coverage only on average over
    realisations, with a scatter of about .04 from frame to frame for large cells.

    Parameters
    ----------
    field : ndarray of float64 (rows, columns)
        The field V.
    coverage : float
        Wanted fraction of cloudy pixels, 0 to 1.

    Returns
    -------
    ndarray of bool (rows, columns)
        True in ``round(coverage * field.size)`` pixels (halves go to the even number). Of pixels
        with equal values those with the smaller flat index are taken first.

    Raises
    ------
    ValueError
        If the coverage is outside [0, 1].
    """
    if not 0.0 <= coverage <= 1.0:
        raise ValueError(
            f"coverage: {coverage} given, allowed 0 to 1; closest is {1.0 if coverage > 1.0 else 0.0}"
        )
    count = round(coverage * field.size)
    if count == 0:
        return np.zeros(field.shape, dtype=np.bool_)
    if count == field.size:
        return np.ones(field.shape, dtype=np.bool_)
    flat = field.ravel()
    lowest = np.partition(flat, flat.size - count)[flat.size - count]
    mask: NDArray[np.bool_] = np.greater_equal(flat, lowest)
    surplus = int(np.count_nonzero(mask)) - count
    if surplus:
        mask[np.flatnonzero(flat == lowest)[-surplus:]] = False
    return mask.reshape(field.shape)
