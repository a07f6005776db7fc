"""Import an image file into the cloud database: extract its clouds and measure their fractal dimension."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.database.segmentation import Cleaning, segment
from hcss_evaluate.measures.box_counting import box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import DimensionEstimate, variogram_dimension
from hcss_twin import __version__
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CatalogError, ImageError

# Percentiles of the image between which the preview picture is stretched.
_SHOWN_PERCENTILES = (0.5, 99.5)


@dataclass(frozen=True)
class ImportOptions:
    """Import options, including metadata that the image file lacks.

    Attributes
    ----------
    variable : str or None
        Variable or band to read from a file with several.
    at : mapping of str to int
        Index along each further dimension of a NetCDF variable of several images.
    method : {"otsu", "local", "coverage", "valid"}
        Cloud detection method. ``valid`` is for products with values in cloud only, such as cloud-top heights: every
        pixel with a value is cloud, every other one clear.
    window : int or None
        Side of the window of method ``local``.
    coverage : float or None
        Fraction of cloudy pixels for method ``coverage``, before cleaning.
    cloud_is : {"auto", "bright", "dark"}
        Which values are cloud.
    cleaning : Cleaning
        Sizes of the closing, the opening, the largest filled hole and the smallest cloud.
    crop : tuple of int or None
        First row, first column, rows and columns of the part to import, counted as stored; None: the whole image.
    pixel_size_m : float or None
        Overrides the pixel size in the file; required if the file has none.
    pixel_size_from : {"user", "sample"}
        Who states ``pixel_size_m``: the user, or the catalog's description of a measured sample.
    band, observed, source, licence : str or None
        Override the metadata in the file.
    """

    variable: str | None = None
    at: Mapping[str, int] = field(default_factory=dict)
    method: Literal["otsu", "local", "coverage", "valid"] = "otsu"
    window: int | None = None
    coverage: float | None = None
    cloud_is: SatelliteImage.CloudIs = "auto"
    cleaning: Cleaning = field(default_factory=Cleaning)
    crop: tuple[int, int, int, int] | None = None
    pixel_size_m: float | None = None
    pixel_size_from: Literal["user", "sample"] = "user"
    band: str | None = None
    observed: str | None = None
    source: str | None = None
    licence: str | None = None


def import_image(path: Path, options: ImportOptions | None = None) -> CloudEntry:
    """Extract the clouds from an image.

    Raises CatalogError if the image cannot be read, has no known pixel size, no contrast, or no cloud of the minimum
    size; or if the coverage is missing for method ``coverage`` or given for another method.
    """
    options = options or ImportOptions()
    _check(path, options)
    image = read_image(path, options.variable, options.at)
    part = ""
    if options.crop is not None:
        image = _cropped(path, image, options.crop)
        row, column, rows, columns = options.crop
        part = f", rows {row} to {row + rows - 1} and columns {column} to {column + columns - 1}"
    size = _pixel_size(path, image, options)
    # The generator counts rows from the south, image files count them from the north.
    level = image.level(options.cloud_is)[::-1]
    missing = np.isnan(level)
    bright = image.cloud_is_bright(options.cloud_is)
    if options.method == "valid":
        cloudy, lowest = ~missing, float(np.nanmin(level))
        threshold: float | NDArray[np.float64] = lowest
        missing = np.zeros_like(missing)
    else:
        try:
            threshold, lowest = SatelliteImage.Cloudy.threshold(
                level, options.method, options.window, options.coverage or 0.0, level
            )
        except ValueError as error:
            raise CatalogError(f"{path}: {error}") from error
        cloudy = level > threshold
    segments = segment(cloudy, missing, options.cleaning)
    mask = segments.labels > 0
    if not segments.clouds:
        raise CatalogError(
            f"{path}: no cloud of {options.cleaning.min_area} or more pixels among {np.count_nonzero(cloudy)} "
            "cloudy ones; allowed: another method, a smaller min_area, or no opening"
        )
    grey = np.zeros(level.shape, dtype=np.uint8)
    # In a product with values in cloud only, closing and filling add pixels without values.
    grey[mask] = 1 + np.rint(
        254.0 * SatelliteImage.Cloudy.relative_grey(np.nan_to_num(level[mask], nan=lowest), lowest)
    ).astype(np.uint8)
    surface = _dimension(lambda: variogram_dimension(level, mask=mask & ~np.isnan(level)))
    boxes = _dimension(lambda: box_counting_dimension(grey))
    sign = 1.0 if bright else -1.0
    facts = CloudEntry.Facts(
        source_file=image.source + part,
        source_sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
        variable=image.variable or CloudEntry.NOT_STATED,
        band=options.band or image.band or CloudEntry.NOT_STATED,
        observed=options.observed or image.date or CloudEntry.NOT_STATED,
        source=options.source or CloudEntry.NOT_STATED,
        licence=options.licence or (f"stated in the file: {image.rights}" if image.rights else CloudEntry.NOT_STATED),
        pixel_size_m=size,
        pixel_size_is_nominal=options.pixel_size_m is None and image.pixel_size_is_nominal,
        pixel_size_from="file" if options.pixel_size_m is None else options.pixel_size_from,
        units=image.units or CloudEntry.NOT_STATED,
        cloud_is="bright" if bright else "dark",
        method=options.method,
        window_pixels=(options.window or max(3, min(level.shape) // 8)) if options.method == "local" else 0,
        threshold_lowest=sign * lowest,
        threshold_highest=sign * max(lowest, float(np.nanmax(threshold))),
        closing=options.cleaning.closing,
        opening=options.cleaning.opening,
        largest_hole=options.cleaning.largest_hole,
        min_area=options.cleaning.min_area,
        holes_filled=segments.holes,
        hole_pixels=segments.hole_pixels,
        clouds_dropped=segments.dropped,
        coverage=float(np.count_nonzero(mask & ~missing)) / np.count_nonzero(~missing),
        clouds=segments.clouds,
        missing_pixels=int(np.count_nonzero(missing)),
        fractal_dimension=surface.dimension,
        fractal_dimension_error=surface.standard_error,
        fractal_dimension_method=surface.method,
        box_counting_dimension=boxes.dimension,
        box_counting_error=boxes.standard_error,
        box_counting_method=boxes.method,
        created=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        created_with=f"hcss-twin {__version__}",
    )
    notes = (
        *image.described(options.cloud_is),
        *image.lost_cloud(level, mask, options.cloud_is),
        *_changed_by_cleaning(cloudy & ~missing, facts.coverage, missing),
    )
    return CloudEntry(grey, segments.labels, missing, _shown(level), facts, notes)


def _cropped(path: Path, image: SatelliteImage, crop: tuple[int, int, int, int]) -> SatelliteImage:
    """Return a part of an image: first row, first column, rows and columns, counted as stored.

    Raises
    ------
    CatalogError
        If the part is not inside the image, has a side of one pixel, or no pixel with a value.
    """
    row, column, rows, columns = crop
    height, width = image.values.shape
    if not (0 <= row <= height - rows and 0 <= column <= width - columns and min(rows, columns) >= 2):
        raise CatalogError(
            f"{path}: crop: {rows} rows and {columns} columns from row {row} and column {column}; allowed: two or more "
            f"within the {height} rows and {width} columns of the image"
        )
    values = image.values[row : row + rows, column : column + columns]
    if np.isnan(values).all():
        raise CatalogError(f"{path}: crop: all {values.size} pixels are missing; allowed: a part with values")
    return replace(image, values=values)


def _changed_by_cleaning(cloudy: NDArray[np.bool_], coverage: float, missing: NDArray[np.bool_]) -> tuple[str, ...]:
    """Return a note on the coverage before and after cleaning, if they differ."""
    before = np.count_nonzero(cloudy) / np.count_nonzero(~missing)
    if before == coverage:
        return ()
    return (f"Cleaning of the mask changes the coverage from {before:.4f} to {coverage:.4f}.",)


def _check(path: Path, options: ImportOptions) -> None:
    """Reject contradictory options; none is ignored."""
    if (options.coverage is None) is (options.method == "coverage"):
        given = "not given" if options.coverage is None else f"{options.coverage:g} given"
        raise CatalogError(
            f"{path}: coverage: {given} with the method '{options.method}'; allowed: with the method 'coverage', "
            "not with others"
        )
    if options.window is not None and (options.method != "local" or options.window < 3):
        raise CatalogError(
            f"{path}: window: {options.window} given with the method '{options.method}'; allowed: 3 or more, with "
            "the method 'local'"
        )
    size = options.pixel_size_m
    if size is not None and not 0.0 < size < math.inf:
        raise CatalogError(f"{path}: pixel_size: {size:g} m given, allowed: greater than 0 and finite")


def _pixel_size(path: Path, image: SatelliteImage, options: ImportOptions) -> float:
    size = options.pixel_size_m or image.pixel_size_m
    if size is None:
        why = image.pixel_size_note or "the file gives no pixel size"
        raise CatalogError(f"{path}: {why}; give the pixel size on the ground (--pixel-size)")
    return size


def _dimension(estimate: Callable[[], DimensionEstimate]) -> DimensionEstimate:
    """Return an estimate; for images that are too small, NaN with the reason in place of the method."""
    try:
        return estimate()
    except ImageError as error:
        return DimensionEstimate(math.nan, math.nan, f"not estimated: {error}")


def _shown(level: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the preview picture (rows, columns): 1 to 255 over most of the range, 0 where missing."""
    low, high = np.nanpercentile(level, _SHOWN_PERCENTILES)
    if not high > low:
        low, high = float(np.nanmin(level)), float(np.nanmax(level))
    scaled = np.clip((level - low) / (high - low), 0.0, 1.0)
    return np.where(np.isnan(scaled), 0, 1 + np.rint(254.0 * np.nan_to_num(scaled))).astype(np.uint8)
