"""Type alias for double-precision arrays, used in almost every signature."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Array of double precision."""
