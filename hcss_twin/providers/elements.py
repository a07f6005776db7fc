"""Elements: things in the scene besides clouds and sea, from the surface to above the clouds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.clouds import Grid
from hcss_twin.providers.column_states import Sun, View
from hcss_twin.providers.declarations import Declaration
from hcss_twin.providers.sensor import SensorBand


@dataclass(frozen=True)
class ElementInputs:
    """Inputs of an element provider.

    Attributes
    ----------
    bands : tuple of SensorBand (B,)
        Bands of the scene.
    grid : Grid
        The image plane, in pixels.
    view : View
        Direction from the image centre to the sensor.
    black_body : callable
        Maps a temperature in K to the radiance (B,) of a black body in each band, W m-2 sr-1.
    catalog : Catalog
        Reader of data files.
    latitude_deg, longitude_deg : float
        Of the image centre at the start.
    """

    bands: tuple[SensorBand, ...]
    grid: Grid
    view: View
    black_body: Callable[[float], Array]
    catalog: Catalog
    latitude_deg: float = 0.0
    longitude_deg: float = 0.0

    def to_plane(self, latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Array]:
        """Return x and y (N,) in m east and north of the image centre at the start, of geodetic places on WGS 84.

        Raises
        ------
        ValueError
            If a place is 60 degrees or more away.
        """
        from hcss_twin.physics.geodesy import Ellipsoid

        return Ellipsoid.to_plane(latitude_deg, longitude_deg, self.latitude_deg, self.longitude_deg)


@dataclass(frozen=True)
class SightPath:
    """What is between a point and the sensor.

    Attributes
    ----------
    transmittance : ndarray (B,)
        Of the air on the whole path to the sensor, 0 to 1, mean over each band weighted with its response.
    path_radiance : ndarray (B,)
        Of this air, W m-2 sr-1.
    cloud_transmission : ndarray (B,)
        Direct transmission of the clouds above the point along its own line of sight, 0 to 1.
    """

    transmittance: Array
    path_radiance: Array
    cloud_transmission: Array


@dataclass(frozen=True)
class ElementPixels:
    """Pixels of a window that an extended element, or a part of it at one altitude, covers.

    Give ``radiance`` for an element that hides what is behind it, or ``intensity`` for light that hides nothing. The
    engine attenuates both by the air and the clouds above the altitude, in each pixel by its own. What is smaller than
    a few pixels is an :class:`ElementPoint`.

    Attributes
    ----------
    rows, columns : ndarray of int (N,)
        Distinct pixels of the window, numbered as in the image.
    share : ndarray (N,)
        Above 0, to 1: share of the pixel that the element covers; for an unresolved source, share of its energy in the
        pixel. These sum to 1 over the plane.
    altitude_m : float
        Above the sea, 0 or more.
    radiance : ndarray (B,) or (N, B), optional
        Radiance that leaves the covered part toward the sensor, W m-2 sr-1.
    intensity : ndarray (B,), optional
        Radiant intensity of the whole source toward the sensor, W sr-1. The engine divides it by the pixel's area
        projected on the plane normal to the line of sight, pixel_size_m^2 cos(view zenith).
    temperature_K : float, optional
        Of a black body with a similar spectrum, as weight of the transmittance within a band; None: radiance that is
        constant per wavenumber.
    truth : mapping of str to ndarray (N,)
        Values of the provider's ``variables``.
    """

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    share: Array
    altitude_m: float
    radiance: Array | None = None
    intensity: Array | None = None
    temperature_K: float | None = None
    truth: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class ElementPoint:
    """An element smaller than a few pixels, which the engine draws: a plume, or a body that hides what is behind it.

    Air and clouds weaken it at its own place. Cubes show it in the pixel that holds it, sensors through their point
    spread at its place within the pixel, smeared by its motion against the image. A body whose area is larger than a
    pixel is a square.

    Attributes
    ----------
    x_m, y_m, altitude_m : float
        East and north of the image centre at the start, and above the sea, 0 or more.
    intensity : ndarray (B,), optional
        Of a plume: radiant intensity toward the sensor, W sr-1. It hides nothing.
    radiance : ndarray (B,), optional
        Of a body: radiance that it emits toward the sensor, W m-2 sr-1.
    area_m2 : float, optional
        Of a body: its area across the line of sight.
    reflectance : float
        Of a body, 0 to 1: the engine adds the sunlight and thermal sky that it reflects as a horizontal diffuser.
    velocity_m_s : (float, float, float)
        Toward east, north and up.
    side_m : float
        Side of the square over which the engine spreads it evenly; 0: none.
    temperature_K : float, optional
        As in :class:`ElementPixels`.
    truth : mapping of str to float
        Values of the provider's ``variables``.
    """

    x_m: float
    y_m: float
    altitude_m: float
    intensity: Array | None = None
    radiance: Array | None = None
    area_m2: float | None = None
    reflectance: float = 0.0
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    side_m: float = 0.0
    temperature_K: float | None = None
    truth: Mapping[str, float] = field(default_factory=dict)


class ElementScene(Protocol):
    """The scene around an element at one instant.

    Attributes
    ----------
    sun : Sun or None
        None below the horizon or if sunlight does not matter.
    random : numpy.random.Generator
        Of this element and frame, in the same state for every window and instant: draw the numbers of the
        whole frame.
    """

    sun: Sun | None
    random: np.random.Generator

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return where points appear in the image, as row and column (N,); pixel n extends from n to n + 1.

        ``x_m`` and ``y_m`` (N,) are metres east and north of the image centre at the start. Altitude displaces points
        only in scenes with ``slant.parallax``, as it does clouds.
        """
        ...

    def path(self, x_m: float, y_m: float, altitude_m: float) -> SightPath:
        """Return what is between a point that appears in the image and the sensor."""
        ...


@runtime_checkable
class ElementProvider(Protocol):
    """Things in the scene besides clouds and sea.

    Attributes
    ----------
    variables : mapping of str to (str, str)
        Units and description of truth variables, by names of lower-case letters, digits and underscores; an attribute
        of the class. The cube has them as ``element_NAME``, NaN where there is no element.
    """

    declares: Declaration
    variables: Mapping[str, tuple[str, str]]

    def pixels(
        self, time_s: float, rows: slice, columns: slice, scene: ElementScene
    ) -> Sequence[ElementPixels | ElementPoint]:
        """Return what appears in a window, ``time_s`` after the start; empty: nothing.

        Both slices have start and stop, and may lie outside the image. A pixel's values must not depend on the window;
        points may lie outside it. Higher parts hide lower ones.
        """
        ...
