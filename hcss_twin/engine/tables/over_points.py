"""Look-up in tables that differ from point to point: of surfaces, or of altitudes of cloud tops."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import PixelViews
from hcss_twin.engine.tables.over_views import ViewedLookUp
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, pixel_sums, points_of

Thickness = NDArray[np.float32]

VALUES_AT_ONCE = 2**22
"""Maximum points times channels that are looked up together; 16 MB."""


@dataclass(frozen=True)
class Group:
    """Points of a window that are interpolated between the same tables.

    Attributes
    ----------
    points : ndarray (N,)
        Indices of the points, row by row.
    states : sequence of sequence (view) of LookUp
        Look-ups of each state.
    weights : ndarray (states, B, N) or (states, 1, N), or None
        Of each state; None for one state.
    thickest_m : sequence of float, optional
        Greatest thickness in the tables of each state, which thicker clouds get.
    """

    points: NDArray[np.intp]
    states: Sequence[Sequence[LookUp]]
    weights: Array | None
    thickest_m: Sequence[float] = ()


class PointLookUp(ABC):
    """Look-up at one instant in the tables of each point; the points of a pixel are averaged afterwards.

    Parameters
    ----------
    views : PixelViews or None
        Weights of the nodes of the view at each pixel; None for one view.
    """

    def __init__(self, plan: Plan, views: PixelViews | None) -> None:
        self._bands, self._views = len(plan.bands), views
        self._extent: Window = slice(0, plan.image.rows), slice(0, plan.image.columns)

    @abstractmethod
    def _groups(self, window: Window, samples: int) -> Iterator[Group]:
        """Yield all points of a window of the image."""

    def of_part(self, extent: Window) -> PointLookUp:
        """Return the look-up of some rows and columns, counted from the first of this one."""
        part = copy(self)
        part._extent = self._moved(extent)
        return part

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image like :meth:`LookUp.fill`; without layers, of the whole image."""
        rows, columns = (length(pixels) for pixels in self._extent)
        if thickness_m:
            rows, columns = (size // samples for size in thickness_m[0].shape)
        step = max(1, VALUES_AT_ONCE // (radiance.shape[0] * columns * samples**2))
        x = slice(corner[1], corner[1] + columns)
        for first in range(0, rows, step):
            strip = slice(first, min(first + step, rows))
            of_strip = [thickness[points_of(strip, samples)] for thickness in thickness_m]
            y = slice(corner[0] + strip.start, corner[0] + strip.stop)
            window = self._moved((y, x))
            of_points = self._of_points(radiance.shape[0], of_strip, window, samples)
            for channel, values in zip(radiance, of_points, strict=True):
                channel[y, x] = values if samples == 1 else pixel_sums(values, samples) / samples**2

    def _of_points(
        self, channels: int, thickness_m: Sequence[Thickness], window: Window, samples: int
    ) -> NDArray[np.float32]:
        """Return the radiance (C, y, x) of the points of a window."""
        shape = tuple(length(pixels) * samples for pixels in window)
        values = np.empty((channels, shape[0] * shape[1]), dtype=np.float32)
        layers = [thickness.ravel() for thickness in thickness_m]
        for group in self._groups(window, samples):
            points, states = group.points, group.states
            inside = [thickness[points][None] for thickness in layers]
            by_view = self._view_weights(points, window, samples)
            if group.weights is None and by_view is None:
                values[:, points] = _looked_up(states[0][0], inside, channels, points.size)
                continue
            by_state: Array = np.ones((len(states), 1, 1))
            if group.weights is not None:
                by_state = np.tile(group.weights, (1, channels // group.weights.shape[1], 1))
            sums = np.zeros((channels, points.size))
            for state, (weight, views) in enumerate(zip(by_state, states, strict=True)):
                layers_in_state = inside
                if group.thickest_m:
                    thickest = np.float32(group.thickest_m[state])
                    layers_in_state = [np.minimum(thickness, thickest) for thickness in inside]
                for view, look_up in enumerate(views):
                    part = weight * _looked_up(look_up, layers_in_state, channels, points.size)
                    sums += part if by_view is None else by_view[view] * part
            # A vanishing term can become negative between nodes.
            values[:, points] = np.maximum(sums, 0.0)
        return values.reshape(channels, *shape)

    def _view_weights(self, points: NDArray[np.intp], window: Window, samples: int) -> Array | None:
        """Return the weight (views, N) of each view at some points of a window; None with one view."""
        if self._views is None:
            return None
        row, column = np.divmod(points, length(window[1]) * samples)
        weights: Array = self._views.weights_of(window)[:, row // samples * length(window[1]) + column // samples]
        return weights

    def _moved(self, window: Window) -> Window:
        """Return a window of this part as one of the image."""
        rows, columns = (
            slice(pixels.start + whole.start, pixels.stop + whole.start)
            for pixels, whole in zip(window, self._extent, strict=True)
        )
        return rows, columns


AnyLookUp: TypeAlias = LookUp | ViewedLookUp | PointLookUp


def _looked_up(look_up: LookUp, thickness_m: Sequence[Thickness], channels: int, count: int) -> NDArray[np.float32]:
    result = np.empty((channels, 1, count), dtype=np.float32)
    look_up.fill(result, thickness_m)
    return result[:, 0]
