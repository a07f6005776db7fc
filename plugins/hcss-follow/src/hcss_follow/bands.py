"""Bands of scale: differences of Gaussians of 1 to 32 pixels, and what is larger."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter

from hcss_follow.state import Field

SIGMAS = 1.0, 2.0, 4.0, 8.0, 16.0, 32.0
"""Standard deviations of the Gaussians, pixels."""

COUNT = len(SIGMAS) + 1


def smooth(field: Field, sigma: float) -> Field:
    """Return a field smoothed by a Gaussian; what is beyond the edge is that at the edge."""
    done: Field = gaussian_filter(field, sigma, mode="nearest", truncate=3.0)
    return done


def bands_of(field: Field) -> Field:
    """Return the bands (7, rows, columns) of a field, finest first, whose sum is the field."""
    levels = [field, *(smooth(field, sigma) for sigma in SIGMAS)]
    return np.stack([*(fine - coarse for fine, coarse in pairwise(levels)), levels[-1]])


def local_energy(bands: Field) -> Field:
    """Return the mean squares (7, rows, columns) of bands around each pixel, within twice the scale of each band."""
    widths = [max(4.0, 2.0 * sigma) for sigma in (*SIGMAS, SIGMAS[-1])]
    return np.stack([smooth(band * band, width) for band, width in zip(bands, widths, strict=True)])
