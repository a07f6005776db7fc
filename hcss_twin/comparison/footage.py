"""An opened image, several of them, or a cube: frames of one quantity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.comparison.choice import Method

Array = NDArray[np.float64]
KELVIN = ("k", "kelvin")


@dataclass(frozen=True)
class Footage:
    """Frames of one quantity, rows northward and columns eastward.

    Attributes
    ----------
    name : str
        Of the file.
    kind : {"image", "images", "cube"}
    quantity, units : str
        What the values are; units are empty where the file does not say.
    band : str
        Spectral band in words; empty where the file does not say.
    wavelength_um : float or None
        About its middle.
    shape : tuple of int
        Rows and columns.
    pixel_size_m : float or None
    is_nominal : bool
        Whether the pixel size is that below a geostationary satellite.
    labels : tuple of str
        Of the frames: time, number or file.
    seconds : tuple of float or None
        Times of the frames after the first; None where they are not known.
    bright_is_cloud : bool
    method : str
        How cloud is found, ``auto`` resolved.
    notes : tuple of str
        What was chosen and why.
    values : callable
        Number of a frame to its values (rows, columns), NaN where missing.
    truth : callable or None
        Number of a frame to its cloud mask (rows, columns), where the file has one.
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
