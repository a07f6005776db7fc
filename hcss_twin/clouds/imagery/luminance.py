"""Grey levels of colour pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# ITU-R BT.601, section 2.5.1: luminance from the colour components.
_LUMINANCE = np.array([0.299, 0.587, 0.114])


def luminance(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return luminance (rows, columns) of red, green, blue and, where given, opacity (rows, columns, 3 or 4).

    Transparent pixels are missing: NaN.
    """
    grey: NDArray[np.float64] = colours[..., :3] @ _LUMINANCE
    return grey if colours.shape[2] == 3 else np.where(colours[..., 3] > 0.0, grey, np.nan)
