"""Traces, priors beside posteriors, parameters of several images, and the predicted variogram."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcss_twin.reporting.cube_report.curves import INK, LETTERS, WIDTH_IN, panels, plain
from hcss_twin.reporting.posterior_report.contents import Variogram
from hcss_twin.reporting.posterior_report.corner_plot import QUANTILES
from hcss_twin.reporting.posterior_report.prior_density import prior_density

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

DRAWN_WALKERS = 24
DRAWN_IMAGES = 6
_PRIOR, _SEEN = "#b3261e", "#222222"
_POINTS = 400


def traces(values: Mapping[str, Array]) -> Figure:
    """Draw the steps of some walkers, one panel for each parameter, values (chain, step)."""
    figure, axes = panels(len(values), 1.25)
    for axis, (name, chains) in zip(axes, values.items(), strict=True):
        step = max(1, -(-chains.shape[0] // DRAWN_WALKERS))
        # a picture within the drawing: thousands of corners would be far larger as lines
        axis.plot(chains[::step].T, lw=0.5, alpha=0.6, rasterized=True)
        axis.set_ylabel(name, fontsize=LETTERS)
        axis.set_xlim(0, max(1, chains.shape[1] - 1))
    axes[-1].set_xlabel("step", fontsize=LETTERS)
    figure.set_dpi(150)
    return figure


def prior_and_posterior(name: str, draws: Array, prior: str) -> Figure:
    """Draw the histogram of a parameter's draws and the density of its prior."""
    figure, (axis,) = panels(1, 2.1)
    axis.hist(draws, 50, density=True, color=INK, alpha=0.45, label="posterior")
    low, high = draws.min(), draws.max()
    wide = 0.5 * (high - low) or max(abs(low), 1.0) * 0.01
    grid = np.linspace(low - wide, high + wide, _POINTS)
    density = prior_density(name, prior, grid)
    if density is not None:
        axis.plot(grid, density, color=_PRIOR, lw=1.4, label="prior")
    axis.set_xlim(grid[0], grid[-1])
    axis.set_xlabel(name, fontsize=LETTERS)
    axis.set_ylabel("density", fontsize=LETTERS)
    axis.legend(fontsize=LETTERS - 1, frameon=False)
    return figure


def of_images(name: str, draws: Array) -> Figure:
    """Draw median and 90 % interval of a parameter of each image; draws are (chain, draw, image)."""
    from matplotlib.figure import Figure

    flat = draws.reshape(-1, draws.shape[2])
    low, middle, high = np.quantile(flat, QUANTILES, axis=0)
    count = flat.shape[1]
    figure = Figure(figsize=(WIDTH_IN, max(2.2, min(0.25 * count + 0.9, 9.0))), layout="constrained")
    axis = figure.subplots()
    plain(axis)
    rows = np.arange(count)
    axis.errorbar(middle, rows, xerr=(middle - low, high - middle), fmt="o", color=INK, ms=4, lw=1.2)
    axis.set_yticks(rows if count <= 30 else rows[:: -(-count // 30)])
    axis.invert_yaxis()
    axis.set_xlabel(name, fontsize=LETTERS)
    axis.set_ylabel("image", fontsize=LETTERS)
    return figure


def variogram(found: Variogram, image: int) -> Figure:
    """Draw what was observed over what the posterior predicts, along each axis."""
    figure, axes = panels(len(found.axes), 2.2)
    outer = (0, len(found.quantiles) - 1)
    for number, (axis, name) in enumerate(zip(axes, found.axes, strict=True)):
        known = np.isfinite(found.observed[image, :, number])
        lag = found.lag[known]
        predicted = found.predicted[:, image, known, number]
        share = 100.0 * (found.quantiles[outer[1]] - found.quantiles[outer[0]])
        axis.fill_between(
            lag,
            predicted[outer[0]],
            predicted[outer[1]],
            color=INK,
            alpha=0.2,
            lw=0,
            label=f"predicted, {share:.3g} %",
        )
        middle = int(np.argmin(np.abs(found.quantiles - 0.5)))
        axis.plot(
            lag,
            predicted[middle],
            color=INK,
            lw=1.3,
            label=f"predicted, quantile {found.quantiles[middle]:g}",
        )
        axis.errorbar(
            lag,
            found.observed[image, known, number],
            yerr=found.error[image, known, number],
            fmt="o",
            color=_SEEN,
            ms=3.5,
            lw=1.0,
            label="observed",
        )
        if lag.size and lag.min() > 0 and predicted.min() > 0.0:  # powers of the lag are straight lines
            axis.set_xscale("log")
            axis.set_yscale("log")
        axis.set_title(f"along {name}", fontsize=LETTERS, loc="left")
        axis.set_ylabel("semivariance", fontsize=LETTERS)
    axes[0].legend(fontsize=LETTERS - 1, frameon=False)
    axes[-1].set_xlabel("lag (pixels)", fontsize=LETTERS)
    return figure
