"""Where the pixels of an image are: latitudes and longitudes give its pixel size, and what comes first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geodesy import MEAN_EARTH_RADIUS_M

UNEVEN = 0.1
"""Relative difference of the sides of a pixel beyond which it is told that it counts as a square of the same area."""

_NAMES = {"latitude": ("latitude", "lat", "nav_lat"), "longitude": ("longitude", "lon", "nav_lon")}


@dataclass(frozen=True)
class Located:
    """Size of the pixels of an image, and how it lies.

    Attributes
    ----------
    size_m : float
        Side of a square of the median area.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost.
    notes : tuple of str
        Sides that differ.
    """

    size_m: float
    north_first: bool
    east_first: bool
    notes: tuple[str, ...]


def located(dataset: Any, variable: Any, names: Sequence[str], chosen: Mapping[str, int]) -> Located | None:
    """Return where the pixels of one image of a NetCDF variable are; None without latitude and longitude in degrees.

    Parameters
    ----------
    names : sequence of str (2,)
        Dimensions of its rows and columns.
    chosen : mapping of str to int
        Index of the image along each other dimension.
    """
    found = [_coordinate(dataset, variable, which, names, chosen) for which in _NAMES]
    if found[0] is None or found[1] is None:
        return None
    rows, columns = (dataset.dimensions[name].size for name in names)
    latitude, longitude = (np.broadcast_to(degrees, (rows, columns)) for degrees in found if degrees is not None)
    steps = [(np.diff(latitude, axis=axis), _eastward(np.diff(longitude, axis=axis))) for axis in (0, 1)]
    sides = []
    for axis, (north, east) in enumerate(steps):
        middle = np.radians(latitude[:-1] if axis == 0 else latitude[:, :-1])
        lengths = np.hypot(np.radians(north), np.cos(middle) * np.radians(east))
        if not np.any(np.isfinite(lengths)):
            return None
        sides.append(MEAN_EARTH_RADIUS_M * float(np.nanmedian(lengths)))
    tall, wide = sides
    if not (tall > 0.0 and wide > 0.0):
        return None
    notes: tuple[str, ...] = ()
    if max(sides) > (1.0 + UNEVEN) * min(sides):
        notes = (f"Pixels of {tall:.4g} m (rows) x {wide:.4g} m are taken for squares of the same area.",)
    return Located(
        float(np.sqrt(tall * wide)), bool(np.nanmean(steps[0][0]) < 0.0), bool(np.nanmean(steps[1][1]) < 0.0), notes
    )


def _eastward(steps_deg: Array) -> Array:
    """Return differences of longitude from -180 to 180: an image may lie across the date line."""
    return (steps_deg + 180.0) % 360.0 - 180.0


def _coordinate(
    dataset: Any, variable: Any, which: str, names: Sequence[str], chosen: Mapping[str, int]
) -> Array | None:
    """Return latitude or longitude (rows, columns), of which one may have the length 1; None if there is none."""
    listed = str(getattr(variable, "coordinates", "")).split()
    for label, item in dataset.variables.items():
        unit = str(getattr(item, "units", "degrees"))
        named = str(getattr(item, "standard_name", "")) == which or label.lower() in _NAMES[which]
        if not (named or (label in listed and label.lower().startswith(which[:3]))) or not unit.startswith("degree"):
            continue
        others = [dimension for dimension in item.dimensions if dimension not in (*names, *chosen)]
        if any(dataset.dimensions[dimension].size > 1 for dimension in others):
            continue
        index = tuple(slice(None) if dimension in names else chosen.get(dimension, 0) for dimension in item.dimensions)
        values = np.ma.filled(np.ma.asarray(item[index]).astype(np.float64), np.nan)
        kept = [dimension for dimension in item.dimensions if dimension in names]
        if not kept:
            continue
        if kept == [names[1], names[0]]:
            values = values.T
        return values if len(kept) == 2 else values[:, None] if kept == [names[0]] else values[None, :]
    return None
