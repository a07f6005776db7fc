"""Radiance of live frames: tables along the pass, as a function of the field that a pixel sees.

The field in a pixel is its mean plus a normal number with the variance that the footprint has removed, so the radiance
of a pixel is that of the field blurred by this normal number, as far as contrast allows
(:mod:`hcss_payload.live.prefilter`). Along the pass tables stand at times close enough that
the radiance between them, tested in the middle, is interpolated within the scenario's accuracy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from hcss_payload.live.kernels import TABLE_HALF, TABLE_PER_VALUE
from hcss_payload.live.octaves import SeenOctaves, shape_of
from hcss_payload.live.prefilter import Sharpness, sharpness
from hcss_payload.live.sea import ClearSky
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun, View

SMALLEST_SIGMA = 0.005
"""Below, the cloud's edge is sharp: an interval of the table is as wide as twice the blur."""

_FINE = 4
"""Cells in which the radiance is averaged, per interval of the table."""

_REACH = 6.0
"""Standard deviations of the blur beyond which nothing contributes."""


@dataclass(frozen=True, eq=False)
class Moment:
    """Tables at one time.

    Attributes
    ----------
    time_s : float
    radiance : ndarray of float32 (I, B, 4)
        At the start of each interval of the field, and the change over it; and how much of what clear sky differs shows
        there, with its change.
    clear : ClearSky
    """

    time_s: float
    radiance: NDArray[np.float32]
    clear: ClearSky


class FieldRadiance:
    """Radiance as a function of the field, at any time of a pass.

    Parameters
    ----------
    view_at, seen_at, views_at : callable
        The view of the optical axis, the octaves that a pixel sees, and the views toward the nodes of the field with
        their suns, at a time in s.
    tolerance : float
        Largest relative error between tables.

    Attributes
    ----------
    error : float
        Largest relative error of the interpolation in time, measured in the middle between tables.
    """

    def __init__(
        self,
        plan: Plan,
        view_at: Callable[[float], View],
        seen_at: Callable[[float], SeenOctaves],
        views_at: Callable[[float], list[tuple[View, Sun]]],
        start_s: float,
        end_s: float,
        tolerance: float,
    ) -> None:
        self._plan, self._view_at, self._seen_at, self._views_at = plan, view_at, seen_at, views_at
        layer = plan.layers[0]
        self.edge = edge_of(layer.coverage)
        self.middle = np.float32(TABLE_HALF - self.edge * TABLE_PER_VALUE)
        self.error = 0.0
        moments = [self._moment(start_s)]
        if end_s > start_s:
            moments.append(self._moment(end_s))
            moments = self._refined(moments, tolerance)
        self._times = np.array([moment.time_s for moment in moments])
        self._tables, self._clear = [moment.radiance for moment in moments], [moment.clear for moment in moments]
        self._now = np.empty_like(self._tables[0])
        self._part = np.empty_like(self._tables[0])

    @property
    def times_s(self) -> Array:
        """Times of the tables."""
        return self._times

    def clear_at(self, time_s: float) -> tuple[Array, Array]:
        """Return how much more clear sky has toward the nodes of the field (25, B), and per kelvin of the sea (B,)."""
        index, weight = self._between(time_s)
        both = [(clear.views, clear.per_K) for clear in self._clear[index : index + 2]]
        views, per_K = ((1.0 - weight) * of[0] + weight * of[-1] for of in zip(*both, strict=True))
        return views, per_K

    @property
    def clear(self) -> ClearSky:
        """Clear sky at the start of the pass."""
        return self._clear[0]

    def _between(self, time_s: float) -> tuple[int, float]:
        """Return the interval of a time, and the weight of its end."""
        if len(self._tables) == 1:
            return 0, 0.0
        index = int(np.clip(np.searchsorted(self._times, time_s, side="right") - 1, 0, self._times.size - 2))
        return index, float((time_s - self._times[index]) / (self._times[index + 1] - self._times[index]))

    def at(self, time_s: float) -> NDArray[np.float32]:
        """Return the table (I, B, 4) at a time; valid until the next call."""
        if len(self._tables) == 1:
            return self._tables[0]
        index, later = self._between(time_s)
        weight = np.float32(later)
        np.multiply(self._tables[index], np.float32(1.0) - weight, out=self._now)
        np.multiply(self._tables[index + 1], weight, out=self._part)
        self._now += self._part
        return self._now

    def _refined(self, moments: list[Moment], tolerance: float) -> list[Moment]:
        """Add tables in the middle until the interpolation there is accurate."""
        before, after = moments
        middle = self._moment(0.5 * (before.time_s + after.time_s))
        between = 0.5 * (before.radiance[..., 0].astype(np.float64) + after.radiance[..., 0])
        error = float(np.max(np.abs(between / middle.radiance[..., 0] - 1.0)))
        of_views = 0.5 * (before.clear.views + after.clear.views) - middle.clear.views
        error = max(error, float(np.max(np.abs(of_views) / middle.clear.axis)))
        left, right = [before, middle], [middle, after]
        # The error of either half is a quarter of that of both.
        if error > 4.0 * tolerance and after.time_s - before.time_s > 1e-3:
            left, right = self._refined(left, tolerance), self._refined(right, tolerance)
        else:
            self.error = max(self.error, 0.25 * error)
        return [*left, *right[1:]]

    def _moment(self, time_s: float) -> Moment:
        plan, bands = self._plan.toward(self._view_at(time_s)), len(self._plan.bands)
        tables = tables_of(plan)
        look_up, clear = LookUp.at(tables, time_s), ClearSky.of(plan, tables, self._views_at(time_s), time_s)
        states = tables.texture.states
        warm = LookUp.at(replace(tables, tables=states[0]), time_s) if states else None
        step = plan.texture.steps[0] * clear.per_K[:, None]
        layer, exponent = plan.layers[0], shape_of(plan).brightness_exponent

        def radiance(field: Array) -> Array:
            """Radiance (2 x B, N), and the share of what clear sky differs that shows: without texture, in no cloud."""
            thickness = FractalClouds.field_thickness(field[None].astype(np.float32), layer, exponent, in_place=True)
            values = np.empty((2, look_up.table.clear.size, 1, field.size), np.float32)
            look_up.fill(values[0], [thickness])
            if warm is None:
                of_bands = values[0, :bands, 0].astype(np.float64)
                return np.concatenate((of_bands, np.broadcast_to(thickness == 0.0, of_bands.shape)))
            warm.fill(values[1], [thickness])
            of_bands, over_warm = values[:, :bands, 0].astype(np.float64)
            return np.concatenate((of_bands, (over_warm - of_bands) / step))

        shown = sharpness(lambda field: radiance(field)[:bands], self.edge, self._seen_at(time_s))
        twice = Sharpness(np.tile(shown.sigma, 2), np.tile(shown.scale, 2))
        start, end = intervals(radiance, self.edge, twice)
        columns = np.stack((start, end - start), axis=-1).reshape(2, bands, -1, 2)
        return Moment(time_s, np.ascontiguousarray(np.concatenate(columns, axis=-1).swapaxes(0, 1), np.float32), clear)


def edge_of(coverage: float) -> float:
    """Return the value of the field at the edges of clouds; 0 for a sky without edges."""
    return -NormalDist().inv_cdf(coverage) if 0.0 < coverage < 1.0 else 0.0


def intervals(radiance: Callable[[Array], Array], edge: float, shown: Sharpness) -> tuple[Array, Array]:
    """Return the radiance (B, I) at the start and at the end of the intervals of a table.

    Parameters
    ----------
    radiance : callable
        Radiance (B, N) of values (N,) of the field, which may jump at ``edge``.
    shown : Sharpness
        Of each band: the standard deviation over which it is averaged, and the scale of the field.
    """
    value = edge + (np.arange(2 * TABLE_HALF + 1) - TABLE_HALF) / TABLE_PER_VALUE
    if np.all(shown.sigma < SMALLEST_SIGMA):
        start, end = value[:-1].copy(), value[1:].copy()
        end[TABLE_HALF - 1] = np.nextafter(np.float32(edge), np.float32(-np.inf))
        start[TABLE_HALF] = np.nextafter(np.float32(edge), np.float32(np.inf))
        return radiance(start), radiance(end)
    # Interpolation between values averages, too: over the variance of a triangle.
    sigma = np.sqrt(np.maximum(shown.sigma**2 - TABLE_PER_VALUE**-2 / 6.0, SMALLEST_SIGMA**2))
    # Cells whose ends are a whole number of cells from the edge.
    cell = 1.0 / (TABLE_PER_VALUE * _FINE)
    reach = math.ceil(_REACH * float(sigma.max()) / cell)
    half = math.ceil(float(shown.scale.max()) * np.abs(value).max() / cell) + math.ceil(abs(edge) / cell)
    middle = edge + cell * (np.arange(-half - reach, half + reach) + 0.5)
    nodes = edge + cell * np.arange(-half, half + 1)[1:-1]
    result = []
    for band_radiance, width, scale in zip(radiance(middle), sigma, shown.scale, strict=True):
        weight = np.diff(ndtr(cell * np.arange(-reach, reach + 1) / width))
        averaged = np.convolve(band_radiance, weight / weight.sum(), mode="valid")
        result.append(np.interp(scale * value, nodes, averaged[1:-1]))
    fine = np.stack(result)
    return fine[:, :-1], fine[:, 1:]
