"""Map coordinates of the pixels of a frame, for export formats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError

WGS84_SEMI_MAJOR_M = 6378137.0
WGS84_INVERSE_FLATTENING = 298.257223563

_EVEN = 1e-6
"""Largest deviation of a coordinate from even spacing, in steps."""


@dataclass(frozen=True)
class LocalPlane:
    """Azimuthal equidistant projection about the image centre at the start: the cube's CF grid mapping.

    Attributes
    ----------
    latitude, longitude : float
        Origin, degrees.
    semi_major_m : float
        Equatorial radius.
    inverse_flattening : float
        0: a sphere.
    """

    latitude: float
    longitude: float
    semi_major_m: float
    inverse_flattening: float

    @property
    def is_wgs84(self) -> bool:
        """Whether the ellipsoid is WGS 84."""
        return self.semi_major_m == WGS84_SEMI_MAJOR_M and self.inverse_flattening == WGS84_INVERSE_FLATTENING

    @property
    def proj_text(self) -> str:
        """Coordinate system as a PROJ string."""
        figure = (
            "+datum=WGS84"
            if self.is_wgs84
            else f"+R={self.semi_major_m!r}"
            if self.inverse_flattening == 0.0
            else f"+a={self.semi_major_m!r} +rf={self.inverse_flattening!r}"
        )
        return f"+proj=aeqd +lat_0={self.latitude!r} +lon_0={self.longitude!r} {figure} +units=m +no_defs"

    @property
    def esri_wkt(self) -> str:
        """Well-known text in the ESRI dialect, which ENVI and GDAL read."""
        figure, datum, system = (
            ("WGS_1984", "D_WGS_1984", "GCS_WGS_1984")
            if self.is_wgs84
            else ("Sphere", "D_Sphere", "GCS_Sphere")
            if self.inverse_flattening == 0.0
            else ("Ellipsoid", "D_Ellipsoid", "GCS_Ellipsoid")
        )
        return (
            f'PROJCS["Local_Plane",GEOGCS["{system}",DATUM["{datum}",'
            f'SPHEROID["{figure}",{self.semi_major_m!r},{self.inverse_flattening!r}]],'
            'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],'
            'PROJECTION["Azimuthal_Equidistant"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],'
            f'PARAMETER["Central_Meridian",{self.longitude!r}],PARAMETER["Latitude_Of_Origin",{self.latitude!r}],'
            'UNIT["Meter",1.0]]'
        )


@dataclass(frozen=True)
class PixelGrid:
    """Pixel centres of a frame in the local plane; rows grow north and columns east.

    Attributes
    ----------
    west_m, south_m : float
        Centre of the first pixel of the first row, relative to the centre of the frame.
    step_x_m, step_y_m : float
        Width and height of a pixel.
    plane : LocalPlane
        Plane of x and y for a frame with zero platform displacement.
    """

    west_m: float
    south_m: float
    step_x_m: float
    step_y_m: float
    plane: LocalPlane


def local_plane(attributes: Mapping[str, Any]) -> LocalPlane:
    """Return the plane that a CF grid mapping describes.

    Raises
    ------
    CubeError
        If it is another projection, or defines no ellipsoid.
    """
    name = attributes.get("grid_mapping_name")
    if name != "azimuthal_equidistant":
        raise CubeError(f"grid_mapping_name: '{name}'; allowed: 'azimuthal_equidistant'")

    def number(key: str) -> float:
        try:
            return float(attributes[key])
        except KeyError:
            raise CubeError(f"the grid mapping lacks '{key}'") from None
        except (TypeError, ValueError):
            raise CubeError(f"{key}: {attributes[key]!r} in the grid mapping; allowed: a number") from None

    origin = number("latitude_of_projection_origin"), number("longitude_of_projection_origin")
    if "earth_radius" in attributes:
        return LocalPlane(*origin, number("earth_radius"), 0.0)
    return LocalPlane(*origin, number("semi_major_axis"), number("inverse_flattening"))


def axis(name: str, centres_m: NDArray[np.float64], fallback_m: float | None) -> tuple[float, float]:
    """Return first value and step of a coordinate.

    Parameters
    ----------
    name : str
        For messages.
    centres_m : ndarray (N,)
    fallback_m : float or None
        Step for a single pixel.

    Raises
    ------
    CubeError
        If steps are uneven or not positive, or the step of a single pixel is unknown.
    """
    if centres_m.size == 1:
        if fallback_m is None:
            raise CubeError(f"{name} has one value, which does not determine the size of a pixel")
        return float(centres_m[0]), fallback_m
    step = float(centres_m[-1] - centres_m[0]) / (centres_m.size - 1)
    if not step > 0.0:
        raise CubeError(f"{name} does not increase with the pixel number; in a cube it does")
    even = centres_m[0] + step * np.arange(centres_m.size)
    if np.max(np.abs(centres_m - even)) > _EVEN * step:
        raise CubeError(f"{name} has uneven steps; those of a cube are even")
    return float(centres_m[0]), step
