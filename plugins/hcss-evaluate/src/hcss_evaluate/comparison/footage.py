"""Frames of one quantity from an image, several images or a cube, and the options that select them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.errors import ImageOptionError
from hcss_twin.core.arguments import checked
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.providers import Array

Method = Literal["auto", "otsu", "local", "coverage", "valid", "truth"]


@checked
@dataclass(frozen=True)
class EvaluationChoice:
    """Selection of the compared data and of the cloud detection.

    Attributes
    ----------
    variable : str or None
        Variable of a NetCDF file, ``.npz`` file or cube, or band number of a GeoTIFF.
    band : str or None
        Name of a band of a cube.
    frames : tuple of int
        Frame numbers of a cube, counted from 0; empty: all.
    method : {"auto", "otsu", "local", "coverage", "valid", "truth"}
        Cloud detection method. ``valid``: every pixel with a value; ``truth``: the cube's cloud mask; ``auto``:
        ``valid`` for cloud-top products, ``truth`` for cloud variables of a cube, ``otsu`` for everything else.
    cloud_is : {"auto", "bright", "dark"}
        Which values are cloud.
    coverage : float or None
        Cloudy fraction for method ``coverage``.
    window_pixels : int or None
        Side of the window for method ``local``.
    pixel_size_m : float or None
        Pixel size; overrides that in the file.
    """

    variable: str | None = None
    band: str | None = None
    frames: tuple[int, ...] = ()
    method: Method = "auto"
    cloud_is: SatelliteImage.CloudIs = "auto"
    coverage: float | None = None
    window_pixels: int | None = None
    pixel_size_m: float | None = None

    def check(self) -> None:
        """Raise ImageOptionError for contradictory options; none is ignored."""
        if (self.coverage is None) is (self.method == "coverage"):
            raise ImageOptionError("coverage: needed with the method 'coverage', not allowed with others")
        if self.coverage is not None and not 0.0 < self.coverage <= 1.0:
            raise ImageOptionError(f"coverage: {self.coverage} given, allowed: greater than 0, up to 1")
        if self.window_pixels is not None and self.method != "local":
            raise ImageOptionError("window_pixels (--window): allowed with the method 'local' only")
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
        Physical quantity, its units and a description of the spectral band; empty if the file does not state them.
    wavelength_um : float or None
        Approximate centre of the band.
    is_nominal : bool
        Whether the pixel size is the nominal one at the sub-satellite point.
    labels : tuple of str
        Label of each frame: time, number or file name.
    seconds : tuple of float or None
        Frame times relative to the first frame; None if unknown.
    method : str
        Cloud detection method, with ``auto`` resolved.
    notes : tuple of str
        Selections made and the reasons for them.
    values, truth : callable
        Functions of the frame number that return its values (rows, columns), NaN where missing, and its cloud mask if
        the file has one.
    kelvin : callable or None
        Converts values to brightness temperatures, NaN where there is none; None if no conversion exists.
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
