"""Run time versus error, as text for a terminal and as a figure."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hcss_bench.benchmark import AccuracyResult, BenchResult
from hcss_bench.stages import CERTIFICATE, KEPT_RUN, NEW_RUN, RAW, RUNS, STAGES
from hcss_twin.core.files import Writing
from hcss_twin.providers import HcssError
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_OWN = "*"
_MISSED = "!"


def bench_text(result: BenchResult) -> str:
    """Return a table with one column per accuracy, and a table of brute force."""
    return "\n".join(_lines(result))


def _lines(result: BenchResult) -> Iterator[str]:
    results = result.accuracies
    yield result.scene
    yield (
        f"medians of {result.rounds} rounds that alternate (tables and certificates: once); "
        "compare ratios, because seconds depend on the load of this machine"
    )
    yield ""
    yield from Table.aligned(list(_rows(results)), indent="")
    if any(result.own for result in results):
        yield f"{_OWN} the scenario's own accuracy"
    if any(result.exceeding for result in results):
        yield f"{_MISSED} pixels that exceed the requested accuracy"
    checked = " to ".join(str(count) for count in sorted({result.checked for result in results}))
    yield f"error of the tables: of {checked} random pixels, relative to the same radiance model without tables"
    yield f"error of the result: of {result.timed_points} random pixels, relative to the reference of all models:"
    yield f"  {result.reference}"
    yield "whole runs exclude the certificate"
    yield ""
    yield (
        f"brute force, the spectrum of every point integrated: timed on {result.timed_points} points and scaled to "
        f"{result.points}, without one-time computations of the model"
    )
    rows = [["wavenumbers, points at once", "ms per point", "hours", "over raw", "error"]]
    for peer in result.brute_force:
        times = (1e3 * peer.seconds_per_point, peer.seconds / 3600, peer.over_raw)
        rows.append([f"  {peer.wavenumbers}, {peer.together}", *map(_short, times), f"{peer.error:.1e}"])
    yield from Table.aligned(rows, indent="")


def _rows(results: Sequence[AccuracyResult]) -> Iterator[list[str]]:
    def row(name: str, cell: Callable[[AccuracyResult], str]) -> list[str]:
        return [name, *(cell(result) for result in results)]

    yield row("requested accuracy", lambda result: _requested(result) + (_OWN if result.own else ""))
    if any(_is_kelvin(result) for result in results):
        yield row("relative to the radiance", lambda result: f"{result.accuracy:.1e}")
        yield row(
            "error of the tables, K", lambda result: _error(result, result.achieved_K) if _is_kelvin(result) else "-"
        )
    yield row("error of the tables, any band", lambda result: _error(result, result.achieved))
    yield row("error estimate of the tables", lambda result: f"{result.estimated:.1e}")
    yield row(
        "error of the result, any band", lambda result: "unknown" if result.error is None else f"{result.error:.1e}"
    )
    for band in results[0].by_band:
        yield row(f"  {band}", lambda result, band=band: f"{result.by_band[band]:.1e}")  # type: ignore[misc]
    yield ["seconds"]
    for stage in (*STAGES, CERTIFICATE, *RUNS, RAW):
        yield [f"  {stage}", *(_short(result.seconds[stage]) for result in results)]
    for title, field in (
        ("times as long as writing the same bytes raw", "over_raw"),
        ("times faster than brute force", "over_brute_force"),
    ):
        yield [title]
        for run in RUNS:
            yield [f"  {run}", *(_short(getattr(result, field)[run]) for result in results)]


def _is_kelvin(result: AccuracyResult) -> bool:
    return result.asked.endswith("K")


def _requested(result: AccuracyResult) -> str:
    if _is_kelvin(result):
        return result.asked
    value = result.accuracy
    return f"{value:.0e}" if float(f"{value:.0e}") == value else f"{value:.3g}"


def _error(result: AccuracyResult, value: float | None) -> str:
    return "unknown" if value is None else f"{value:.1e}" + (_MISSED if result.exceeding else "")


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


_COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#8a5fb5", "#c77d0a", "#444444")
_MARKERS = "osD^vP"


@dataclass(frozen=True)
class Curve:
    """Run times and errors of one method for the same cube.

    Attributes
    ----------
    label : str
    cost, error : sequence of float
        Time divided by that of a raw write, and largest relative error. Points without an error are omitted.
    family : int
        Colour group of the method.
    style : {"-", "--", ""}
        Line style through the points; none for independent methods.
    notes : sequence of str
        Label of each point; empty for none.
    notes_left : bool
        Whether the notes are to the left of the points.
    """

    label: str
    cost: Sequence[float]
    error: Sequence[float]
    family: int
    style: str = "-"
    notes: Sequence[str] = ()
    notes_left: bool = False


def draw_bench(found: Mapping[str, BenchResult], path: Path) -> None:
    """Draw the result of ``hcss bench`` into a file that ends in .png, .svg or .pdf.

    Raises
    ------
    HcssError
        If the file cannot be written.
    """
    curves = []
    for family, (model, result) in enumerate(found.items()):
        results = [accuracy for accuracy in result.accuracies if accuracy.error is not None]
        error, notes = [accuracy.error or 0.0 for accuracy in results], [_requested(accuracy) for accuracy in results]
        for run, style in ((KEPT_RUN, "--"), (NEW_RUN, "-")):
            cost = [accuracy.over_raw[run] for accuracy in results]
            curves.append(Curve(f"{model}, {run}", cost, error, family, style, notes if style == "-" else ()))
        runs = [run for run in result.brute_force if run.together == 1 or run.every > 1]
        label = f"{model}, every pixel integrated; labels: wavenumbers"
        cost, error = [run.over_raw for run in runs], [run.error for run in runs]
        curves.append(Curve(label, cost, error, family, "", [str(run.wavenumbers) for run in runs], True))
    figure = Figures.new(9.0, 6.6)
    axes = figure.add_subplot()
    fill_axes(axes, curves)
    first = next(iter(found.values()))
    axes.set_title(textwrap.fill(first.scene, 100), fontsize=9)
    # Below the axes, where it covers no points.
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    with Writing(path, HcssError, "picture") as draft:
        figure.savefig(draft, dpi=150, format=path.suffix.removeprefix("."))


def fill_axes(axes: Axes, curves: Sequence[Curve]) -> None:
    """Plot run time against error in given axes on logarithmic scales."""
    for curve in curves:
        colour, marker = _COLOURS[curve.family % len(_COLOURS)], _MARKERS[curve.family % len(_MARKERS)]
        axes.plot(
            curve.cost,
            curve.error,
            linestyle=curve.style or "none",
            marker=marker,
            color=colour,
            label=curve.label,
            markerfacecolor="white" if curve.style == "--" else colour,
            markersize=6,
        )
        side = -7 if curve.notes_left else 7
        font: dict[str, Any] = {"color": colour, "fontsize": 8, "va": "center", "ha": "right" if side < 0 else "left"}
        for cost, error, note in zip(curve.cost, curve.error, curve.notes, strict=False):
            axes.annotate(note, (cost, error), (side, 0), textcoords="offset points", **font)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(x=0.08)
    known = [error for curve in curves for error in curve.error]
    if known:  # errors of one model differ little, and the scale should show that
        axes.set_ylim(min(known) / 3.0, 3.0 * max(known))
    axes.set_xlabel("time of the whole run over the time of writing the same bytes raw")
    axes.set_ylabel("largest error of the radiance of a band, relative to the reference of all models")
    axes.grid(True, which="major", alpha=0.3)
