"""The map projection of a cube, as the formats write it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hcss_twin.providers import CubeError

if TYPE_CHECKING:
    import xarray as xr

WGS84_SEMI_MAJOR_M = 6378137.0
WGS84_INVERSE_FLATTENING = 298.257223563


@dataclass(frozen=True)
class Projection:
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


def projection_of(dataset: xr.Dataset, data: xr.DataArray) -> Projection | None:
    """Return the projection of the x and y of a variable of an open cube, to place its pixels on Earth.

    None for an image that is no grid on the ground: variables of its cube have the place of each pixel.

    Raises
    ------
    CubeError
        If the cube has no grid mapping of the variable, or another projection.
    """
    if "row" in dataset.dims:
        return None
    # coordinates, such as the latitude of each pixel, have no attribute grid_mapping
    mapping = data.encoding.get("grid_mapping", data.attrs.get("grid_mapping", "local_plane"))
    if mapping not in dataset.variables:
        raise CubeError(f"{data.name}: the cube has no grid mapping '{mapping}'")
    return projection_of_mapping(dataset[mapping].attrs)


def projection_of_mapping(attributes: Mapping[str, Any]) -> Projection:
    """Return the projection that a CF grid mapping describes.

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
        return Projection(*origin, number("earth_radius"), 0.0)
    return Projection(*origin, number("semi_major_axis"), number("inverse_flattening"))
