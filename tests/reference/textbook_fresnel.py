"""Fresnel's equations as textbooks have them, without complex numbers."""

from __future__ import annotations

from typing import Any

import numpy as np


def real_fresnel(n: Any, k: Any, cosine: Any) -> Any:
    """Return the unpolarised reflectance of an absorbing medium in real arithmetic, in the form of a and b."""
    sin2 = 1.0 - cosine**2
    root = np.sqrt((n**2 - k**2 - sin2) ** 2 + 4.0 * n**2 * k**2)
    a, b2 = np.sqrt(0.5 * (root + (n**2 - k**2 - sin2))), 0.5 * (root - (n**2 - k**2 - sin2))
    rs = ((cosine - a) ** 2 + b2) / ((cosine + a) ** 2 + b2)
    ratio = ((a * cosine - sin2) ** 2 + b2 * cosine**2) / ((a * cosine + sin2) ** 2 + b2 * cosine**2)
    return 0.5 * rs * (1.0 + ratio)
