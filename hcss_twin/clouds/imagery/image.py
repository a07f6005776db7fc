"""One plane of a satellite image in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Image:
    """One plane of an image.

    Attributes
    ----------
    values : ndarray of float64 (rows, columns)
        As stored, in physical units where the file gives them; NaN where missing.
    pixel_size_m : float or None
        Side of a pixel on the ground; None where the file does not say.
    bright_is_cloud : bool
        Whether cloud has the larger values.
    units, long_name : str
        What the values are; empty where the file does not say.
    source : str
        Name of the file.
    pixel_size_is_nominal : bool
        True for a geostationary image: its pixel size is that below the satellite, and pixels
        elsewhere are larger.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost. Files
        without coordinates are taken to have the north in the first row, the west in the first column.
    pixel_size_note : str
        Why there is no pixel size, where the file has a grid that gives none; else empty.
    variable, band, date, rights : str
        Name of the plane in the file, spectral band, time of observation and terms of use, as the file
        states them; empty where it does not.
    """

    values: NDArray[np.float64]
    pixel_size_m: float | None
    bright_is_cloud: bool
    units: str
    long_name: str
    source: str
    pixel_size_is_nominal: bool = False
    north_first: bool = True
    east_first: bool = False
    pixel_size_note: str = ""
    variable: str = ""
    band: str = ""
    date: str = ""
    rights: str = ""
