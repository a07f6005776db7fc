"""Histograms, spectra and course over time of what a sensor sees, and their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.report.cube_report.series import Series
from hcss_twin.report.page.page import Markup, beside, element, joined, table
from hcss_twin.report.page.pictures import drawing

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


DRAWN_BANDS = 8
"""Bands in one figure; the table has all."""

INK = "#1f4e79"
WIDTH_IN = 4.7
LETTERS = 9


def numbers_table(series: Sequence[Series]) -> Markup:
    """Return mean, lowest and highest value of every quantity in every band, over the shown frames."""
    rows = []
    for one in series:
        known = [each for each in one.numbers if not np.isnan(each.mean)]
        values = ["none"] * 3
        if known:
            values = [
                f"{np.mean([each.mean for each in known]):.5g}",
                f"{min(each.lowest for each in known):.5g}",
                f"{max(each.highest for each in known):.5g}",
            ]
        rows.append([one.quantity.label, one.part, str(len(one.frames)), *values, one.quantity.units])
    shown = table(
        ["quantity", "band or layer", "frames", "mean", "lowest", "highest", "unit"],
        rows,
        "Over the frames shown above; the mean is that of the frames' means.",
        text_columns=2,
    )
    return element("div", shown, class_="nowrap")


def curves(dataset: xr.Dataset, series: Sequence[Series], window: tuple[int, int]) -> Markup:
    """Return the figures of every quantity that has a histogram.

    Parameters
    ----------
    dataset : Dataset
        The cube, for its times.
    series : sequence of Series
    window : (int, int)
        Rows and columns in the middle of the frame that spectra are of.
    """
    # kinds of curves below each other, so that those of radiance and temperature stand side by side
    kinds: list[list[Markup]] = [[], [], []]
    names = list(dict.fromkeys(one.quantity.name for one in series if one.histogram is not None))
    for name in names:
        group = [one for one in series if one.quantity.name == name and one.histogram is not None]
        shown, rest = group[:DRAWN_BANDS], len(group) - DRAWN_BANDS
        more = f" The first {DRAWN_BANDS} of {len(group)} bands." if rest > 0 else ""
        alike = [one.part for one in series if one.quantity.name == name and one.histogram is None]
        if alike:
            more += f" Without {', '.join(alike)}, where all pixels have one value."
        label = group[0].quantity.label
        count = len(group[0].frames)
        frames = "one frame" if count == 1 else f"{count} frames"
        kinds[0].append(
            drawing(_histograms(shown), f"histograms of {label}", f"Histograms of {label}, pixels of {frames}.{more}")
        )
        if any(one.spectrum is not None for one in shown):
            told = (
                f"Power spectra of {label}, averaged over directions and {frames}: the middle {window[0]} x "
                f"{window[1]} pixels less their plane, tapered.{more}"
            )
            kinds[1].append(drawing(_spectra(shown), f"power spectra of {label}", told))
        if count > 1:
            told = f"Mean of {label} over the frame; the band spans the lowest to the highest pixel.{more}"
            kinds[2].append(drawing(_course(dataset, shown), f"{label} over time", told))
    drawn = [figure for kind in kinds for figure in kind]
    return beside(*drawn) if drawn else joined([])


def panels(count: int, height_in: float = 1.5) -> tuple[Figure, list[Axes]]:
    """Return a figure of panels below each other, readable on a phone."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH_IN, max(2.6, height_in * count + 0.5)), layout="constrained")
    axes = figure.subplots(count, 1, squeeze=False)[:, 0]
    for axis in axes:
        plain(axis)
    return figure, list(axes)


def plain(axis: Any) -> None:
    """Give axes the letters and lines of all figures."""
    axis.tick_params(labelsize=LETTERS - 1)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(color="#e3e8ed", linewidth=0.6)
    axis.set_axisbelow(True)


def axis_label(text: str, units: str) -> str:
    """Return a label with its unit."""
    return f"{text} ({units})" if units else text


def _histograms(group: Sequence[Series]) -> Figure:
    figure, axes = panels(len(group))
    for axis, one in zip(axes, group, strict=True):
        assert one.histogram is not None
        counts, edges = one.histogram
        axis.stairs(100.0 * counts / counts.sum(), edges, fill=True, color=INK, alpha=0.75)
        axis.set_yscale("log")
        axis.minorticks_off()
        axis.set_title(one.part, fontsize=LETTERS, loc="left")
        axis.set_ylabel("% of pixels", fontsize=LETTERS)
    axes[-1].set_xlabel(axis_label(group[0].quantity.label, group[0].quantity.units), fontsize=LETTERS)
    return figure


def _spectra(group: Sequence[Series]) -> Figure:
    figure, (axis,) = panels(1, 3.0)
    for number, one in enumerate(group):
        if one.spectrum is None:
            continue
        style = ("-", "--", "-.", ":")[number % 4]
        axis.loglog(one.spectrum.cycles_per_km, one.spectrum.power, style, label=one.part, lw=1.3)
    axis.minorticks_off()
    axis.set_xlabel("wavenumber (cycles per km)", fontsize=LETTERS)
    units = group[0].quantity.units
    axis.set_ylabel(f"power (({units})² km²)" if units else "power (km²)", fontsize=LETTERS)
    axis.legend(fontsize=LETTERS - 1, frameon=False)
    return figure


def _course(dataset: xr.Dataset, group: Sequence[Series]) -> Figure:
    figure, axes = panels(len(group))
    times = dataset["time"].to_numpy()
    for axis, one in zip(axes, group, strict=True):
        seconds = (times[list(one.frames)] - times[0]) / np.timedelta64(1, "ns") * 1e-9
        lowest, highest, mean = (
            [getattr(each, name) for each in one.numbers] for name in ("lowest", "highest", "mean")
        )
        axis.fill_between(seconds, lowest, highest, color=INK, alpha=0.15, lw=0)
        axis.plot(seconds, mean, "o-", color=INK, ms=3, lw=1.2)
        axis.set_title(one.part, fontsize=LETTERS, loc="left")
        axis.set_ylabel(one.quantity.units, fontsize=LETTERS)
    axes[-1].set_xlabel("time (s)", fontsize=LETTERS)
    return figure
