"""Radiance tables: band radiance against cloud thickness (and time, where the sun moves)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ProviderError

Array = NDArray[np.float64]

TOTAL = "radiance"

ROUNDING = 1e-6
"""Thickness in a frame is float32: so much beyond the outermost nodes is rounding, and is taken for the node."""


@dataclass(frozen=True)
class ThicknessTable:
    """Band radiance of one instant: the clear column, and cloudy columns at thickness nodes.

    Attributes
    ----------
    thickness_m : ndarray (N,)
        Nodes, ascending, above 0; empty in a scene without cloud.
    clear : mapping of str to ndarray (B,)
        Total (``radiance``) and each requested term.
    cloudy : mapping of str to ndarray (N, B)
        The same for the nodes.
    """

    thickness_m: Array
    clear: Mapping[str, Array]
    cloudy: Mapping[str, Array]

    def blend(self, other: ThicknessTable, weight: float) -> ThicknessTable:
        """Interpolate linearly toward ``other``, which has the same nodes."""
        if weight == 0.0:
            return self
        return ThicknessTable(
            self.thickness_m,
            {name: (1 - weight) * value + weight * other.clear[name] for name, value in self.clear.items()},
            {name: (1 - weight) * value + weight * other.cloudy[name] for name, value in self.cloudy.items()},
        )


@dataclass(frozen=True)
class RadianceTables:
    """Thickness tables at time nodes.

    Attributes
    ----------
    time_s : tuple of float (T,)
        Time nodes; a single one where the sun does not matter.
    tables : tuple of ThicknessTable (T,)
        Tables at the nodes.
    estimated_error : float
        Largest relative error of the total found between the nodes while they were placed.
    """

    time_s: tuple[float, ...]
    tables: tuple[ThicknessTable, ...]
    estimated_error: float

    def at(self, time_s: float) -> ThicknessTable:
        """Table at a time within the nodes."""
        if len(self.tables) == 1:
            return self.tables[0]
        index = int(np.clip(np.searchsorted(self.time_s, time_s, side="right") - 1, 0, len(self.time_s) - 2))
        span = self.time_s[index + 1] - self.time_s[index]
        return self.tables[index].blend(self.tables[index + 1], (time_s - self.time_s[index]) / span)


def look_up(table: ThicknessTable, thickness_m: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
    """Radiance of one frame.

    Parameters
    ----------
    thickness_m : ndarray (y, x)
        Cloud thickness, 0 where clear.

    Returns
    -------
    dict
        ``radiance`` and each term, (B, y, x).
    """
    thickness = thickness_m.astype(np.float64).ravel()
    cloudy = np.flatnonzero(thickness > 0)
    nodes = table.thickness_m
    index, fraction = _locate(nodes, thickness[cloudy])
    result = {}
    for name, clear in table.clear.items():
        frame = np.empty((clear.size, thickness.size), dtype=np.float32)
        frame[:] = clear[:, None]
        if cloudy.size:
            values = table.cloudy[name].T
            for band, row in enumerate(values):
                frame[band, cloudy] = row[index] + fraction * (row[index + 1] - row[index])
        result[name] = frame.reshape(clear.size, *thickness_m.shape)
    return result


def _locate(nodes: Array, thickness: Array) -> tuple[NDArray[np.intp], Array]:
    """Interval and fraction of each thickness; shared by all bands and terms."""
    if thickness.size == 0:
        return np.zeros(0, dtype=np.intp), thickness
    low, high = float(nodes[0]), float(nodes[-1])
    if thickness.min() < low * (1 - ROUNDING) or thickness.max() > high * (1 + ROUNDING):
        raise ProviderError(
            f"cloud thickness {thickness.min():g} to {thickness.max():g} m; the layer allows {low:g} to {high:g} m"
        )
    inside = np.clip(thickness, low, high)
    index = np.clip(np.searchsorted(nodes, inside, side="right") - 1, 0, nodes.size - 2)
    return index, (inside - nodes[index]) / (nodes[index + 1] - nodes[index])
