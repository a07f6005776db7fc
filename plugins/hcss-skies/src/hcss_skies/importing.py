"""Examples from satellite images of brightness temperature near 10.8 um, and perhaps at 12.0 um."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_skies.detail_of_image import fit_detail
from hcss_skies.example import MAX_SIDE, MIN_SIDE, Detail, Example, make_example
from hcss_skies.missing import Missing, filled, without_missing
from hcss_skies.planes import FIRST, SECOND, Plane, read_plane, window_channel
from hcss_twin.core.reading import Reading
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.providers import Array, CatalogError

CLEAR_K = 1.5
"""Pixels colder than the clear sky by more hold cloud: three standard deviations of clear sea."""

_CLEAR_PERCENTILE = 99.0

KELVIN_RANGE = 150.0, 340.0

BLUR_PIXELS, MAX_GAIN = 0.65, 3.5
"""Blur of the sensor that is removed, and the largest amplification of any wavelength."""

CELL_BLUR_PIXELS = 0.5
"""Blur in addition to the mean over a pixel: of SEVIRI, which samples fields of view of 4.8 km every 3 km, 0.2 of the
contrast of waves of two pixels is left, and the mean over a pixel leaves 0.64 (D. M. A. Aminou, ESA Bulletin 111, 15,
2002, has the sampling and the fields of view)."""


@dataclass(frozen=True)
class Imported:
    """An example, the variables that it was made of (the second is empty without one), and notes for the user."""

    example: Example
    variable: str
    second: str
    notes: tuple[str, ...]


def import_example(
    path: Path,
    *,
    variable: str | None = None,
    second: str | None = None,
    at: Mapping[str, int] | None = None,
    missing: Missing = "auto",
    pixel_size_m: float | None = None,
    lapse_K_km: float = 6.5,
    clear_K: float | None = None,
    kind: str = "imported",
    licence: str = "",
) -> Imported:
    """Return the example of an image, and what was done to it.

    Parameters
    ----------
    path : Path
        Image of brightness temperature in K, or of radiance of GOES ABI; formats of ``hcss import``.
    variable : str, optional
        Of a file with several images; default: the one named like a channel near 10.8 um.
    second : str, optional
        Image at 12.0 um in the same file, from which heights of thin clouds follow; default: if ``variable`` is not
        given, the one named like this channel.
    at : mapping of str to int, optional
        Index along each further dimension of NetCDF variables of several images.
    missing : {"auto", "fill", "crop"}
        What to do about missing pixels: see :func:`hcss_skies.missing.without_missing`.
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
        If the file is no image, has no pixel size, too many missing pixels or values that are not temperatures.
    """
    plane = read_plane(path, variable, at or {})
    size = pixel_size_m or plane.pixel_size_m
    if size is None:
        raise CatalogError(f"{path}: the pixel size is not known; give it with --pixel-size")
    if not 1.0 <= size <= 1e5:
        closest = min(max(size, 1.0), 1e5)
        raise CatalogError(f"{path}: pixel size {size:g} m; allowed: 1 to 100000; closest is {closest:g}")
    other = _second(path, plane, variable, second, at or {})
    # Pixels that one channel lacks are missing in both.
    common = plane.kelvin if other is None else np.where(np.isfinite(other.kelvin), plane.kelvin, np.nan)
    try:
        part, kelvin, text = without_missing(common, missing)
    except CatalogError as error:
        raise CatalogError(f"{path}: {error}") from error
    _require_kelvin(path, kelvin)
    if not MIN_SIDE <= min(kelvin.shape) <= max(kelvin.shape) <= MAX_SIDE:
        raise CatalogError(
            f"{path}: {' x '.join(map(str, kelvin.shape))} pixels; allowed: sides of {MIN_SIDE} to {MAX_SIDE}"
        )
    warm = clear_sky_K(kelvin) if clear_K is None else clear_K
    excess: Array | None = None
    if other is not None:
        from hcss_skies.split_window import height_above_opaque_m  # not for images of one channel

        second_K = np.where(np.isfinite(common), other.kelvin, np.nan)[part]
        if not np.all(np.isfinite(second_K)):
            second_K = filled(second_K)
        _require_kelvin(path, second_K)
        excess = height_above_opaque_m(kelvin, second_K, warm, 1e-3 * lapse_K_km)
    clear_m = CLEAR_K / lapse_K_km * 1e3
    opaque_m = (warm - sharpened(kelvin)) / lapse_K_km * 1e3
    example = make_example(
        opaque_m,
        excess,
        pixel_size_m=size,
        clear_m=clear_m,
        kind=kind,
        source=", ".join(text_part for text_part in (plane.source, text) if text_part),
        licence=licence or plane.rights or "not stated",
        detail=detail_of(kelvin, warm),
        lapse_K_m=1e-3 * lapse_K_km,
    )
    return Imported(
        example, plane.variable, "" if other is None else other.variable, (*plane.notes, *filter(None, [text]))
    )


def detail_of(kelvin: Array, warm_K: float) -> Detail | None:
    """Return the detail of an image of brightness temperature below its pixel, without the blur of its sensor."""
    return fit_detail(warm_K - sharpened(kelvin, CELL_BLUR_PIXELS), warm_K - sharpened(kelvin) - CLEAR_K)


def clear_sky_K(kelvin: Array) -> float:
    """Return the brightness temperature that counts as clear sky unless it is given."""
    return float(np.percentile(kelvin, _CLEAR_PERCENTILE))


def _second(path: Path, plane: Plane, variable: str | None, second: str | None, at: Mapping[str, int]) -> Plane | None:
    """Return the image at 12.0 um, if one is named or the file has one beside an image that was not named."""
    if second is None and (variable is not None or not re.fullmatch(FIRST, plane.variable, re.IGNORECASE)):
        return None
    if second is None:
        with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as dataset:
            second = window_channel(dataset.variables, SECOND)
        if second is None:
            return None
    other = read_plane(path, second, at)
    if other.kelvin.shape != plane.kelvin.shape:
        raise CatalogError(f"{path}: {second} has {other.kelvin.shape} pixels, {plane.variable} {plane.kelvin.shape}")
    return other


def _require_kelvin(path: Path, kelvin: Array) -> None:
    low, high = KELVIN_RANGE
    if kelvin.min() < low or kelvin.max() > high:
        raise CatalogError(
            f"{path}: values of {kelvin.min():g} to {kelvin.max():g}; allowed: brightness temperatures, "
            f"{low:g} to {high:g} K{SatelliteImage.of_kelvin(kelvin).closest_reading()}"
        )


def sharpened(image: Array, blur_pixels: float = BLUR_PIXELS) -> Array:
    """Return an image without the Gaussian blur of the sensor, as far as the largest gain allows."""
    margin = min(32, *image.shape)
    padded = np.pad(image, margin, mode="symmetric")
    square = [(2.0 * np.pi * np.fft.fftfreq(side)) ** 2 for side in padded.shape]
    gain = np.minimum(np.exp(0.5 * blur_pixels**2 * np.add.outer(*square)), MAX_GAIN)
    sharp: Array = np.fft.ifft2(np.fft.fft2(padded) * gain).real[margin:-margin, margin:-margin]
    return np.clip(sharp, image.min(), image.max())
