"""Patches of images as the realism test compares them: one resolution, one noise, with cloud in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from hcss_twin import ImageError
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.providers import Array

SIZE = 64
"""Side of a patch, pixels."""

COLDER_K = 2.5
"""Cloud is this much colder than clear sky."""

_CLEAR_PERCENTILE = 99.0
_LEAST_COLD = 0.05
_LEAST_SPREAD_K = 0.5


@dataclass(frozen=True)
class Patches:
    """Patches of the images of one side.

    Attributes
    ----------
    kelvin : ndarray (P, n, n)
        Brightness temperature without added noise.
    noisy : ndarray (P, n, n)
        The same with noise.
    scene : ndarray (P,)
        Scene of each patch.
    cut : int
        Number of patches before those without cloud, structure or all values were left out.
    """

    kelvin: Array
    noisy: Array
    scene: NDArray[np.int64]
    cut: int


def cut_patches(
    side: str,
    fields: Sequence[Array] | Array,
    scenes: Sequence[int] | NDArray[np.int64],
    *,
    size: int,
    blur_pixels: float,
    noise_k: float,
    rng: np.random.Generator,
) -> Patches:
    """Blur images, cut them into patches side by side, and leave out those without cloud or structure.

    A patch is left out if less than 5 % of it is 2.5 K colder than the 99th percentile of its image, if its standard
    deviation is below .5 K, or if it has missing values.

    Parameters
    ----------
    side : str
        For messages.
    fields : sequence of ndarray (rows, columns)
        Brightness temperature, K; NaN where missing.
    scenes : sequence of int
        Scene of each image.
    size : int
        Side of the patches, pixels.
    blur_pixels : float
        Standard deviation of the Gaussian blur, pixels.
    noise_k : float
        Standard deviation of the white noise, K.
    rng : Generator
        Of the noise.

    Raises
    ------
    ImageError
        If an image is smaller than a patch or not in kelvin, or no patch is left.
    """
    kept: list[Array] = []
    scene: list[int] = []
    cut = 0
    for index, (given, number) in enumerate(zip(fields, scenes, strict=True)):
        field = np.asarray(given, dtype=np.float64)
        if field.ndim != 2 or min(field.shape) < size:
            raise ImageError(f"{side} image {index}: shape {field.shape}, allowed: {size} x {size} pixels or more")
        low, high = (np.nanmin(field), np.nanmax(field)) if np.isfinite(field).any() else (np.nan, np.nan)
        if not 100.0 < low <= high < 400.0:
            raise ImageError(
                f"{side} image {index}: values from {low:g} to {high:g}, allowed: brightness temperature, 100 to 400 K"
                f"{SatelliteImage.of_kelvin(field).closest_reading()}"
            )
        if blur_pixels:
            field = gaussian_filter(field, blur_pixels, mode="nearest")
        colder = colder_than_clear(field) > COLDER_K
        rows, columns = (length // size for length in field.shape)
        for row, column in np.ndindex(rows, columns):
            at = np.s_[row * size : (row + 1) * size, column * size : (column + 1) * size]
            cut += 1
            # Missing values make the spread NaN.
            if colder[at].mean() >= _LEAST_COLD and field[at].std() >= _LEAST_SPREAD_K:
                kept.append(field[at])
                scene.append(int(number))
    if not kept:
        raise ImageError(
            f"{side}: none of {cut} patches has cloud; needed: {100 * _LEAST_COLD:g} % of pixels {COLDER_K} K colder "
            f"than the image's {_CLEAR_PERCENTILE:g}th percentile, and a standard deviation of {_LEAST_SPREAD_K} K"
        )
    kelvin = np.stack(kept)
    noisy = kelvin + noise_k * rng.standard_normal(kelvin.shape)
    return Patches(kelvin, noisy, np.array(scene, dtype=np.int64), cut)


def colder_than_clear(field: Array) -> Array:
    """Return how much colder than the 99th percentile of an image (K) each pixel is; NaN where missing."""
    contrast: Array = np.nanpercentile(field, _CLEAR_PERCENTILE) - field
    return contrast


def z_scored(patches: Array) -> Array:
    """Return patches (P, n, n) with mean 0 and standard deviation 1 each."""
    deviation = patches - patches.mean(axis=(1, 2), keepdims=True)
    scaled: Array = deviation / patches.std(axis=(1, 2), keepdims=True)
    return scaled
