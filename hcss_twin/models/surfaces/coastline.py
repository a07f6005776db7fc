"""Surface provider ``coast``: land and sea by coastlines, which are polygons.

A point lies on land if a line from it toward the east crosses the rings an odd number of times. An edge is crossed if
one of its ends is above the point's latitude and the other is not, so that no vertex counts twice; edges are straight
in latitude and longitude. The result for a point does not depend on the other points of a call.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.models.surfaces.parameters import CoastParameters
from hcss_twin.providers import Declaration, SurfaceClass, SurfaceInputs, SurfaceMap

_STRIPS = 512
"""Strips of latitude in which edges are looked up."""


@dataclass(frozen=True)
class Coastline:
    """Closed rings of land; a ring within another one is water.

    Attributes
    ----------
    longitude, latitude : ndarray (N,)
        Vertices of all rings, degrees, longitudes from -180 to 180; rings that cross 180 degrees are cut there.
    start : ndarray of int (R + 1,)
        First vertex of each ring, and N.
    """

    longitude: Array
    latitude: Array
    start: NDArray[np.int64]

    @classmethod
    def read(cls, path: Path) -> Coastline:
        """Read ``catalogs/surfaces/coastline.npz`` (``catalogs/recipes/coastline.py``)."""
        with np.load(path) as file:
            west, across, south, up = file["grid"]
            longitude = west + across * np.cumsum(file["longitude_steps"], dtype=np.int64)
            latitude = south + up * np.cumsum(file["latitude_steps"], dtype=np.int64)
            start = np.concatenate(([0], np.cumsum(file["vertices"], dtype=np.int64)))
        return cls(longitude, latitude, start)

    def is_land(self, latitude: Array, longitude: Array) -> NDArray[np.bool_]:
        """Return whether points lie on land.

        Parameters
        ----------
        latitude, longitude : ndarray (...)
            Degrees; any longitude.
        """
        y = np.ravel(latitude).astype(np.float64)
        x = np.mod(np.ravel(longitude).astype(np.float64) + 180.0, 360.0) - 180.0
        if not y.size:
            return np.zeros(np.shape(latitude), dtype=np.bool_)
        low, high = float(y.min()), float(y.max())
        edges = self._edges(low, high, float(x.min()), float(x.max()))
        first, number = _by_strip(edges, low, high)
        return np.asarray(_is_inside(y, x, *edges, first, number, low, high)).reshape(np.shape(latitude))

    def _edges(self, south: float, north: float, west: float, east: float) -> tuple[Array, Array, Array, Array]:
        """Return the edges (E,) that a line toward the east can cross: x0, y0, x1, y1.

        A ring entirely west of all points is not met; one entirely east of them is crossed an even number of times.
        """
        ends = self.start[:-1]
        low_y, high_y = np.minimum.reduceat(self.latitude, ends), np.maximum.reduceat(self.latitude, ends)
        low_x, high_x = np.minimum.reduceat(self.longitude, ends), np.maximum.reduceat(self.longitude, ends)
        near = (low_y <= north) & (high_y >= south) & (low_x <= east) & (high_x >= west)
        pieces = [np.empty((0, 4))]
        for ring in np.flatnonzero(near).tolist():
            points = slice(self.start[ring], self.start[ring + 1])
            x, y = self.longitude[points], self.latitude[points]
            after_x, after_y = np.roll(x, -1), np.roll(y, -1)
            met = (
                (np.minimum(y, after_y) <= north) & (np.maximum(y, after_y) >= south) & (np.maximum(x, after_x) > west)
            )
            pieces.append(np.stack((x, y, after_x, after_y), axis=1)[met])
        x0, y0, x1, y1 = np.ascontiguousarray(np.concatenate(pieces).T)
        return x0, y0, x1, y1


def _by_strip(
    edges: tuple[Array, Array, Array, Array], south: float, north: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the edges by strip of latitude: the first place (S + 1,) of each strip among the edges' numbers."""
    _, y0, _, y1 = edges
    low = _strip(np.minimum(y0, y1), south, north)
    count = _strip(np.maximum(y0, y1), south, north) - low + 1
    number = np.repeat(np.arange(y0.size), count)
    strip = np.repeat(low, count) + np.arange(number.size) - np.repeat(np.cumsum(count) - count, count)
    order = np.argsort(strip, kind="stable")
    return np.searchsorted(strip[order], np.arange(_STRIPS + 1)), number[order]


def _strip(latitude: Array, south: float, north: float) -> NDArray[np.int64]:
    position = (latitude - south) * (_STRIPS / max(north - south, 1e-12))
    strip: NDArray[np.int64] = np.clip(position, 0.0, _STRIPS - 1.0).astype(np.int64)
    return strip


@kernel()
def _is_inside(y, x, x0, y0, x1, y1, first, number, south, north):  # type: ignore[no-untyped-def]
    inside = np.zeros(y.size, dtype=np.bool_)
    scale = first.size - 1
    per_degree = scale / max(north - south, 1e-12)
    for n in range(y.size):
        strip = int(min(max((y[n] - south) * per_degree, 0.0), scale - 1.0))
        odd = False
        for position in range(first[strip], first[strip + 1]):
            edge = number[position]
            if (y0[edge] > y[n]) != (y1[edge] > y[n]):
                along = (y[n] - y0[edge]) / (y1[edge] - y0[edge])
                if x0[edge] + along * (x1[edge] - x0[edge]) > x[n]:
                    odd = not odd
        inside[n] = odd
    return inside


class Coast:
    """Land of one class, and sea.

    Parameters
    ----------
    inputs : SurfaceInputs
    parameters : CoastParameters
    """

    declares = Declaration(
        notes=(
            "coast: coastlines of Natural Earth, 1:10 million, true to about 1 km; lakes are land, and islands smaller "
            "than about 1 km are missing",
        )
    )

    def __init__(self, inputs: SurfaceInputs, parameters: CoastParameters) -> None:
        self._inputs = inputs
        path = inputs.catalog.find("coastline", "surfaces", ".npz")
        self._coastline: Coastline = inputs.catalog.shelf.parsed(path, Coastline.read)
        self.classes = (SurfaceClass("sea"), SurfaceClass(parameters.land, parameters.land_temperature))

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return 1 for points on land."""
        return SurfaceMap(self._coastline.is_land(*self._inputs.ground(time_s, rows, columns)).view(np.uint8))
