"""Curves of reference columns: one layer alone, between nodes that share nothing with those of the tables.

Scenes of a sweep that differ in their clouds only have reference columns in common. A curve shares nothing with the
tables but the altitudes where the profile has kinks; columns between its nodes, of the same solution, measure its
error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.thickness_axis import axis_of
from hcss_twin.plan.axis import PlacedAxis, place
from hcss_twin.providers import CloudLayer

ORDERS = (20, 40)
"""Orders of the polynomials: emissivity changes from 0 to 1 while the thickness grows by a factor of ten."""

ColumnsAt = Callable[[Array], Array]
"""Maps thicknesses (N,) of the layer to terms (N, ..., K, B)."""


@dataclass(frozen=True)
class ReferenceCurve:
    """Reference terms of one layer alone.

    Attributes
    ----------
    segments_m : tuple of ndarray (n,)
        Thicknesses of the nodes of each smooth segment.
    nodes : ndarray (N, ..., K, B)
        Columns at all nodes.
    error : float
        Largest error of columns between the nodes of half the number, relative to their total.
    """

    segments_m: tuple[Array, ...]
    nodes: Array
    error: float

    @property
    def columns(self) -> int:
        """Number of columns solved for the curve."""
        return len(self.nodes)

    def terms(self, layer: CloudLayer, level_m: Array, thickness_m: Array) -> Array:
        """Return terms (N, ..., K, B) of columns (N,) within the thickness limits of the layer."""
        placed = PlacedAxis(axis_of(layer, level_m), self.segments_m)
        return placed.interpolate(self.nodes, np.maximum(thickness_m, placed.axis.low))


def reference_curve(columns: ColumnsAt, layer: CloudLayer, level_m: Array, tolerance: float) -> ReferenceCurve | None:
    """Return the curve of a layer, or None if it does not reach the tolerance relative to the total.

    Parameters
    ----------
    columns : callable
    level_m : ndarray
        Altitudes at which the profile has kinks.
    """
    for order in ORDERS:  # all columns of a curve are solved together, at wavenumbers that suit all of them
        known = dict[float, Array]()

        def kept(thickness_m: Array, known: dict[float, Array] = known) -> Array:
            values = columns(thickness_m)
            known.update(zip(thickness_m.tolist(), values, strict=True))
            return values

        placed = place(axis_of(layer, level_m), kept, tolerance, orders=(order,), most=0)
        if placed.missed is None:
            nodes = np.stack([known[thickness] for thickness in placed.nodes.tolist()])
            return ReferenceCurve(placed.segments, nodes, placed.error)
    return None
