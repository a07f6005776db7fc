"""Tables as combinations of few states."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array

MANY_STATES = 4
"""States from which on it pays to look for fewer."""

LOST = 1e-5
"""Largest relative error of fewer states."""


def fewest_states(every: Array, size: Array, lost: float) -> tuple[Array, Array]:
    """Return the fewest states (R, V) and weights (S, R) whose combinations equal tables (S, V) within an error.

    Radiance is nearly a sum of few products of a function of the cloud and one of the direction: of the 16 tables
    toward a frame of a camera 4 or 5 combinations tell all of them within 1e-5. They are the singular vectors of the
    table of all tables.

    Parameters
    ----------
    size : ndarray (S, V) or (V,)
        To which the error ``lost`` is relative.
    """
    largest = np.max(np.abs(every), axis=0)
    scale = np.where(largest > 0.0, largest, 1.0)
    of_table, strength, of_column = np.linalg.svd(every / scale, full_matrices=False)
    for count in range(1, strength.size + 1):
        weights, states = of_table[:, :count], strength[:count, None] * of_column[:count] * scale
        if np.max(np.abs(weights @ states - every) / size) <= lost:
            break
    return weights, states
