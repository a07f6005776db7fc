"""Sensors: measurement of the radiance at the sensor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.providers.clouds import Grid
from hcss_twin.providers.declarations import Declaration


@dataclass(frozen=True)
class SensorBand:
    """One spectral band of the frames.

    Attributes
    ----------
    name : str
        Name in the cube.
    wavelength_um : ndarray (N,)
        Ascending wavelengths of the response; linear between them, 0 outside.
    response : ndarray (N,)
        Relative response, 0 to 1. Band radiance is the integral over wavelength of spectral radiance times response.
    """

    name: str
    wavelength_um: Array
    response: Array


def no_scene(time_s: float, rows: slice, columns: slice) -> Array:
    """Refuse to give the scene at other instants."""
    raise ProviderError("scene_at: the scene at other instants is not known here")


@dataclass(frozen=True)
class SensorInputs:
    """Inputs of a sensor.

    Attributes
    ----------
    bands : tuple of SensorBand (B,)
        Bands in the order of the frames' first axis.
    grid : Grid
        The frames: rows, columns, and side of the square ground pixel.
    platform_speed_m_s : float
        Speed of the image's ground footprint in +x (columns).
    frame_interval_s : float
        Time between frames.
    seed : int
        0 to below 2^63. All random numbers derive from it.
    catalog : Catalog
        Reader of data files.
    corner : (int, int)
        Row and column of the frames' first pixel in the whole image, possibly negative. Random numbers depend on the
        row and column in the image.
    scene_at : callable
        ``scene_at(time_s, rows, columns)`` returns the radiance (B, rows, columns), W m-2 sr-1, that this sensor
        receives at another time, in s from the scenario's start, in a window of the frame; for a later stage of a
        chain as the stages before it measure it. Only during ``measure``, and only for a sensor with ``instants``.
    """

    bands: tuple[SensorBand, ...]
    grid: Grid
    platform_speed_m_s: float
    frame_interval_s: float
    seed: int
    catalog: Catalog
    corner: tuple[int, int] = (0, 0)
    scene_at: Callable[[float, slice, slice], Array] = field(default_factory=lambda: no_scene)


@dataclass(frozen=True)
class Points:
    """Elements smaller than a few pixels, given apart from the radiance of a frame, so that a sensor can draw them.

    Attributes
    ----------
    row, column : ndarray (N,)
        Places at the time of the frame, in rows and columns of the frame: pixel n extends from n to n + 1. They may lie
        outside.
    row_rate, column_rate : ndarray (N,)
        Motion against the frame, rows and columns per second.
    radiance : ndarray (B, N)
        What each adds to the radiance of a pixel that gets all of its light, W m-2 sr-1; negative for what is darker
        than its background.
    """

    row: Array
    column: Array
    row_rate: Array
    column_rate: Array
    radiance: Array

    def in_pixels(self, rows: int, columns: int) -> Array:
        """Return what they add to the pixels (B, rows, columns) that hold them."""
        added = np.zeros((len(self.radiance), rows, columns))
        y, x = np.floor(self.row).astype(np.intp), np.floor(self.column).astype(np.intp)
        inside = (y >= 0) & (y < rows) & (x >= 0) & (x < columns)
        for pixels, light in zip(added, self.radiance, strict=True):
            np.add.at(pixels.reshape(-1), y[inside] * columns + x[inside], light[inside])
        return added


@dataclass(frozen=True)
class Measured:
    """Measurement of one frame; None: not measured.

    Attributes
    ----------
    radiance : ndarray (B, y, x)
        Band radiance as measured, W m-2 sr-1; noise may make it negative.
    photon_rate : ndarray (B, y, x) or None
        Photons of the scene on each pixel's detector, before noise, s-1.
    digital_number : ndarray (B, y, x) of integers or None
        Output of the converter, 0 or more and below 2^31.
    saturated : ndarray (B, y, x) of integers or None
        0: within range; 1: cut at the upper end; 2: cut at the lower end of the digital numbers.
    """

    radiance: Array
    photon_rate: Array | None = None
    digital_number: NDArray[np.int32] | None = None
    saturated: NDArray[np.uint8] | None = None


@dataclass(frozen=True, kw_only=True)
class SensorDeclaration(Declaration):
    """What a sensor declares, besides notes and its own errors.

    Attributes
    ----------
    reach_pixels : int or None
        Largest distance in rows or columns at which one pixel affects another; 0: none, None: the whole frame. The
        engine computes so much of the scene around the frames.
    remembers : bool
        Whether measurements depend on earlier frames, so that a sensor needs all of them in order.
    """

    reach_pixels: int | None = 0
    remembers: bool = False


@runtime_checkable
class Sensor(Protocol):
    """Turns clean frames into measured ones.

    Attributes
    ----------
    variables : tuple of str
        Measurements in addition to radiance, among ``photon_rate``, ``digital_number``, ``saturated``.
    """

    declares: SensorDeclaration
    variables: tuple[str, ...]

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the measurement of ``radiance`` (B, y, x), W m-2 sr-1 at the sensor.

        ``frame`` is the number of the frame and ``time_s`` its time, both from the scenario's start. Frames may come in
        any order and several at once, unless ``declares.remembers``. A band's result does not depend on other bands.
        """
        ...


class SensorOptions(Protocol):
    """Optional members of a sensor.

    Attributes
    ----------
    worked_out : mapping of str to anything JSON has
        Derived numbers that a user would check first; written into the cube.
    single_precision : bool
        Whether ``measure`` takes and returns radiance and photon rates as float32, which is faster; false by default.
    instants : (float, float)
        Earliest and latest time at which it calls ``inputs.scene_at``, in s from the time of the frame, such as
        (-0.01, 0.01) for integration around it. Such a sensor measures in a run, not a finished cube.
    """

    worked_out: Mapping[str, Any]
    single_precision: bool
    instants: tuple[float, float]

    def measure_with(self, radiance: Array, points: Points, frame: int, time_s: float) -> Measured:
        """Return the measurement of a frame whose small elements are given apart, and drawn by this sensor.

        Without this method and ``points_after``, they are in the radiance of the pixels that hold them.
        """
        ...

    def points_after(self, points: Points) -> Points:
        """Return the small elements as later stages get them, for a sensor that does not draw them.

        ``measure`` and ``scene_at`` then have the radiance without them.
        """
        ...
