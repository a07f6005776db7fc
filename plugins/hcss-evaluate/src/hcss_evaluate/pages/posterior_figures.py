"""Figures of a posterior: corner plot, traces, priors and posteriors, parameters of images, predicted variogram."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.priors import KINDS, Prior
from hcss_twin.providers import Array
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MASSES = (0.9, 0.5)
"""Fractions of the draws within the contour lines."""

QUANTILES = (0.05, 0.5, 0.95)
"""Quantiles marked in the histograms."""

DRAWN_WALKERS = 24
DRAWN_IMAGES = 6

_BINS = 32
_BLUE = "#0b5c97"
_PRIOR, _OBSERVED = "#b3261e", "#222222"
_POINTS = 400


@dataclass(frozen=True)
class Variogram:
    """Observed and predicted variogram.

    Attributes
    ----------
    lag : ndarray (lag,)
        Pixels.
    axes : tuple of str
        Directions of the lag.
    observed, error : ndarray (image, lag, axis)
    quantiles : ndarray (quantile,)
    predicted : ndarray (quantile, image, lag, axis)
    """

    lag: Array
    axes: tuple[str, ...]
    observed: Array
    error: Array
    quantiles: Array
    predicted: Array


def prior_density(name: str, text: str, values: Array) -> Array | None:
    """Return the density of a parameter's prior at values (n,), zero outside the range of the parameter.

    Parameters
    ----------
    name : str
        Name of the parameter: ``H``, ``mean_H``, ``spread_H``, ...; an unknown one has no limits.
    text : str
        Prior in the format of :meth:`hcss_evaluate.posterior.priors.Prior.parse`.
    values : ndarray (n,)

    Returns
    -------
    ndarray (n,) or None
        None if the text is not a prior.
    """
    low, high = -math.inf, math.inf
    kind = KINDS.get(name.removeprefix("mean_"))
    if name.startswith("spread_"):
        low = 0.0
    elif kind is not None:
        low, high = kind.low, kind.high
    try:
        return Prior.parse(name, text, low, high).density(values)
    except PosteriorError:
        return None


def corner_plot(draws: Mapping[str, Array]) -> Figure:
    """Draw a corner plot of all parameters.

    Parameters
    ----------
    draws : mapping of str to ndarray (n,)
        At least one parameter.
    """
    names = list(draws)
    count = len(names)
    side = max(3.2, 1.75 * count + 0.5)
    figure = Figures.new(side, side)
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
    """Return the range of all but a thousandth of the draws, with a margin."""
    low, high = (float(quantile) for quantile in np.quantile(values, (0.0005, 0.9995)))
    margin = 0.04 * (high - low) or max(abs(low), 1.0) * 1e-3
    return low - margin, high + margin


def _histogram(axis: Axes, values: Array, limits: tuple[float, float]) -> None:
    axis.hist(values, _BINS, range=limits, density=True, color=_BLUE, alpha=0.3, histtype="stepfilled")
    for quantile, value in zip(QUANTILES, np.quantile(values, QUANTILES), strict=True):
        axis.axvline(value, color=_BLUE, lw=1.0, ls="-" if quantile == 0.5 else "--")
    axis.set_yticks([])


def _density(axis: Axes, x: Array, y: Array, limits_x: tuple[float, float], limits_y: tuple[float, float]) -> None:
    from scipy.ndimage import gaussian_filter

    counts, edges_x, edges_y = np.histogram2d(x, y, _BINS, range=(limits_x, limits_y))
    extent = (*limits_x, *limits_y)
    axis.imshow(counts.T, origin="lower", extent=extent, aspect="auto", cmap="Blues", interpolation="nearest")
    # the histogram is noisy, so the contours use a smoothed density
    smooth = gaussian_filter(counts.T, 1.2)
    centres = [0.5 * (edges[1:] + edges[:-1]) for edges in (edges_x, edges_y)]
    levels = mass_levels(smooth, MASSES)
    if len(levels) == len(MASSES):
        axis.contour(*centres, smooth, levels=levels, colors=_BLUE, linewidths=1.0, linestyles=("--", "-"))
    axis.set_ylim(limits_y)


def mass_levels(density: Array, masses: tuple[float, ...]) -> list[float]:
    """Return the density levels that enclose these fractions, ascending and without duplicates."""
    ordered = np.sort(density.ravel())[::-1]
    share = np.cumsum(ordered) / ordered.sum()
    return sorted({float(ordered[min(int(np.searchsorted(share, mass)), share.size - 1)]) for mass in masses})


def traces(values: Mapping[str, Array]) -> Figure:
    """Draw the steps of some walkers, one panel for each parameter, values (chain, step)."""
    figure, axes = Figures.panels(len(values), 1.25)
    for axis, (name, chains) in zip(axes, values.items(), strict=True):
        step = max(1, -(-chains.shape[0] // DRAWN_WALKERS))
        # rasterised, because lines with thousands of vertices would be far larger
        axis.plot(chains[::step].T, lw=0.5, alpha=0.6, rasterized=True)
        axis.set_ylabel(name, fontsize=Figures.LETTERS)
        axis.set_xlim(0, max(1, chains.shape[1] - 1))
    axes[-1].set_xlabel("step", fontsize=Figures.LETTERS)
    figure.set_dpi(150)
    return figure


def prior_and_posterior(name: str, draws: Array, prior: str) -> Figure:
    """Draw the histogram of a parameter's draws and the density of its prior."""
    figure, (axis,) = Figures.panels(1, 2.1)
    axis.hist(draws, 50, density=True, color=Figures.INK, alpha=0.45, label="posterior")
    low, high = draws.min(), draws.max()
    wide = 0.5 * (high - low) or max(abs(low), 1.0) * 0.01
    grid = np.linspace(low - wide, high + wide, _POINTS)
    density = prior_density(name, prior, grid)
    if density is not None:
        axis.plot(grid, density, color=_PRIOR, lw=1.4, label="prior")
    axis.set_xlim(grid[0], grid[-1])
    axis.set_xlabel(name, fontsize=Figures.LETTERS)
    axis.set_ylabel("density", fontsize=Figures.LETTERS)
    axis.legend(fontsize=Figures.LETTERS - 1, frameon=False)
    return figure


def of_images(name: str, draws: Array) -> Figure:
    """Draw the median and 90 % interval of a parameter for each image; draws are (chain, draw, image)."""
    flat = draws.reshape(-1, draws.shape[2])
    low, middle, high = np.quantile(flat, QUANTILES, axis=0)
    count = flat.shape[1]
    figure = Figures.new(Figures.WIDTH_IN, max(2.2, min(0.25 * count + 0.9, 9.0)))
    axis = figure.subplots()
    Figures.plain(axis)
    rows = np.arange(count)
    axis.errorbar(middle, rows, xerr=(middle - low, high - middle), fmt="o", color=Figures.INK, ms=4, lw=1.2)
    axis.set_yticks(rows if count <= 30 else rows[:: -(-count // 30)])
    axis.invert_yaxis()
    axis.set_xlabel(name, fontsize=Figures.LETTERS)
    axis.set_ylabel("image", fontsize=Figures.LETTERS)
    return figure


def variogram(variogram: Variogram, image: int) -> Figure:
    """Draw the observed and the predicted variogram along each axis."""
    figure, axes = Figures.panels(len(variogram.axes), 2.2)
    outer = (0, len(variogram.quantiles) - 1)
    for number, (axis, name) in enumerate(zip(axes, variogram.axes, strict=True)):
        known = np.isfinite(variogram.observed[image, :, number])
        lag = variogram.lag[known]
        predicted = variogram.predicted[:, image, known, number]
        share = 100.0 * (variogram.quantiles[outer[1]] - variogram.quantiles[outer[0]])
        axis.fill_between(
            lag,
            predicted[outer[0]],
            predicted[outer[1]],
            color=Figures.INK,
            alpha=0.2,
            lw=0,
            label=f"predicted, {share:.3g} %",
        )
        middle = int(np.argmin(np.abs(variogram.quantiles - 0.5)))
        axis.plot(
            lag,
            predicted[middle],
            color=Figures.INK,
            lw=1.3,
            label=f"predicted, quantile {variogram.quantiles[middle]:g}",
        )
        axis.errorbar(
            lag,
            variogram.observed[image, known, number],
            yerr=variogram.error[image, known, number],
            fmt="o",
            color=_OBSERVED,
            ms=3.5,
            lw=1.0,
            label="observed",
        )
        if lag.size and lag.min() > 0 and predicted.min() > 0.0:  # power laws of the lag are straight lines
            axis.set_xscale("log")
            axis.set_yscale("log")
        axis.set_title(f"along {name}", fontsize=Figures.LETTERS, loc="left")
        axis.set_ylabel("semivariance", fontsize=Figures.LETTERS)
    axes[0].legend(fontsize=Figures.LETTERS - 1, frameon=False)
    axes[-1].set_xlabel("lag (pixels)", fontsize=Figures.LETTERS)
    return figure
