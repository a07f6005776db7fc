"""The clear sea of fast frames: how its radiance differs over the field, by view, glint and temperature.

Tables toward the optical axis have the radiance of clouds. What a clear pixel differs from the axis is a sum: the view
of its place, polynomials over the field, and the texture of the sea's temperature at its place, which a frame knows at
the nodes of its mesh. It shows through clouds as a warmer sea does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_payload.live.kernels import between_samples
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Grid, Sun, View

ORDER = 4
"""Of the polynomials over rows and columns of the field."""

OUTER_M = 320e3
"""Wavelengths up to which the standard deviation of the sea's temperature is given."""

_FINE = 4
"""Pixels between the places at which frames know the texture."""

_SMOOTH = 0.05
"""Share of the accuracy within which clear sky is smooth over a field."""

_LAYOUT = 1
"""Incremented when what the cache keeps of clear sky changes its meaning."""

_AROUND = 64
"""Samples around what a frame sees whose texture is computed with it: for frames after it."""


def node_positions() -> Array:
    """Return Chebyshev nodes (5,) from -1 to 1."""
    return -np.cos(np.pi * np.arange(ORDER + 1) / ORDER)


def node_weights(positions: Array) -> Array:
    """Return the weights (N, 5) of the nodes at positions, from -1 to 1 over the field."""
    powers, at_nodes = (np.polynomial.chebyshev.chebvander(at, ORDER) for at in (positions, node_positions()))
    weights: Array = powers @ np.linalg.inv(at_nodes)
    return weights


@dataclass(frozen=True, eq=False)
class ClearSky:
    """Radiance of clear sky toward the field of a camera at one time.

    Attributes
    ----------
    axis : ndarray (B,)
        Radiance toward the axis.
    views : ndarray (25, B)
        How much more there is toward the nodes (:func:`over_field`).
    per_K : ndarray (B,)
        How much more there is over a sea warmer by a kelvin.
    """

    axis: Array
    views: Array
    per_K: Array

    @classmethod
    def of(cls, plan: Plan, tables: RadianceTables, seen: Sequence[tuple[View, Sun]], time_s: float) -> ClearSky:
        """Return it from the cache, or newly computed.

        Parameters
        ----------
        plan : Plan
            Toward the optical axis.
        tables : RadianceTables
            Of this plan.
        seen : sequence of (View, Sun)
            Toward the nodes of the field, row by row, and the sun where they see the sea.
        """
        parts = ["clear sky of a field", _LAYOUT, time_s, [[asdict(view), asdict(sun)] for view, sun in seen]]
        return RadianceTables.recall_beside(plan, parts, lambda: cls._computed(plan, tables, seen, time_s), (cls,))

    @classmethod
    def _computed(cls, plan: Plan, tables: RadianceTables, seen: Sequence[tuple[View, Sun]], time_s: float) -> ClearSky:
        nodes, sun = tables.spectrum.nodes, plan.sun_at(time_s)

        def clear(toward: Plan, of_place: Sun | None = sun) -> Array:
            terms = toward.assembly.clear(nodes.wavenumber_cm1, of_place)
            radiance: Array = np.sum(list(terms.values()), axis=0) @ nodes.weights_cm1.T
            return radiance

        warmer = replace(plan, assembly=plan.assembly.perturbed(1.0, 1.0))
        axis = clear(plan)

        def more(node: int) -> Array:
            view, of_place = seen[node]
            return clear(plan.toward(view), of_place if sun is not None and of_place.is_up else sun) - axis

        views = over_field(more, _SMOOTH * plan.accuracy.relative * axis)
        return cls(axis, views, clear(warmer) - axis)


def over_field(value: Callable[[int], Array], allowed: Array) -> Array:
    """Return values (25, B) at the nodes of a field, row by row, most of them interpolated where they are smooth.

    Every second node is one of the second order: where polynomials of this order give the values at four others within
    what is allowed (B,), they give the rest.
    """
    nodes, size = node_positions(), ORDER + 1
    few, all_nodes = (np.polynomial.chebyshev.chebvander(at, ORDER // 2) for at in (nodes[::2], nodes))
    weights = np.kron(all_nodes @ np.linalg.inv(few), all_nodes @ np.linalg.inv(few))
    given, tried = (
        [size * row + column for row in range(start, size, 2) for column in range(start, size, 2)] for start in (0, 1)
    )
    at_given: Array = np.stack([value(node) for node in given])
    values: Array = np.matmul(weights, at_given)
    errors = np.stack([value(node) for node in tried]) - values[tried]
    if np.all(np.abs(errors) <= allowed):
        return values
    values[tried] += errors
    for node in set(range(size**2)) - set(given) - set(tried):
        values[node] = value(node)
    return values


class SeaTexture:
    """Temperature of the sea at any places.

    Parameters
    ----------
    plan : Plan
        With the texture; none is 0 everywhere.
    pixel_m : float
        Footprint of a pixel; samples are as far from each other as some of them, or as the pixels of the scene.
    step : int
        Pixels between the nodes of the mesh.

    Attributes
    ----------
    sample_m, finest_m : float
        Distance of the samples, and size of the finest structures that are shown.
    fine, parts : int
        Pixels between the places at which frames know the texture, and how many of these there are for each node.
    share_left : float
        Of the variance, in finer structures: that of k^-2 from this size on.
    """

    def __init__(self, plan: Plan, pixel_m: float, step: int) -> None:
        grid, self.fine = plan.grid, min(_FINE, step)
        self.parts = step // self.fine
        larger = 2.0 ** max(0.0, np.floor(np.log2(_FINE * pixel_m / grid.pixel_size_m)))
        self.sample_m = float(grid.pixel_size_m * larger)
        self.finest_m = max(self.sample_m, self.fine * pixel_m)
        self.share_left = self.finest_m / OUTER_M
        rows, columns = (max(2, round(size / larger)) for size in (grid.rows, grid.columns))
        self._size = rows, columns
        assembly = replace(plan.assembly, grid=Grid(rows, columns, self.sample_m))
        self._fields, self._step_K = plan.texture.fields(plan.scenario, assembly), plan.texture.steps[0]
        self._speed_m_s = plan.assembly.motion.platform_speed_m_s
        self._corner, self._values = (0, 0), np.zeros((0, 0), np.float32)

    def at(self, places_m: Array) -> Array:
        """Return how much warmer the sea is (n, m), in K: at nodes, x and y (N, M, 2) in m, and between them."""
        found = np.zeros([(size - 1) * self.parts + 1 for size in places_m.shape[:2]])
        if self._step_K == 0.0:
            return found
        middle = np.array([0.5 * (self._size[1] - 1), 0.5 * (self._size[0] - 1)])
        samples = places_m / self.sample_m + middle
        low, high = np.floor(samples.min(axis=(0, 1))).astype(int), np.floor(samples.max(axis=(0, 1))).astype(int) + 2
        (row, column), (rows, columns) = self._corner, self._values.shape
        if low[1] < row or low[0] < column or high[1] > row + rows or high[0] > column + columns:
            window = slice(low[1] - _AROUND, high[1] + _AROUND), slice(low[0] - _AROUND, high[0] + _AROUND)
            warmer, _ = self._fields.at(0.0, *window)
            self._corner, self._values = (int(window[0].start), int(window[1].start)), warmer
        between_samples(self._values, samples, self.parts, self._corner, found)
        found *= self._step_K
        return found


def field_nodes(rows: int, columns: int) -> NDArray[np.float64]:
    """Return row and column (25, 2) of the nodes of a field, row by row."""
    at_rows, at_columns = (0.5 * (size - 1) * (1.0 + node_positions()) for size in (rows, columns))
    return np.stack(np.meshgrid(at_rows, at_columns, indexing="ij"), axis=-1).reshape(-1, 2)
