"""Bands of scale of patches (differences of Gaussians), and lengths of autocorrelation."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter

from hcss_evaluate.realism.moments import standard_moment
from hcss_twin.providers import Array

_SIGMAS = (1.0, 2.0, 4.0, 8.0)
"""Standard deviations of the Gaussians, pixels."""


def band_features(patches: Array) -> dict[str, Array]:
    """Return the kurtosis of bands of scale, and the correlation between the amplitudes of neighbouring ones.

    Bands of patches (P, n, n) are differences between Gaussian blurs of 0, 1, 2, 4 and 8 pixels. Amplitudes correlate
    where small structures sit on large ones; in a Gaussian field the correlation is near 0.
    """
    blurred = [patches, *(gaussian_filter(patches, (0.0, sigma, sigma)) for sigma in _SIGMAS)]
    names = [f"{low:g}-{high:g} px" for low, high in zip((0.0, *_SIGMAS), _SIGMAS, strict=False)]
    bands = [fine - coarse for fine, coarse in pairwise(blurred)]
    found = {f"kurtosis of band {name}": standard_moment(band, 4) for name, band in zip(names, bands, strict=True)}
    sizes = [np.abs(band).reshape(len(patches), -1) for band in bands]
    for index in range(len(sizes) - 1):
        deviations = [size - size.mean(axis=1, keepdims=True) for size in sizes[index : index + 2]]
        spread = np.prod([np.sqrt(np.mean(deviation**2, axis=1)) for deviation in deviations], axis=0)
        product = np.mean(deviations[0] * deviations[1], axis=1)
        found[f"correlation of bands {names[index]}, {names[index + 1]}"] = product / np.where(spread > 0, spread, 1.0)
    return found


def autocorrelation_length(patches: Array, axis: int, level: float) -> Array:
    """Return the distance (P,) in pixels at which autocorrelation along an axis falls to ``level``.

    Linear between pixels; half of the patch where it falls no further than that.

    Parameters
    ----------
    patches : ndarray (P, n, n)
    axis : {1, 2}
        Rows or columns.
    level : float
        Between 0 and 1.
    """
    deviation = np.moveaxis(patches - patches.mean(axis=(1, 2), keepdims=True), axis, 2)
    variance = np.mean(deviation**2, axis=(1, 2))
    lags = range(1, deviation.shape[2] // 2 + 1)
    products = [np.mean(deviation[:, :, lag:] * deviation[:, :, :-lag], axis=(1, 2)) for lag in lags]
    curve = np.stack([np.ones(len(patches)), *(product / variance for product in products)], axis=1)
    below = curve < level
    first = np.where(below.any(axis=1), below.argmax(axis=1), len(lags))
    rows = np.arange(len(patches))
    before, after = curve[rows, first - 1], curve[rows, first]
    with np.errstate(divide="ignore", invalid="ignore"):
        within = np.where(after < level, (before - level) / (before - after), 1.0)
    return np.asarray(first - 1 + within, dtype=np.float64)


def autocorrelation_features(patches: Array) -> dict[str, Array]:
    """Return the shorter and the longer of the lengths along both axes, at autocorrelations 1/e and .7."""
    found = {}
    for name, level in (("1/e", np.exp(-1.0)), ("0.7", 0.7)):
        lengths = np.sort([autocorrelation_length(patches, axis, float(level)) for axis in (1, 2)], axis=0)
        found[f"shorter correlation length ({name})"], found[f"longer correlation length ({name})"] = lengths
    return found
