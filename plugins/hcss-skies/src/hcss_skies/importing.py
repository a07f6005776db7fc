"""Examples from satellite images of brightness temperature near 10.8 um, and perhaps at 12.0 um."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hcss_skies.example import MAX_SIDE, MIN_SIDE, Example, make_example
from hcss_twin.errors import CatalogError
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.netcdf_image import UNITS, planck_coefficients
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array

CLEAR_K = 1.5
"""Pixels colder than the clear sky by more hold cloud: three standard deviations of clear sea."""

_CLEAR_PERCENTILE = 99.0

_KELVIN_RANGE = 150.0, 340.0

BLUR_PIXELS, MAX_GAIN = 0.65, 3.5
"""Blur of the sensor that is removed, and the largest amplification of any wavelength."""


def import_example(
    path: Path,
    *,
    variable: str | None = None,
    second: str | None = None,
    pixel_size_m: float | None = None,
    lapse_K_km: float = 6.5,
    clear_K: float | None = None,
    kind: str = "imported",
    licence: str = "",
) -> Example:
    """Return the example of an image.

    Parameters
    ----------
    path : Path
        Image of brightness temperature in K, or of radiance of GOES ABI; formats of ``hcss import``.
    variable : str, optional
        Of a file with several images.
    second : str, optional
        Image at 12.0 um in the same file, from which heights of thin clouds follow.
    pixel_size_m : float, optional
        Default: that of the file.
    lapse_K_km : float
        Lapse rate that gives heights.
    clear_K : float, optional
        Brightness temperature of the clear sky; default: the 99th percentile.
    kind, licence : str
        Kind of clouds; terms of use, by default those in the file.

    Raises
    ------
    CatalogError
        If the file is no image, has no pixel size, missing pixels or values that are not temperatures.
    """
    image = read_image(path, variable)
    kelvin = _kelvin(path, image)
    size = pixel_size_m or image.pixel_size_m
    if size is None:
        raise CatalogError(f"{path}: the pixel size is not known; give it with --pixel-size")
    if not 1.0 <= size <= 1e5:
        closest = min(max(size, 1.0), 1e5)
        raise CatalogError(f"{path}: pixel size {size:g} m; allowed: 1 to 100000; closest is {closest:g}")
    if not MIN_SIDE <= min(kelvin.shape) <= max(kelvin.shape) <= MAX_SIDE:
        raise CatalogError(
            f"{path}: {' x '.join(map(str, kelvin.shape))} pixels; allowed: sides of {MIN_SIDE} to {MAX_SIDE}"
        )
    warm = float(np.percentile(kelvin, _CLEAR_PERCENTILE)) if clear_K is None else clear_K
    excess: Array | None = None
    if second is not None:
        from hcss_skies.split_window import height_above_opaque_m  # not for images of one channel

        other = _kelvin(path, read_image(path, second))
        if other.shape != kelvin.shape:
            raise CatalogError(f"{path}: {second} has {other.shape} pixels, {image.long_name} {kelvin.shape}")
        excess = height_above_opaque_m(kelvin, other, warm, 1e-3 * lapse_K_km)
    return make_example(
        (warm - sharpened(kelvin)) / lapse_K_km * 1e3,
        excess,
        pixel_size_m=size,
        clear_m=CLEAR_K / lapse_K_km * 1e3,
        kind=kind,
        source=f"{image.source}, {image.long_name} {image.date}".rstrip(),
        licence=licence or image.rights or "not stated",
    )


def _kelvin(path: Path, image: SatelliteImage) -> Array:
    """Return the brightness temperature of an image, north and east last."""
    kelvin: Array = image.values[:: -1 if image.north_first else 1, :: -1 if image.east_first else 1]
    coefficients = planck_coefficients(path) if image.units == UNITS else None
    if coefficients is not None:
        kelvin = coefficients.kelvin(kelvin)
    if not np.all(np.isfinite(kelvin)):
        raise CatalogError(f"{path}: {np.mean(~np.isfinite(kelvin)):.1%} of the pixels are missing; allowed: none")
    low, high = _KELVIN_RANGE
    if kelvin.min() < low or kelvin.max() > high:
        raise CatalogError(
            f"{path}: values of {kelvin.min():g} to {kelvin.max():g} {image.units}; allowed: brightness temperatures, "
            f"{low:g} to {high:g} K"
        )
    return kelvin


def sharpened(image: Array) -> Array:
    """Return an image without the Gaussian blur of the sensor, as far as the largest gain allows."""
    margin = min(32, *image.shape)
    padded = np.pad(image, margin, mode="symmetric")
    square = [(2.0 * np.pi * np.fft.fftfreq(side)) ** 2 for side in padded.shape]
    gain = np.minimum(np.exp(0.5 * BLUR_PIXELS**2 * np.add.outer(*square)), MAX_GAIN)
    sharp: Array = np.fft.ifft2(np.fft.fft2(padded) * gain).real[margin:-margin, margin:-margin]
    return np.clip(sharp, image.min(), image.max())
