"""Clear sea and opaque clouds in measured images, with their place, time and view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from hcss_twin import CatalogError
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array

BOX = 64
"""Side of a box of clear sea or cloud, pixels."""

_UNIFORM_K, _CLOUD_UNIFORM_K = 0.35, 1.0
"""Largest standard deviation of 3 x 3 pixels of clear sea, and of opaque cloud."""

_CLEAR_RANGE_K, _COLDER_K = 1.5, 40.0
"""How much colder than the warmest uniform pixels clear sea may be, and how much colder opaque clouds are."""

_FEWEST_CLEAR, _FEWEST_OPAQUE = 100, 20

NAMES = "latitude", "longitude", "view_zenith"


@dataclass(frozen=True)
class Spot:
    """Mean of similar pixels of one image.

    Attributes
    ----------
    kind : str
        "clear sea" or "opaque cloud".
    kelvin : dict of str to float
        Brightness temperature by channel.
    latitude, longitude, view_zenith : float
        Degrees.
    time : datetime
    pixels : int
    clear_K : float
        Of the clear sea nearby in the reference channel.
    """

    kind: str
    kelvin: dict[str, float]
    latitude: float
    longitude: float
    view_zenith: float
    time: datetime
    pixels: int
    clear_K: float


def read_spots(path: Path, channels: Sequence[str], reference: str) -> list[Spot]:
    """Return a spot of clear sea and one of opaque cloud of each image, where it has them.

    Parameters
    ----------
    path : Path
        NetCDF. The last two dimensions of channels (K) are those of images; ``latitude``, ``longitude`` and
        ``view_zenith`` (degrees) have some of the channels' dimensions; ``time`` is one of them, or a scalar.
    channels : sequence of str
        Variables.
    reference : str
        The one near 10.8 um, in which spots are chosen.

    Raises
    ------
    CatalogError
        If a variable is missing, or dimensions do not fit.
    """
    with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as file:
        for name in (*channels, *NAMES, "time"):
            if name not in file.variables:
                raise CatalogError(f"{path}: no variable '{name}'; needed: {', '.join((*channels, *NAMES, 'time'))}")
        dimensions = file[reference].dimensions
        sizes = dict(zip(dimensions, file[reference].shape, strict=True))
        values = {name: _filled(file[name]) for name in (*channels, *NAMES)}
        wrong = [name for name in channels if file[name].dimensions != dimensions]
        wrong += [name for name in NAMES if not set(file[name].dimensions) <= set(dimensions)]
        if wrong or len(dimensions) < 2:
            raise CatalogError(f"{path}: {wrong or reference} must have the dimensions {dimensions} or, places, some")
        dimensions_of = {name: file[name].dimensions for name in (*channels, *NAMES)}
        times = _times(file)
    spots = []
    for index in product(*(range(sizes[name]) for name in dimensions[:-2])):
        at = dict(zip(dimensions[:-2], index, strict=True))
        image = {name: _part(values[name], dimensions_of[name], at, dimensions[-2:], sizes) for name in values}
        spots += _of_image(image, channels, reference, times[at.get("time", 0) if len(times) > 1 else 0])
    return spots


def _filled(variable: Any) -> Array:
    return np.ma.filled(np.ma.asarray(variable[...]).astype(np.float64), np.nan)


def _times(file: Any) -> list[datetime]:
    import netCDF4

    item = file["time"]
    found: Any = netCDF4.num2date(np.atleast_1d(item[...]), item.units, only_use_cftime_datetimes=False)
    return [datetime.fromisoformat(str(text)).replace(tzinfo=UTC) for text in found]


def _part(
    values: Array, dimensions: tuple[str, ...], at: Mapping[str, int], last: tuple[str, ...], sizes: Mapping[str, int]
) -> Array:
    """Return the values (rows, columns) of one image."""
    part = values[tuple(at[name] if name in at else slice(None) for name in dimensions)]
    kept = [name for name in dimensions if name not in at]
    shape = [sizes[name] if name in kept else 1 for name in last]
    return np.broadcast_to(part.reshape(shape), [sizes[name] for name in last])


def _of_image(image: dict[str, Array], channels: Sequence[str], reference: str, time: datetime) -> list[Spot]:
    kelvin = image[reference]
    known = np.all([np.isfinite(image[name]) for name in channels], axis=0)
    if known.sum() < _FEWEST_CLEAR:
        return []
    smooth = np.where(np.isfinite(kelvin), kelvin, np.nanmean(kelvin))
    spread = np.sqrt(np.maximum(uniform_filter(smooth**2, 3) - uniform_filter(smooth, 3) ** 2, 0.0))
    uniform = known & (spread < _UNIFORM_K)
    if uniform.sum() < _FEWEST_CLEAR:
        return []
    warmest = float(np.percentile(kelvin[uniform], 98.0))
    clear = uniform & (kelvin > warmest - _CLEAR_RANGE_K)
    opaque = known & (spread < _CLOUD_UNIFORM_K) & (kelvin < warmest - _COLDER_K)
    if opaque.any():
        opaque &= kelvin < np.percentile(kelvin[opaque], 25.0)
    spots = []
    for kind, mask, fewest in (("clear sea", clear, _FEWEST_CLEAR), ("opaque cloud", opaque, _FEWEST_OPAQUE)):
        inside = _densest(mask)
        if inside.sum() >= fewest:
            means = {name: float(image[name][inside].mean()) for name in (*channels, *NAMES)}
            latitude, longitude, view_zenith = (means.pop(name) for name in NAMES)
            spots.append(Spot(kind, means, latitude, longitude, view_zenith, time, int(inside.sum()), warmest))
    return spots


def _densest(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the true pixels of the box that has most of them."""
    rows, columns = (range(0, max(1, size - BOX // 2), BOX // 2) for size in mask.shape)
    boxes = [np.s_[row : row + BOX, column : column + BOX] for row in rows for column in columns]
    best = max(boxes, key=lambda box: int(mask[box].sum()))
    result = np.zeros_like(mask)
    result[best] = mask[best]
    return result
