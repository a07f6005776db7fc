"""One entry of the cloud database in memory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NOT_STATED = "not stated"
"""What stands where neither the image nor the user says anything."""


@dataclass(frozen=True)
class EntryFacts:
    """Where an entry comes from and how it was made; each is an attribute of its file.

    Attributes
    ----------
    source_file, source_sha256 : str
        Name and hash of the image file.
    variable, band, observed, source, licence : str
        Plane of the file, spectral band, time of observation, origin, and terms of use.
    pixel_size_m : float
        Side of a pixel on the ground.
    pixel_size_is_nominal : bool
        Whether it is that below a geostationary satellite; elsewhere pixels are larger.
    pixel_size_from : str
        ``file`` or ``user``.
    units, cloud_is : str
        Units of the image's values, and whether ``bright`` or ``dark`` ones are cloud.
    method : str
        Threshold method.
    window_pixels : int
        Side of the surroundings of method ``local``; 0 for the others.
    threshold_lowest, threshold_highest : float
        Thresholds in the image's units; they differ for method ``local`` only. Lowest means least cloudy.
    closing, opening, largest_hole, min_area : int
        Sizes of the cleaning in pixels (:class:`hcss_twin.clouds.database.segmentation.Cleaning`).
    holes_filled, hole_pixels, clouds_dropped : int
        What the cleaning did.
    coverage : float
        Fraction of cloudy pixels.
    clouds : int
        Number of single clouds.
    missing_pixels : int
        Pixels without a value.
    fractal_dimension, fractal_dimension_error : float
        Of the image's values in the cloudy pixels, and its standard error; NaN where not known.
    fractal_dimension_method : str
        How it was estimated, or why it was not.
    box_counting_dimension, box_counting_error : float
        Of the grey levels of the whole scene, clear sky being 0.
    box_counting_method : str
        How it was estimated, or why it was not.
    created, created_with : str
        Time of the import, and version of this package.
    """

    source_file: str
    source_sha256: str
    variable: str
    band: str
    observed: str
    source: str
    licence: str
    pixel_size_m: float
    pixel_size_is_nominal: bool
    pixel_size_from: str
    units: str
    cloud_is: str
    method: str
    window_pixels: int
    threshold_lowest: float
    threshold_highest: float
    closing: int
    opening: int
    largest_hole: int
    min_area: int
    holes_filled: int
    hole_pixels: int
    clouds_dropped: int
    coverage: float
    clouds: int
    missing_pixels: int
    fractal_dimension: float = math.nan
    fractal_dimension_error: float = math.nan
    fractal_dimension_method: str = NOT_STATED
    box_counting_dimension: float = math.nan
    box_counting_error: float = math.nan
    box_counting_method: str = NOT_STATED
    created: str = NOT_STATED
    created_with: str = NOT_STATED


@dataclass(frozen=True)
class CloudEntry:
    """Clouds of one image, north in the first row and west in the first column.

    Attributes
    ----------
    grey : ndarray of uint8 (rows, columns)
        0 clear, 1 to 255 from the threshold to the brightest cloud.
    labels : ndarray of int32 (rows, columns)
        0 clear, else the number of the single cloud, from 1.
    missing : ndarray of bool (rows, columns)
        Where the image has no value.
    image : ndarray of uint8 (rows, columns)
        The whole image for people to look at, cloud bright; 0 where missing.
    facts : EntryFacts
        Everything else.
    """

    grey: NDArray[np.uint8]
    labels: NDArray[np.int32]
    missing: NDArray[np.bool_]
    image: NDArray[np.uint8]
    facts: EntryFacts

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Cloudy pixels (rows, columns)."""
        return self.labels > 0
