"""Cloud layers one above the other, cut into slices, with clear slices between them.

Fields are optical thicknesses of slices, because layers differ in particles and in the height of their slices. The
line of sight of a point meets the column of each layer with its row and column at the flat side of that layer, so that
columns of different layers with the same row and column do not stand above each other in slanted views: each layer has
a displacement of its own from the points of the sea, which all other rays see.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_light.slices import Field, Slices, slices_of
from hcss_light.source import Direction
from hcss_twin.providers import Array
from hcss_twin.providers.light import LightInputs

CLEAR_SLICES = 4
"""Slices between two layers: gas changes light there, and nothing else. Even, as slices are joined in pairs."""


@dataclass(frozen=True)
class Stack:
    """Slices of layers, from the lowest on.

    Parameters
    ----------
    layers : tuple of Slices
        Of each layer, each an even number.
    references_m : tuple of float
        Altitude at which lines of sight meet the columns of each layer with their row and column.
    view : Direction
    """

    layers: tuple[Slices, ...]
    references_m: tuple[float, ...]
    view: Direction

    @property
    def point_m(self) -> float:
        """Distance between columns."""
        return self.layers[0].point_m

    @cached_property
    def edges_m(self) -> Array:
        """Altitudes (Z + 1,) between all slices."""
        edges = [self.layers[0].edges_m]
        for below, above in pairwise(self.layers):
            if above.base_m > below.top_m:
                edges.append(np.linspace(below.top_m, above.base_m, CLEAR_SLICES + 1)[1:])
            edges.append(above.edges_m[1:])
        return np.concatenate(edges)

    @property
    def middle_m(self) -> Array:
        """Altitudes (Z,) of the middles of the slices."""
        return np.asarray(0.5 * (self.edges_m[1:] + self.edges_m[:-1]))

    @property
    def count(self) -> int:
        """Number of all slices."""
        return int(self.edges_m.size) - 1

    @cached_property
    def parts(self) -> tuple[slice, ...]:
        """Where the slices of each layer stand among all."""
        starts = np.searchsorted(self.edges_m, [layer.base_m for layer in self.layers])
        return tuple(
            slice(int(start), int(start) + layer.count) for start, layer in zip(starts, self.layers, strict=True)
        )

    @cached_property
    def kind(self) -> NDArray[np.int64]:
        """Number (Z,) of the layer of each slice; clear ones count to the layer below."""
        return np.searchsorted([part.start for part in self.parts], np.arange(self.count), side="right") - 1

    def shifts(self, toward: Direction) -> Array:
        """Return rows and columns (Z, 2) from a point of the sea to the columns that a ray from it meets."""
        return self._moved(toward.vector, self.middle_m)

    def entries(self, flight: Array, high: int) -> Array:
        """Return the same (Z / high, 2) where a ray with a direction of flight (3,) enters so many slices together."""
        edges = self.edges_m[::high]
        return self._moved(flight, edges[:-1] if flight[2] > 0.0 else edges[1:], high)

    def _moved(self, along: Array, altitude_m: Array, high: int = 1) -> Array:
        seen_m = np.array(self.references_m)[self.kind[::high], None] * _slope(self.view.vector)
        return np.asarray((altitude_m[:, None] * _slope(along) - seen_m) / self.point_m)

    def optical(self, densities: Sequence[Field], extinctions_m1: Sequence[float]) -> Field:
        """Return the optical thickness (Z, y, x) of all slices from the densities (Z, y, x) of each layer."""
        result = np.zeros((self.count, *densities[0].shape[1:]), dtype=np.float32)
        for part, layer, density, extinction in zip(self.parts, self.layers, densities, extinctions_m1, strict=True):
            np.multiply(density, np.float32(extinction * layer.height_m), out=result[part])
        return result

    def apart(self) -> Stack:
        """Return the same slices with columns so far apart that none sees another."""
        return replace(self, layers=tuple(layer.apart() for layer in self.layers))


def stack_of(inputs: LightInputs, steepest_deg: float, optical: Sequence[float]) -> Stack:
    """Return the stack of a scene's layers, of vertical optical thicknesses, for rays up to a zenith angle.

    Raises
    ------
    LightError
        If the rays are so slanted that too many slices are needed.
    """
    layers = []
    for cloud, thickness in zip(inputs.stack, optical, strict=True):
        layer = cloud.layer
        slices = slices_of(layer.base_m, layer.top_m, layer.anchor, cloud.point_m, steepest_deg, thickness)
        layers.append(replace(slices, count=slices.count + slices.count % 2))
    view = Direction(inputs.view.zenith_deg, inputs.view.azimuth_deg)
    return Stack(tuple(layers), tuple(cloud.reference_m for cloud in inputs.stack), view)


def _slope(along: Array) -> Array:
    """Return how far north and east (2,) a ray along a vector (3,) moves for each metre of height."""
    return np.asarray(along[:2] / along[2])


def reach_of(moves: Sequence[Array], more: int) -> tuple[tuple[int, int], ...]:
    """Return rows, and columns, before and after others to which displacements (..., 2) lead, and some more."""
    together = np.concatenate([np.zeros((1, 2)), *(move.reshape(-1, 2) for move in moves)])
    least, most = np.min(together, axis=0), np.max(together, axis=0)
    return tuple(
        (math.ceil(-float(low)) + more, math.ceil(float(high)) + more) for low, high in zip(least, most, strict=True)
    )
