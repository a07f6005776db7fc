"""The thickness axis of the radiance tables: where spectra are computed, and how frames look between.

Radiance against thickness is smooth except where the cloud top crosses a level of the profile. Between
two such breakpoints a cubic spline in ln(thickness) through few exact columns meets the tolerance; it is
then sampled densely, so that the look-up of each pixel is linear.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from hcss_twin.errors import ProviderError
from hcss_twin.providers import CloudLayer

Array = NDArray[np.float64]
Columns = Callable[[Array], Mapping[str, Array]]

FIRST_NODES = 5
MOST_NODES = 4097
LINEAR_SHARE = 0.25
"""Share of the tolerance left to the linear look-up; the spline's midpoint errors get the rest."""


@dataclass(frozen=True)
class ThicknessAxis:
    """Exact nodes of each smooth segment, and the dense nodes of the look-up.

    Attributes
    ----------
    segments : tuple of ndarray
        Thickness of the exact columns, m; neighbouring segments share an end.
    dense_m : ndarray (N,)
        Nodes of the linear look-up.
    estimated_error : float
        Largest relative error of the total found between exact nodes while they were placed.
    """

    segments: tuple[Array, ...]
    dense_m: Array
    estimated_error: float

    def sample(self, columns: Columns) -> dict[str, Array]:
        """Compute exact columns and spline every quantity onto the dense nodes, (N, B) each."""
        result: dict[str, Array] = {}
        for segment in self.segments:
            inside = (self.dense_m >= segment[0]) & (self.dense_m <= segment[-1])
            for name, values in columns(segment).items():
                dense = result.setdefault(name, np.empty((self.dense_m.size, values.shape[1])))
                dense[inside] = _spline(segment, values)(np.log(self.dense_m[inside]))
        return result


def place_axis(
    columns: Columns, total: str, layer: CloudLayer, level_m: Array, tolerance: float
) -> ThicknessAxis:
    """Place nodes so that the total keeps the tolerance, measured between the nodes.

    Parameters
    ----------
    columns : callable
        Maps thicknesses (N,) to quantities (N, B); that named ``total`` decides.
    level_m : ndarray
        Altitudes at which the profile has kinks.
    tolerance : float
        Relative to the total.

    Raises
    ------
    ProviderError
        If the radiance does not converge with nodes, because a provider returns values that jump.
    """
    segments, dense, worst = [], [], 0.0
    for low, high in pairwise(_breakpoints(layer, level_m)):
        nodes, values, error = _segment(
            lambda z: columns(z)[total], low, high, (1 - LINEAR_SHARE) * tolerance
        )
        segments.append(nodes)
        dense.append(_dense(nodes, values, LINEAR_SHARE * tolerance))
        worst = max(worst, error)
    return ThicknessAxis(tuple(segments), np.unique(np.concatenate(dense)), worst)


def _segment(
    evaluate: Callable[[Array], Array], low: float, high: float, tolerance: float
) -> tuple[Array, Array, float]:
    """Halve all intervals of one segment until the spline predicts every new column."""
    nodes = np.geomspace(low, high, FIRST_NODES)
    nodes[0], nodes[-1] = low, high
    values = evaluate(nodes)
    while True:
        middle = np.sqrt(nodes[:-1] * nodes[1:])
        exact = evaluate(middle)
        error = _relative(_spline(nodes, values)(np.log(middle)), exact)
        order = np.argsort(np.concatenate((nodes, middle)))
        nodes = np.concatenate((nodes, middle))[order]
        values = np.concatenate((values, exact))[order]
        if error <= tolerance:
            return nodes, values, error
        if nodes.size >= MOST_NODES:
            raise ProviderError(
                f"radiance against cloud thickness between {low:g} and {high:g} m does not converge to {tolerance:g} "
                f"with {nodes.size} columns (error {error:.2g}); a provider returns values that jump"
            )


def _dense(nodes: Array, values: Array, tolerance: float) -> Array:
    """Halve intervals of the linear look-up where it departs from the spline."""
    spline = _spline(nodes, values)
    dense = nodes
    suspect = np.ones(dense.size - 1, dtype=bool)
    while np.any(suspect):
        left = np.flatnonzero(suspect)
        middle = 0.5 * (dense[left] + dense[left + 1])
        ends = spline(np.log(np.stack((dense[left], dense[left + 1]))))
        exact = spline(np.log(middle))
        error = np.max(np.abs(0.5 * (ends[0] + ends[1]) / exact - 1.0), axis=1)
        coarse = error > tolerance
        position = left[coarse] + 1
        dense = np.insert(dense, position, middle[coarse])
        suspect = np.zeros(dense.size - 1, dtype=bool)
        inserted = position + np.arange(position.size)
        suspect[inserted - 1] = True
        suspect[inserted] = True
    return dense


def _breakpoints(layer: CloudLayer, level_m: Array) -> list[float]:
    """Ends of the thickness range and the thicknesses at which the cloud top crosses a level."""
    low, high = layer.thickness_min_m, layer.thickness_max_m
    # Thickness in a frame is float32: leave room for its rounding at both ends.
    low, high = low * (1 - 1e-6), high * (1 + 1e-6)
    inner: list[float] = []
    if layer.anchor == "base":
        crossing = level_m - layer.base_m
        inner = crossing[(crossing > low * 1.001) & (crossing < high * 0.999)].tolist()
    return [low, *inner, high]


def _spline(nodes: Array, values: Array) -> CubicSpline:
    return CubicSpline(np.log(nodes), values, axis=0)


def _relative(guess: Array, exact: Array) -> float:
    return float(np.max(np.abs(guess - exact) / np.maximum(np.abs(exact), np.finfo(float).tiny)))
