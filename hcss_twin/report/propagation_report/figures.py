"""Distributions of draws, and bars of the shares of their variance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.report.cube_report.curves import INK, LETTERS, WIDTH_IN, axis_label, panels, plain
from hcss_twin.report.propagation_report.tables import Contents

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DRAWN_CLASSES = 5
"""Classes in one figure; tables have all."""

_MARKS = "#b3261e"
_COLOURS = ("#9aa5b1", "#3d8fc6", "#e0a03a", "#6b9e4f", "#8a4f9e")
_BAR_IN = 0.15
_LONGEST_NAME = 20


def distributions(columns: Sequence[tuple[str, Array, Sequence[float]]], label: str, counted: str = "scenes") -> Figure:
    """Draw histograms of draws below each other.

    Parameters
    ----------
    columns : sequence of (str, ndarray (n,), sequence of float)
        Name, values of all draws (those that are no number are left out), and quantiles to be marked.
    label : str
        What the values are, below all of them; panels have scales of their own.
    counted : str
        What there is a value of.
    """
    figure, axes = panels(len(columns), 1.15)
    for axis, (name, values, marks) in zip(axes, columns, strict=True):
        known = values[np.isfinite(values)]
        axis.set_title(name, fontsize=LETTERS, loc="left")
        axis.set_ylabel(counted, fontsize=LETTERS)
        if not known.size:
            axis.text(0.5, 0.5, "in no draw", transform=axis.transAxes, ha="center", fontsize=LETTERS)
            axis.set_xticks([])
            axis.set_yticks([])
            continue
        # Where nothing varies but by rounding the bar has a width of its own.
        level, width = float(known.mean()), float(np.ptp(known))
        least = 1e-6 * max(abs(level), 1e-12)
        ends = (known.min(), known.max()) if width > least else (level - 500 * least, level + 500 * least)
        bins = int(np.clip(np.sqrt(known.size) * 1.5, 6, 40))
        axis.hist(known, bins, range=ends, color=INK, alpha=0.6)
        for mark in marks:
            if np.isfinite(mark):
                axis.axvline(mark, color=_MARKS, lw=1.0)
        axis.locator_params(axis="y", nbins=3, integer=True)
        axis.locator_params(axis="x", nbins=6)
        axis.ticklabel_format(axis="x", useOffset=False, style="plain")
        if level and abs(level) < 1e-3:
            axis.ticklabel_format(axis="x", style="sci", scilimits=(0, 0))
    axes[-1].set_xlabel(label, fontsize=LETTERS)
    return figure


def draws_of_band(found: Contents, name: str, band: int, quantiles: Sequence[int]) -> Figure:
    """Draw the class means of all scenes of the draws with both seeds, and some quantiles."""
    data = found.dataset
    columns = [
        (
            kind,
            np.asarray(data[name].values[:2, :, band, place], dtype=np.float64).ravel(),
            [float(data[f"{name}_quantile"].values[each, band, place]) for each in quantiles],
        )
        for place, kind in enumerate(found.classes[:DRAWN_CLASSES])
    ]
    label = axis_label(name.replace("_", " "), str(data[name].attrs.get("units", "")))
    return distributions(columns, f"mean {label}, {found.bands[band]}")


def shares_of_band(found: Contents, name: str, band: int) -> Figure:
    """Draw the share of each source in the variance, by class: bars are first-order, diamonds total shares."""
    from matplotlib.figure import Figure

    data = found.dataset
    classes = found.classes[:DRAWN_CLASSES]
    sources = [place for place in range(len(found.sources)) if found.orders(place)]
    step = len(classes) + 1.2
    figure = Figure(figsize=(WIDTH_IN, _BAR_IN * step * len(sources) + 1.1), layout="constrained")
    axis = figure.subplots()
    plain(axis)
    for kind, colour in zip(range(len(classes)), _COLOURS, strict=False):
        for order in ("first_order", "total"):
            rows = [row for row, source in enumerate(sources) if order in found.orders(source)]
            at = np.array([row * step + kind for row in rows], dtype=np.float64)
            place = [sources[row] for row in rows]
            value, error = (data[f"{name}_{order}{end}"].values[place, band, kind] for end in ("", "_error"))
            known = np.isfinite(value)
            spread = np.where(np.isfinite(error), error, 0.0)
            if not known.any():
                continue
            if order == "first_order":
                axis.barh(at[known], value[known], height=0.86, color=colour, label=classes[kind])
            style = {"fmt": "none"} if order == "first_order" else {"fmt": "D", "mfc": "white", "ms": 4}
            axis.errorbar(value[known], at[known], xerr=spread[known], ecolor="#1c2733", mec=colour, lw=0.9, **style)
    axis.axvline(0.0, color="#5b6875", lw=0.8)
    middle = 0.5 * (len(classes) - 1)
    axis.set_yticks(
        [row * step + middle for row in range(len(sources))], [_broken(found.sources[source]) for source in sources]
    )
    axis.invert_yaxis()
    low, high = axis.get_xlim()
    axis.set_xlim(min(low, -0.05), max(high, 1.05))
    axis.set_xlabel(f"share of the variance of mean {name.replace('_', ' ')}", fontsize=LETTERS)
    figure.suptitle(found.bands[band], fontsize=LETTERS, x=0.01, ha="left")
    handles, labels = axis.get_legend_handles_labels()
    if not handles:
        return figure
    figure.legend(
        handles, labels, loc="outside upper right", ncols=len(labels), fontsize=LETTERS - 2, frameon=False,
        handlelength=0.8, columnspacing=0.8,
    )  # fmt: skip
    return figure


def _broken(name: str) -> str:
    """Break a long dotted name into two lines."""
    head, point, tail = name.rpartition(".")
    return f"{head}{point}\n{tail}" if len(name) > _LONGEST_NAME and point else name
