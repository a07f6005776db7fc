"""Figures of a comparison with a real image."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.result import Evaluation, Side
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


REAL, SIMULATED = "#222222", "#d1495b"
MISSING = "#9dc3e6"
"""Colour of pixels without a value, distinct from grey."""

PIXELS_SHOWN = 700
"""Longest side of a drawn image in pixels; larger images are thinned for drawing only."""

_STYLES = (("real", REAL, "o-"), ("simulated", SIMULATED, "^--"))
_SMALL = 8


def draw_values(evaluation: Evaluation, side: Side) -> Figure:
    """Draw the values of a side's frame on a grey scale common to both sides; cloud is bright."""
    low, high = float(evaluation.edges[0]), float(evaluation.edges[-1])
    label = Figures.axis_label(evaluation.quantity, evaluation.unit)
    bright = side.bright_is_cloud or evaluation.quantity.startswith("grey level")
    return _image(side.pictured.values, side, "gray" if bright else "gray_r", (low, high), label)


def draw_levels(side: Side) -> Figure:
    """Draw the grey levels used in eqs 21 to 23."""
    level = np.where(side.pictured.known, side.pictured.level, np.nan)
    return _image(level, side, "gray", (0.0, 255.0), "grey level: 0 clear, 1 to 255 cloud")


def _image(values: NDArray[Any], side: Side, colours: str, limits: tuple[float, float], label: str) -> Figure:
    from matplotlib import colormaps

    rows, columns = values.shape
    ratio = min(max(rows / columns, 0.3), 1.8)
    figure = Figures.new(5.4, 0.5 + 3.75 * ratio)
    axes = figure.subplots()
    step = max(1, -(-max(rows, columns) // PIXELS_SHOWN))
    scale = colormaps[colours].with_extremes(bad=MISSING)
    km = None if side.pixel_size_m is None else side.pixel_size_m / 1e3
    size = 1.0 if km is None else km
    shown = axes.imshow(
        values[::step, ::step],
        extent=(0.0, columns * size, 0.0, rows * size),
        origin="lower",
        cmap=scale,
        vmin=limits[0],
        vmax=limits[1],
        interpolation="nearest",
    )
    axes.set_xlabel("x (pixels)" if km is None else "x (km, east)", fontsize=_SMALL)
    axes.set_ylabel("y (pixels)" if km is None else "y (km, north)", fontsize=_SMALL)
    axes.tick_params(labelsize=_SMALL)
    # As high as the image.
    bar = figure.colorbar(shown, ax=axes, fraction=0.046 * rows / columns, pad=0.03)
    bar.set_label(label, fontsize=_SMALL)
    bar.ax.tick_params(labelsize=_SMALL)
    return figure


def draw_pairs(side: Side, most: float) -> Figure:
    """Draw the 2-D histogram of horizontal neighbours on a log scale up to ``most``, a fraction of all pairs."""
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    pairs = side.pictured.pairs
    share = pairs / max(1, int(pairs.sum()))
    figure = Figures.new(5.4, 4.7)
    axes = figure.subplots()
    # Right neighbour upward; empty bins stay white.
    shown = axes.imshow(
        np.where(share > 0.0, share, np.nan).T,
        origin="lower",
        cmap=colormaps["viridis"].with_extremes(bad="white"),
        norm=LogNorm(1e-6, max(most, 1e-5)),
        extent=(-0.5, 255.5, -0.5, 255.5),
        interpolation="nearest",
    )
    axes.set_xlabel("grey level g of a pixel (0 clear)", fontsize=_SMALL)
    axes.set_ylabel("grey level g' of its right neighbour", fontsize=_SMALL)
    axes.tick_params(labelsize=_SMALL)
    bar = figure.colorbar(shown, ax=axes, shrink=0.9)
    bar.set_label("share of all pairs", fontsize=_SMALL)
    bar.ax.tick_params(labelsize=_SMALL)
    return figure


def draw_histograms(evaluation: Evaluation) -> tuple[Figure, Figure]:
    """Draw the histograms and cumulative histograms of values."""
    name = Figures.axis_label(evaluation.quantity, evaluation.unit)
    width = float(evaluation.edges[1] - evaluation.edges[0])
    counted, summed = Figures.new(5.4, 3.8), Figures.new(5.4, 3.8)
    axes, sums = counted.subplots(), summed.subplots()
    for (label, colour, style), side in zip(_STYLES, (evaluation.real, evaluation.sim), strict=True):
        line = style[1:]
        axes.stairs(side.histogram / width, evaluation.edges, color=colour, lw=1.6, label=label, fill=False, ls=line)
        sums.plot(evaluation.edges, np.concatenate(([0.0], np.cumsum(side.histogram))), line, color=colour, label=label)
    if any(side.histogram.max() > 0.5 for side in (evaluation.real, evaluation.sim)):
        axes.set_yscale("log")
    axes.set_ylabel(f"share of pixels per {evaluation.unit or 'level'}", fontsize=_SMALL)
    sums.set_ylabel("share of pixels up to here", fontsize=_SMALL)
    for axis in (axes, sums):
        _finish(axis, name)
    return counted, summed


def draw_spectra(evaluation: Evaluation) -> list[Figure]:
    """Draw the radial spectra per pixel, and per kilometre if both pixel sizes are known and differ."""
    sides = [side for side in (evaluation.real, evaluation.sim) if side.spectrum is not None]
    if not sides:
        return []
    sizes = [side.pixel_size_m for side in (evaluation.real, evaluation.sim) if side.pixel_size_m is not None]
    scales = [False]
    if len(sizes) == 2 and max(sizes) > 1.01 * min(sizes):
        scales.append(True)
    unit = f"{evaluation.unit}²" if evaluation.unit else "levels²"
    figures = []
    for by_km in scales:
        figure = Figures.new(5.4, 3.8)
        axes = figure.subplots()
        for (label, colour, style), side in zip(_STYLES, (evaluation.real, evaluation.sim), strict=True):
            if side.spectrum is None:
                continue
            km = (side.pixel_size_m or 0.0) / 1e3 if by_km else 1.0
            wavenumber, power = side.spectrum.wavenumber / km, side.spectrum.power * km**2
            axes.loglog(wavenumber, power, style, color=colour, ms=3.5, lw=1.2, label=label)
        cycle = "km" if by_km else "pixel"
        axes.set_ylabel(f"power ({unit} per (cycle per {cycle})²)", fontsize=_SMALL)
        _finish(axes, f"wavenumber (cycles per {cycle})")
        figures.append(figure)
    return figures


def draw_directions(evaluation: Evaluation) -> Figure | None:
    """Draw relative power by direction (1: isotropic); None if neither side has a spectrum."""
    sides = (evaluation.real, evaluation.sim)
    if all(side.spectrum is None or np.isnan(side.spectrum.by_direction).any() for side in sides):
        return None
    from matplotlib.ticker import MaxNLocator

    figure = Figures.new(4.6, 4.4)
    axes = figure.add_subplot(projection="polar")
    for (label, colour, style), side in zip(_STYLES, sides, strict=True):
        if side.spectrum is None:
            continue
        angle = np.radians(side.spectrum.direction_deg)
        # Opposite wave directions are equivalent.
        around = np.concatenate([angle, angle + math.pi, angle[:1]])
        power = np.concatenate([side.spectrum.by_direction] * 2 + [side.spectrum.by_direction[:1]])
        axes.plot(around, power, style, color=colour, ms=3, lw=1.2, label=label)
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.tick_params(labelsize=_SMALL)
    axes.legend(fontsize=_SMALL, loc="upper right", bbox_to_anchor=(1.12, 1.1))
    return figure


def draw_correlation(evaluation: Evaluation) -> Figure | None:
    """Draw the correlation over time; None if neither side has several frames."""
    sides = [side.temporal for side in (evaluation.real, evaluation.sim)]
    if all(correlation is None for correlation in sides):
        return None
    timed = all(correlation is None or not np.isnan(correlation.lag_s).any() for correlation in sides)
    figure = Figures.new(5.4, 3.6)
    axes = figure.subplots()
    for (label, colour, style), correlation in zip(_STYLES, sides, strict=True):
        if correlation is not None:
            lags = correlation.lag_s if timed else correlation.lag
            axes.plot(lags, correlation.correlation, style, color=colour, ms=4, lw=1.2, label=label)
    axes.axhline(1.0 / math.e, color="0.6", lw=0.7)
    axes.text(0.99, 1.0 / math.e, "1/e", transform=axes.get_yaxis_transform(), fontsize=7, ha="right", va="bottom")
    axes.set_ylim(min(-0.05, axes.get_ylim()[0]), 1.05)
    axes.set_ylabel("correlation of frames", fontsize=_SMALL)
    _finish(axes, "time between them (s)" if timed else "frames between them")
    return figure


def draw_frames(evaluation: Evaluation) -> Iterator[tuple[str, Figure]]:
    """Yield plots of the metrics of eq 24 and the coverage for every frame, each with its name."""
    measures = (
        ("EV (bit)", "entropy"),
        ("Den", "density"),
        ("DP, printed", "diagonal_peak"),
        ("FD", "fractal_dimension"),
        ("coverage", "coverage"),
    )
    sequences = [side.frames for side in (evaluation.real, evaluation.sim) if len(side.frames) > 1]
    timed = not any(math.isnan(frame.seconds) for frames in sequences for frame in frames)
    for name, field in measures:
        figure = Figures.new(5.4, 2.5)
        axes = figure.subplots()
        for (label, colour, style), side in zip(_STYLES, (evaluation.real, evaluation.sim), strict=True):
            values = [getattr(frame.measures.morphology, field) for frame in side.frames]
            if len(values) == 1:
                axes.axhline(values[0], color=colour, lw=1.2, label=label)
                continue
            at = [frame.seconds for frame in side.frames] if timed else range(len(values))
            axes.plot(at, values, style, color=colour, ms=4, lw=1.2, label=label)
        axes.set_ylabel(name, fontsize=_SMALL)
        axes.ticklabel_format(axis="y", useOffset=False)
        _finish(axes, "time after the first frame (s)" if timed else "frame")
        yield name, figure


def _finish(axes: Axes, label: str) -> None:
    axes.set_xlabel(label, fontsize=_SMALL)
    axes.tick_params(labelsize=_SMALL)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=_SMALL)
