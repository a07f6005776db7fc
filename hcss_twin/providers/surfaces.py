"""Surfaces: a map over the ground of sea, land, ice and other classes, and their temperatures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.clouds import Grid
from hcss_twin.providers.declarations import Declaration
from hcss_twin.providers.sea import SeaModel


@dataclass(frozen=True)
class SurfaceInputs:
    """Inputs of a surface provider.

    Attributes
    ----------
    grid : Grid
        The image plane, in points: ``image.samples_per_pixel`` along each side of a pixel.
    ground : callable
        Maps time_s, rows and columns, as of :meth:`SurfaceProvider.surface`, to latitude and longitude (y, x) of the
        points, degrees; the platform may move them.
    sea_temperature_K, air_temperature_K : float
        Of the scenario's sea, and of the air at the surface.
    catalog : Catalog
        Reader of data files.
    """

    grid: Grid
    ground: Callable[[float, slice, slice], tuple[Array, Array]]
    sea_temperature_K: float
    air_temperature_K: float
    catalog: Catalog


@dataclass(frozen=True)
class SurfaceClass:
    """One class of a surface.

    Attributes
    ----------
    name : str
        Lower-case letters, digits and underscores. ``sea`` is the scenario's sea, with its model, glint and waves.
    temperature_K : float or (float, float), optional
        The same everywhere, or the lowest and highest of a field, for which the map gives a temperature of every point.
        Default: that of the scenario's sea, or of the air at the surface for other classes.
    boundary : SeaModel, optional
        Emissivity and BRDF of the surface, in the form of a sea model; not for ``sea``. Default: a Lambertian surface
        with the published emissivity of ``name``: land, vegetation, forest, tundra, soil, sand, rock, snow or ice.
    """

    name: str
    temperature_K: float | tuple[float, float] | None = None
    boundary: SeaModel | None = None


@dataclass(frozen=True)
class SurfaceMap:
    """Surface at the points of a window.

    Attributes
    ----------
    number : ndarray of int (y, x)
        Class of each point, from 0 in the order of ``classes``.
    temperature_K : ndarray (y, x), optional
        Needed where a class has a field of temperature; elsewhere of no effect, and may be NaN.
    """

    number: NDArray[np.integer]
    temperature_K: Array | None = None


@runtime_checkable
class SurfaceProvider(Protocol):
    """Map of the ground below the clouds.

    Attributes
    ----------
    classes : tuple of SurfaceClass
        One to 12 classes.
    """

    declares: Declaration
    classes: tuple[SurfaceClass, ...]

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return the surface in a window of ``inputs.grid``, ``time_s`` after the start.

        Both slices have start and stop, and may lie outside the image. A point's values must not depend on the window.
        """
        ...
