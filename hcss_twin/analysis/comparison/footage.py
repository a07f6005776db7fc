"""Frames of one quantity, from an image, several images or a cube; and the options by which they are chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageOptionError
from hcss_twin.models.clouds.imagery.cloudiness import CloudIs

Method = Literal["auto", "otsu", "local", "coverage", "valid", "truth"]


@dataclass(frozen=True)
class EvaluationChoice:
    """Which part of an image or a cube is compared, and what in it is cloud.

    Attributes
    ----------
    variable : str or None
        Variable of a NetCDF or ``.npz`` file or of a cube, or number of a GeoTIFF's band.
    band : str or None
        Name of a cube's band.
    frames : tuple of int
        Numbers of a cube's frames from 0; none: all.
    method : {"auto", "otsu", "local", "coverage", "valid", "truth"}
        How cloudy pixels are found. ``valid`` takes every pixel that has a value, ``truth`` a cube's own cloud mask;
        ``auto`` is ``valid`` for cloud-top products, ``truth`` for a cube's variables of clouds, ``otsu`` for all else.
    cloud_is : {"auto", "bright", "dark"}
        Which values are cloud.
    coverage : float or None
        For method ``coverage``: cloudy fraction.
    window_pixels : int or None
        For method ``local``: side of the surroundings.
    pixel_size_m : float or None
        Side of a pixel, in place of what the file tells.
    """

    variable: str | None = None
    band: str | None = None
    frames: tuple[int, ...] = ()
    method: Method = "auto"
    cloud_is: CloudIs = "auto"
    coverage: float | None = None
    window_pixels: int | None = None
    pixel_size_m: float | None = None

    def check(self) -> None:
        """Refuse options that contradict each other: none is ignored.

        Raises ImageOptionError naming the option.
        """
        if (self.coverage is None) is (self.method == "coverage"):
            raise ImageOptionError("coverage: goes with the method 'coverage', and only with it")
        if self.coverage is not None and not 0.0 < self.coverage <= 1.0:
            raise ImageOptionError(f"coverage: {self.coverage} given, allowed: greater than 0, up to 1")
        if self.window_pixels is not None and self.method != "local":
            raise ImageOptionError("window_pixels (--window): goes with the method 'local', and only with it")
        if self.pixel_size_m is not None and not self.pixel_size_m > 0.0:
            raise ImageOptionError(f"pixel_size: {self.pixel_size_m} m given, allowed: greater than 0")


KELVIN = ("k", "kelvin")


@dataclass(frozen=True)
class Footage:
    """Frames of one quantity, rows northward and columns eastward.

    Attributes
    ----------
    name : str
        Of the file.
    quantity, units, band : str
        What the values are; units and the spectral band in words are empty where the file does not say.
    wavelength_um : float or None
        About the middle of the band.
    is_nominal : bool
        Whether the pixel size is that below a geostationary satellite.
    labels : tuple of str
        Of the frames: time, number or file.
    seconds : tuple of float or None
        Times of the frames after the first; None where they are not known.
    method : str
        How cloud is found, ``auto`` resolved.
    notes : tuple of str
        What was chosen and why.
    values, truth : callable
        Number of a frame to its values (rows, columns), NaN where missing, and to its cloud mask where the file has
        one.
    kelvin : callable or None
        Values to brightness temperatures, where that is possible; NaN where there is none.
    """

    name: str
    kind: Literal["image", "images", "cube"]
    quantity: str
    units: str
    band: str
    wavelength_um: float | None
    shape: tuple[int, int]
    pixel_size_m: float | None
    is_nominal: bool
    labels: tuple[str, ...]
    seconds: tuple[float, ...] | None
    bright_is_cloud: bool
    method: Method
    notes: tuple[str, ...]
    values: Callable[[int], Array]
    truth: Callable[[int], NDArray[np.bool_]] | None
    kelvin: Callable[[Array], Array] | None

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.labels)


def is_kelvin(units: str) -> bool:
    """Whether a unit is kelvin."""
    return units.strip().casefold() in KELVIN
