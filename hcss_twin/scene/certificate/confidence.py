"""What pixels without exceedance say about those that were not checked.

Of n pixels drawn at random none exceeds, with a chance of (1 - p)^n, if a share p of all does. At 95 % confidence p is
therefore below 1 - 0.05^(1/n): under 1 % for n = 300 (C. J. Clopper and E. S. Pearson, *The use of confidence or
fiducial limits illustrated in the case of the binomial*, Biometrika 26, 1934, for no event).

Where strata are drawn with shares of their own, that holds for a pixel drawn likewise; of all pixels, the share may be
larger, most where a large stratum had few.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CONFIDENCE = 0.95


def share_drawn_alike(count: int) -> float:
    """Return the share of exceedances, of pixels drawn like the checked ones, that is excluded; 1 without any."""
    return float(1.0 - (1.0 - CONFIDENCE) ** (1.0 / count)) if count else 1.0


def share_of_all(pixels: NDArray[np.int64], checked: NDArray[np.int64]) -> float:
    """Return the share of exceedances, of all pixels, that is excluded when none of the checked ones exceeds.

    It is the largest sum of W p with the product of (1 - p)^n at least 0.05, over strata with the share W of all
    pixels, of which n were checked. Lagrange's rule gives 1 - p = min(1, t n / W), with one t for all strata.

    Parameters
    ----------
    pixels, checked : ndarray (S,)
        Pixels of each stratum, and how many of them were checked. Nothing is left open where all were.
    """
    total = int(np.sum(pixels))
    left = checked < pixels
    weight, count = pixels[left] / max(total, 1), checked[left].astype(np.float64)
    unseen = float(np.sum(weight[count == 0]))
    weight, count = weight[count > 0], count[count > 0]
    order = np.argsort(count / weight)
    weight, count = weight[order], count[order]
    rate = count / weight
    for active in range(count.size, 0, -1):
        own = slice(active)
        ln_t = (np.log(1.0 - CONFIDENCE) - np.sum(count[own] * np.log(rate[own]))) / np.sum(count[own])
        if ln_t + np.log(rate[active - 1]) <= 0.0:
            return unseen + float(np.sum(weight[own] - np.exp(ln_t) * count[own]))
    return unseen
