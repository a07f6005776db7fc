"""Increments between pixels at a distance: their kurtosis in patches, and structure functions."""

from __future__ import annotations

import numpy as np

from hcss_evaluate.realism.moments import standard_moment
from hcss_twin.providers import Array

LAGS = (1, 2, 4, 8, 16)
"""Distances, pixels."""


def _increments(patches: Array, lag: int) -> Array:
    """Return differences (P, N) between pixels ``lag`` apart along both axes."""
    count = len(patches)
    along_y = patches[:, lag:] - patches[:, :-lag]
    along_x = patches[:, :, lag:] - patches[:, :, :-lag]
    return np.concatenate((along_y.reshape(count, -1), along_x.reshape(count, -1)), axis=1)


def increment_features(patches: Array) -> dict[str, Array]:
    """Return the kurtosis of increments of patches (P, n, n): 3 for a Gaussian field, more where change is rare."""
    return {f"kurtosis of increments at {lag} px": standard_moment(_increments(patches, lag), 4) for lag in LAGS}


def structure_function(patches: Array, order: int = 2) -> Array:
    """Return the mean of |increment|^order over all patches (P, n, n) at each of ``LAGS``."""
    return np.array([np.mean(np.abs(_increments(patches, lag)) ** order) for lag in LAGS])
