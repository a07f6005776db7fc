"""The alias for arrays of double precision, which almost every signature uses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
