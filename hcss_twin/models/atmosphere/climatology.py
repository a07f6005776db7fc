"""Monthly climatology of the sea surface and the air above it, by place and date (COADS, 1946-1989).

Interpolation is linear in time between mid-month values and bilinear in space over cells that have reports. Linear
interpolation flattens the annual extremes by up to a tenth of the seasonal range.
"""

from __future__ import annotations

import math
from calendar import isleap
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import open_format

__all__ = ["Climatology"]

NAME = "COADS 1946-1989"
MAX_DISTANCE_KM = 500.0
"""Maximum distance of the reports used for a place at sea that has none around it."""

LAND_REACH_DEG = 1.0
"""A place is on land if the 1 degree land mask has no sea cell within this distance."""

_MEAN_EARTH_RADIUS_KM = 6371.0
_FORMAT = ("hcss-climatology", 1)


@dataclass(frozen=True)
class Climate:
    """Climatological value at one place and time.

    Attributes
    ----------
    value : float
        In the unit of the quantity.
    distance_km : float
        0 where cells with reports surround the place, otherwise the distance of the nearest cell used.
    """

    value: float
    distance_km: float


class Climatology:
    """Interpolates the built-in climatology, which is read once.

    Parameters
    ----------
    catalog : Catalog
        Locates and records the file, which is opened when first needed.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog

    def look_up(self, quantity: str, latitude_deg: float, longitude_deg: float, time: datetime) -> Climate:
        """Interpolate one quantity, in the unit of the file.

        Parameters
        ----------
        quantity : {"sea_surface_temperature", "air_temperature", "wind_speed", "specific_humidity"}
        latitude_deg, longitude_deg : float
            Degrees north and east; any multiple of 360 may be added to the longitude.
        time : datetime
            With a time zone.

        Raises
        ------
        CatalogError
            If the place is on land, or no report lies within 500 km in one of the two months.
        """
        if not -90.0 <= latitude_deg <= 90.0:
            raise ValueError(f"latitude_deg {latitude_deg}: allowed -90 to 90")
        where = _place(latitude_deg, longitude_deg)
        if self.is_land(latitude_deg, longitude_deg):
            raise CatalogError(f"{where} is on land, and the climatology covers the sea only; give a value")
        months = 12.0 * _year_fraction(time) - 0.5
        month, share = math.floor(months), months - math.floor(months)
        climates = []
        for month_index in (month % 12, (month + 1) % 12):
            climate = self._in_month(quantity, month_index, latitude_deg, longitude_deg)
            if climate is None:
                raise CatalogError(
                    f"the climatology has no {quantity.replace('_', ' ')} within {MAX_DISTANCE_KM:g} km of {where} in "
                    f"month {month_index + 1} (ice, or no ships); give a value"
                )
            climates.append(climate)
        before, after = climates
        value = (1.0 - share) * before.value + share * after.value
        return Climate(value, max(before.distance_km, after.distance_km))

    def is_land(self, latitude_deg: float, longitude_deg: float) -> bool:
        """Whether a place is a degree or more from the sea, according to the 1 degree mask of the file."""
        fields = self._fields
        rows = np.abs(fields["sea_latitude"] - latitude_deg) <= LAND_REACH_DEG + 0.5
        away = np.abs(_turn(fields["sea_longitude"] - longitude_deg))
        return not np.any(fields["sea"][np.ix_(rows, away <= LAND_REACH_DEG + 0.5)])

    def coast_km(self, latitude_deg: float, longitude_deg: float) -> float:
        """Return the distance of a place from land in the 1 degree land mask of the file; 0 on land."""
        fields = self._fields
        distance = _distance_km(fields["sea_latitude"][:, None], fields["sea_longitude"], latitude_deg, longitude_deg)
        half_a_cell = 0.5 * math.radians(1.0) * _MEAN_EARTH_RADIUS_KM
        return max(0.0, float(np.min(distance[fields["sea"] == 0])) - half_a_cell)

    def _in_month(self, quantity: str, month: int, latitude: float, longitude: float) -> Climate | None:
        """Interpolate bilinearly over the surrounding cells with reports; without any, use the nearest cell."""
        fields = self._fields
        values = fields[quantity][month]
        rows, row_weights = _neighbours(fields["latitude"], latitude)
        columns, column_weights = _neighbours(fields["longitude"], longitude, turn=360.0)
        around = values[np.ix_(rows, columns)]
        weights = np.where(np.isfinite(around), np.outer(row_weights, column_weights), 0.0)
        if weights.sum() > 0:
            return Climate(float(np.sum(weights * np.nan_to_num(around)) / weights.sum()), 0.0)
        distance = _distance_km(fields["latitude"][:, None], fields["longitude"], latitude, longitude)
        distance = np.where(np.isfinite(values), distance, np.inf)
        nearest = int(np.argmin(distance))
        if distance.flat[nearest] > MAX_DISTANCE_KM:
            return None
        return Climate(float(values.flat[nearest]), float(distance.flat[nearest]))

    @cached_property
    def _fields(self) -> dict[str, Array]:
        return self._catalog.shelf.parsed(self._catalog.find("coads-monthly", "climatology", ".nc"), read_fields)


def read_fields(path: Path) -> dict[str, Array]:
    """Return the variables of the file, missing values as NaN.

    Raises
    ------
    CatalogError
        If the file cannot be read.
    """
    with open_format(path, *_FORMAT) as dataset:
        fields = {
            name: np.ma.filled(variable[:].astype(np.float64), np.nan) for name, variable in dataset.variables.items()
        }
    for values in fields.values():
        values.flags.writeable = False  # all plans of a catalog share them
    return fields


def _year_fraction(time: datetime) -> float:
    """Return the elapsed fraction of the year, in UTC; 0 to below 1."""
    instant = time.astimezone(UTC)
    start = instant.replace(month=1, day=1, hour=0, minute=0, second=0, microsecond=0)
    days = 366 if isleap(instant.year) else 365
    return (instant - start).total_seconds() / (days * 86_400.0)


def _neighbours(nodes: Array, at: float, turn: float = 0.0) -> tuple[list[int], Array]:
    """Return the indices and weights of the two evenly spaced nodes around a point.

    With ``turn`` the axis is periodic; otherwise the first or last node is used beyond the ends.
    """
    step = float(nodes[1] - nodes[0])
    position = ((at - nodes[0]) % turn if turn else at - nodes[0]) / step
    if not turn:
        position = min(max(position, 0.0), nodes.size - 1.0)
    low = int(position)
    high = (low + 1) % nodes.size if turn else min(low + 1, nodes.size - 1)
    share = position - low
    return [low % nodes.size, high], np.array([1.0 - share, share])


def _turn(degrees: Array) -> Array:
    """Map longitude differences to [-180, 180)."""
    result: Array = (degrees + 180.0) % 360.0 - 180.0
    return result


def _distance_km(latitude: Array, longitude: Array, to_latitude: float, to_longitude: float) -> Array:
    """Return the great-circle distance (haversine formula), broadcast over the first two arguments."""
    north, to_north = np.radians(latitude), math.radians(to_latitude)
    half_height = np.sin((north - to_north) / 2)
    half_width = np.sin(np.radians(longitude - to_longitude) / 2)
    square = half_height**2 + np.cos(north) * math.cos(to_north) * half_width**2
    result: Array = 2 * _MEAN_EARTH_RADIUS_KM * np.arcsin(np.sqrt(np.minimum(square, 1.0)))
    return result


def _place(latitude: float, longitude: float) -> str:
    east = (longitude + 180.0) % 360.0 - 180.0
    return f"{abs(latitude):g} {'N' if latitude >= 0 else 'S'} {abs(east):g} {'E' if east >= 0 else 'W'}"
