"""Normal numbers of the lattice of clouds, as the package makes them from bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.models.clouds.fractal.lattice import normals_from_bits


def quantile(bits: NDArray[np.integer]) -> NDArray[np.float32]:
    """Return the normal number that belongs to each word of random bits."""
    values = np.empty(bits.size, dtype=np.float32)
    normals_from_bits(bits.astype(np.uint32), values)
    return values
