"""Corner plot: every parameter, and every two of them together."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MASSES = (0.9, 0.5)
"""Shares of the draws within the lines."""

QUANTILES = (0.05, 0.5, 0.95)
"""Lines in the histograms."""

_BINS = 32
_INK, _FILL = "#0b5c97", "Blues"


def corner_plot(draws: Mapping[str, Array]) -> Figure:
    """Draw all parameters against each other.

    Parameters
    ----------
    draws : mapping of str to ndarray (n,)
        At least one parameter.
    """
    from matplotlib.figure import Figure

    names = list(draws)
    count = len(names)
    side = max(3.2, 1.75 * count + 0.5)
    figure = Figure(figsize=(side, side), layout="constrained")
    figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0.02, hspace=0.02)
    axes = figure.subplots(count, count, squeeze=False)
    ranges = {name: _range(values) for name, values in draws.items()}
    for (row, below), (column, across) in product(enumerate(names), enumerate(names)):
        axis = axes[row, column]
        if column > row:
            axis.set_visible(False)
            continue
        if row == column:
            _histogram(axis, draws[below], ranges[below])
        else:
            _density(axis, draws[across], draws[below], ranges[across], ranges[below])
        axis.set_xlim(ranges[across])
        axis.tick_params(labelsize=8, labelbottom=row == count - 1, labelleft=column == 0 and row > 0)
        axis.locator_params(axis="x", nbins=3)
        if row == count - 1:
            axis.set_xlabel(across, fontsize=9)
            axis.tick_params(axis="x", labelrotation=30)
        if column == 0 and row > 0:
            axis.locator_params(axis="y", nbins=3)
            axis.set_ylabel(below, fontsize=9)
    return figure


def _range(values: Array) -> tuple[float, float]:
    """Return where all but a thousandth of the draws lies, and a margin."""
    low, high = (float(each) for each in np.quantile(values, (0.0005, 0.9995)))
    margin = 0.04 * (high - low) or max(abs(low), 1.0) * 1e-3
    return low - margin, high + margin


def _histogram(axis: Axes, values: Array, limits: tuple[float, float]) -> None:
    axis.hist(values, _BINS, range=limits, density=True, color=_INK, alpha=0.3, histtype="stepfilled")
    for quantile, value in zip(QUANTILES, np.quantile(values, QUANTILES), strict=True):
        axis.axvline(value, color=_INK, lw=1.0, ls="-" if quantile == 0.5 else "--")
    axis.set_yticks([])


def _density(
    axis: Axes, x: Array, y: Array, limits_x: tuple[float, float], limits_y: tuple[float, float]
) -> None:
    from scipy.ndimage import gaussian_filter

    counts, edges_x, edges_y = np.histogram2d(x, y, _BINS, range=(limits_x, limits_y))
    extent = (*limits_x, *limits_y)
    axis.imshow(counts.T, origin="lower", extent=extent, aspect="auto", cmap=_FILL, interpolation="nearest")
    # single draws are noise: lines are those of the smoothed density
    smooth = gaussian_filter(counts.T, 1.2)
    centres = [0.5 * (edges[1:] + edges[:-1]) for edges in (edges_x, edges_y)]
    levels = mass_levels(smooth, MASSES)
    if len(levels) == len(MASSES):
        axis.contour(*centres, smooth, levels=levels, colors=_INK, linewidths=1.0, linestyles=("--", "-"))
    axis.set_ylim(limits_y)


def mass_levels(density: Array, masses: tuple[float, ...]) -> list[float]:
    """Return the densities above which lie these shares of the whole, ascending; equal ones once."""
    ordered = np.sort(density.ravel())[::-1]
    share = np.cumsum(ordered) / ordered.sum()
    return sorted({float(ordered[min(int(np.searchsorted(share, mass)), share.size - 1)]) for mass in masses})
