"""Images with their time and place from files of SEVIRI, ABI, AHI or others, as ``hcss skies import`` reads them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from hcss_skies.planes import Plane, read_plane

from hcss_follow.analysis import Image
from hcss_twin.core.reading import Reading
from hcss_twin.providers import CatalogError

_TIME = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d(?::\d\d)?)")

_NAMES = {"latitude": ("latitude", "lat", "nav_lat"), "longitude": ("longitude", "lon", "nav_lon")}

GEOSTATIONARY_M, EARTH_M = 42_164_000.0, 6_371_000.0
"""Radius of the geostationary orbit, and of a spherical Earth, from which the view follows within .2 degrees."""


@dataclass(frozen=True)
class ImageSequence:
    """Images of one place.

    Attributes
    ----------
    images : list of Image
    pixel_size_m : float
    latitude, longitude : float
        Of the middle, degrees.
    source, rights : str
    notes : tuple of str
        What the user should know.
    """

    images: list[Image]
    pixel_size_m: float
    latitude: float
    longitude: float
    source: str
    rights: str
    notes: tuple[str, ...]


def named(text: str) -> tuple[Path, str | None]:
    """Return file and variable of ``FILE`` or ``FILE:VARIABLE``."""
    whole = Path(text)
    if whole.exists() or ":" not in text:
        return whole, None
    file, _, variable = text.rpartition(":")
    return Path(file), variable


def read_images(
    texts: Sequence[str], times: Sequence[datetime], second: str | None, at: Mapping[str, int],
    place: tuple[float, float] | None, pixel_size_m: float | None,
) -> ImageSequence:  # fmt: skip
    """Read images in the order of time.

    Parameters
    ----------
    texts : sequence of str
        ``FILE`` or ``FILE:VARIABLE`` of each image.
    times : sequence of datetime
        Of each image; empty: those that the files state.
    second : str, optional
        Image near 12.0 um at the time of the latest image.
    at : mapping of str to int
        Index along dimensions that are not of the image.
    place : (float, float), optional
        Latitude and longitude of the middle; default: those of the file.
    pixel_size_m : float, optional
        Default: that of the file.

    Raises
    ------
    CatalogError
        If a file is no image, or does not say when, where, or how large its pixels are.
    """
    if times and len(times) != len(texts):
        raise CatalogError(f"--time: {len(times)} given; allowed: one for each of the {len(texts)} images, or none")
    read = [(*named(text), read_plane(*named(text), at)) for text in texts]
    of_images: Sequence[datetime | None] = times or [None] * len(read)
    stated = [when or _stated(plane, path) for when, (path, _, plane) in zip(of_images, read, strict=True)]
    order = sorted(range(len(read)), key=lambda n: stated[n])
    latest = read[order[-1]]
    extra = None if second is None else read_plane(*named(second), at).kelvin
    images = [Image(read[n][2].kelvin, stated[n], extra if n == order[-1] else None) for n in order]
    size = pixel_size_m or latest[2].pixel_size_m
    if size is None:
        raise CatalogError(f"{latest[0]}: the pixel size is not known; give it with --pixel-size")
    middle = place or _place(latest[0], latest[2], at)
    notes = tuple(dict.fromkeys(note for _, _, plane in read for note in plane.notes))
    return ImageSequence(images, size, *middle, latest[2].source, latest[2].rights, notes)


def zenith_and_azimuth_deg(latitude: float, longitude: float, satellite_longitude: float) -> tuple[float, float]:
    """Return where a geostationary satellite is seen, on a spherical Earth."""
    lat, lon = math.radians(latitude), math.radians(longitude - satellite_longitude)
    angle = math.acos(math.cos(lat) * math.cos(lon))
    distance = math.sqrt(GEOSTATIONARY_M**2 + EARTH_M**2 - 2.0 * GEOSTATIONARY_M * EARTH_M * math.cos(angle))
    zenith = angle + math.asin(EARTH_M * math.sin(angle) / distance)
    azimuth = math.atan2(-math.sin(lon), -math.sin(lat) * math.cos(lon))
    return math.degrees(zenith), math.degrees(azimuth) % 360.0


def _stated(plane: Plane, path: Path) -> datetime:
    found = _TIME.search(plane.source)
    if found is None:
        raise CatalogError(f"{path}: the file does not state its time; give one for each image with --time")
    return datetime.fromisoformat(f"{found[1]}T{found[2]}").replace(tzinfo=UTC)


def _place(path: Path, plane: Plane, at: Mapping[str, int]) -> tuple[float, float]:
    """Return latitude and longitude of the middle, from coordinates or the attributes of GOES files."""
    asked = CatalogError(f"{path}: the place of the image is not known; give that of its middle with --place LAT LON")
    if not Reading(path, CatalogError).is_netcdf:
        raise asked
    with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as file:
        extent = file.variables.get("geospatial_lat_lon_extent")
        if extent is not None:
            return float(extent.geospatial_lat_center), float(extent.geospatial_lon_center)
        found = [_middle(file, which, at) for which in _NAMES]
    if found[0] is None or found[1] is None:
        raise asked
    return found[0], found[1]


def _middle(file: Any, which: str, at: Mapping[str, int]) -> float | None:
    for name, variable in file.variables.items():
        if name.lower() in _NAMES[which] or str(getattr(variable, "standard_name", "")) == which:
            index = tuple(at.get(dimension, slice(None)) for dimension in variable.dimensions)
            values = np.ma.filled(np.ma.asarray(variable[index], dtype=np.float64), np.nan)
            half = values[tuple(slice((side - 1) // 2, side // 2 + 1) for side in values.shape)]
            return float(np.nanmean(half))
    return None
