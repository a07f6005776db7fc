"""Tables for several views of a scene, and look-up with weights for each pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables, with_largest_errors
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.views import ViewAxis, views_over_image
from hcss_twin.plan.windows import Window, points_of
from hcss_twin.providers import Grid


def plans_over_views(plan: Plan) -> Iterator[Plan]:
    """Yield a plan for each view with tables, or the plan itself if one view is used for all pixels.

    Plans are built one at a time, because the providers of each view's own air can need 60 MB.
    """
    if plan.views is None:
        yield plan
        return
    views = views_over_image(plan.assembly)
    assert views is not None
    for view in views.at(plan.views.places):
        yield plan.toward(view)


def tables_over_views(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables of all views of a plan with several views.

    Parameters
    ----------
    tables_of : callable
        Computes the tables of a plan with one view.

    Returns
    -------
    RadianceTables
        Tables with the most wavenumbers, with the largest errors of all views, and all tables as ``over_views``.
    """
    assert plan.views is not None
    of_views = tuple(tables_of(toward) for toward in plans_over_views(plan))
    largest = with_largest_errors(of_views)
    errors = replace(largest.errors, views=plan.views.estimated_error)
    return replace(largest, errors=errors, over_views=of_views)


Thickness = NDArray[np.float32]

VALUES_AT_ONCE = 2**21
"""Maximum pixels times channels that are summed together; 16 MB."""


class GridViews:
    """Weights of the nodes of the view for the pixels of a grid on the ground."""

    def __init__(self, axis: ViewAxis, grid: Grid) -> None:
        self._across, self._up = axis.weights(grid)

    def look_ups(self, of_nodes: Sequence[LookUp]) -> list[LookUp]:
        """Return the look-ups at the nodes."""
        return list(of_nodes)

    def weights_of(self, window: Window) -> Array:
        """Return the weights (N, pixels) of the nodes for the pixels of a window."""
        up, across = self._up[window[0]], self._across[window[1]]
        weights: Array = up[:, None, :, None] * across[None, :, None, :]
        return weights.reshape(up.shape[0] * across.shape[0], -1).T


class ViewedLookUp:
    """Look-up in the tables of one instant for the view of each pixel.

    Parameters
    ----------
    grid : Grid
        The image, in pixels.
    look_ups : sequence of LookUp
        One look-up for each node of the axis, in order.
    """

    def __init__(self, axis: ViewAxis, grid: Grid, look_ups: Sequence[LookUp]) -> None:
        self._look_ups = look_ups
        self._across, self._up = axis.weights(grid)

    def of_part(self, extent: Window) -> ViewedLookUp:
        """Return the look-up of some rows and columns of the image, counted from the first of them."""
        part = copy(self)
        part._up, part._across = self._up[extent[0]], self._across[extent[1]]
        return part

    def of_points(self, extent: Window, samples: int) -> ViewedLookUp:
        """Return the look-up of the points of some rows and columns, as if each were a pixel."""
        part = self.of_part(extent)
        part._up, part._across = (np.repeat(weights, samples, axis=0) for weights in (part._up, part._across))
        return part

    @property
    def _shape(self) -> tuple[int, int]:
        return len(self._up), len(self._across)

    def _weights(self, y: slice, x: slice) -> Iterator[Array]:
        """Yield the weights (y, x) of each node for a window."""
        for up in self._up[y].T:
            for across in self._across[x].T:
                yield up[:, None] * across

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image like :meth:`LookUp.fill`; without layers, of the whole image."""
        if thickness_m:
            rows, columns = (size // samples for size in thickness_m[0].shape)
        else:
            (rows, columns), corner = self._shape, (0, 0)
        step = max(1, VALUES_AT_ONCE // (self._channels(radiance.shape[0]) * columns))
        x = slice(corner[1], corner[1] + columns)
        for first in range(0, rows, step):
            strip = slice(first, min(first + step, rows))
            points = [thickness[points_of(strip, samples)] for thickness in thickness_m]
            y = slice(corner[0] + strip.start, corner[0] + strip.stop)
            self._fill_strip(radiance[:, y, x], points, samples, y, x)

    def _channels(self, channels: int) -> int:
        """Return how many channels are looked up together for those of the radiance."""
        return channels

    def _fill_strip(
        self, radiance: NDArray[np.float32], thickness_m: Sequence[Thickness], samples: int, y: slice, x: slice
    ) -> None:
        """Write the radiance (C, y, x) of some rows and columns of the part."""
        sums = np.zeros(radiance.shape)
        part = np.empty(radiance.shape, dtype=np.float32)
        for weight, look_up in zip(self._weights(y, x), self._look_ups, strict=True):
            look_up.fill(part, thickness_m, samples)
            _add(sums, part, weight)
        # A vanishing term can become negative between nodes.
        radiance[...] = np.maximum(sums, 0.0)


@kernel()
def _add(sums, part, weight):  # type: ignore[no-untyped-def]
    """Add a part (C, y, x) to the sums, weighted by pixel (y, x)."""
    for c in range(sums.shape[0]):
        for y in range(sums.shape[1]):
            for x in range(sums.shape[2]):
                sums[c, y, x] += weight[y, x] * np.float64(part[c, y, x])
