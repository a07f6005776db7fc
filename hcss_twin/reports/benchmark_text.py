"""Run time versus error, as text for a terminal and as a figure."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import atomic_write
from hcss_twin.reports.benchmark import AccuracyResult, BenchResult
from hcss_twin.reports.benchmark_stages import CERTIFICATE, KEPT_RUN, NEW_RUN, RAW, RUNS, STAGES
from hcss_twin.reports.figures import new_figure
from hcss_twin.reports.tables import aligned

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
    yield from aligned(list(_rows(results)), indent="")
    if any(each.own for each in results):
        yield f"{_OWN} the scenario's own accuracy"
    if any(each.exceeding for each in results):
        yield f"{_MISSED} pixels that exceed the requested accuracy"
    checked = " to ".join(str(count) for count in sorted({each.checked for each in results}))
    yield f"error: of {checked} random pixels relative to the reference; whole runs exclude the certificate"
    yield ""
    yield (
        f"brute force, the spectrum of every point integrated: timed on {result.timed_points} points and scaled to "
        f"{result.points}, without one-time computations of the model"
    )
    rows = [["wavenumbers, points at once", "ms per point", "hours", "over raw", "error"]]
    for peer in result.brute_force:
        times = (1e3 * peer.seconds_per_point, peer.seconds / 3600, peer.over_raw)
        error = "reference" if peer.every == 1 else f"{peer.error:.1e}"
        rows.append([f"  {peer.wavenumbers}, {peer.together}", *map(_short, times), error])
    yield from aligned(rows, indent="")


def _rows(results: Sequence[AccuracyResult]) -> Iterator[list[str]]:
    def row(name: str, cell: Callable[[AccuracyResult], str]) -> list[str]:
        return [name, *(cell(each) for each in results)]

    yield row("requested accuracy", lambda each: _requested(each) + (_OWN if each.own else ""))
    if any(_is_kelvin(each) for each in results):
        yield row("relative to the radiance", lambda each: f"{each.accuracy:.1e}")
        yield row("error, K", lambda each: _error(each, each.achieved_K) if _is_kelvin(each) else "-")
    yield row("error, any band", lambda each: _error(each, each.achieved))
    yield row("error estimate of the tables", lambda each: f"{each.estimated:.1e}")
    yield ["seconds"]
    for stage in (*STAGES, CERTIFICATE, *RUNS, RAW):
        yield [f"  {stage}", *(_short(each.seconds[stage]) for each in results)]
    for title, field in (
        ("times as long as writing the same bytes raw", "over_raw"),
        ("times faster than brute force", "over_brute_force"),
    ):
        yield [title]
        for run in RUNS:
            yield [f"  {run}", *(_short(getattr(each, field)[run]) for each in results)]


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


@dataclass(frozen=True)
class Reference:
    """The reference method, which has a time but no error."""

    label: str
    cost: float
    style: str = ":"


def draw_bench(result: BenchResult, path: Path) -> None:
    """Draw the result of ``hcss bench`` into a file that ends in .png, .svg or .pdf.

    Raises
    ------
    HcssError
        If the file cannot be written.
    """
    checked = [each for each in result.accuracies if each.achieved]
    notes = [each.asked if each.asked.endswith("K") else power(each.accuracy) for each in checked]
    error = [each.achieved or 0.0 for each in checked]
    warm, cold = ([each.over_raw[run] for each in checked] for run in (KEPT_RUN, NEW_RUN))
    fewer = [each for each in result.brute_force if each.error > 0]
    curves = [
        Curve(f"{KEPT_RUN}; labels: requested accuracy", warm, error, 0, "-", notes, True),
        Curve(f"{NEW_RUN}; the same labels", cold, error, 1, "-", notes),
        Curve(
            "every pixel integrated; labels: number of wavenumbers",
            [each.over_raw for each in fewer],
            [each.error for each in fewer],
            5,
            "",
            [str(each.wavenumbers) for each in fewer],
            True,
        ),
    ]
    references = []
    for each in result.brute_force:
        if each.every == 1:
            together, style = ("one by one", "--") if each.together == 1 else (f"{each.together} at once", ":")
            label = f"the same at all {each.wavenumbers}, {together}: the reference"
            references.append(Reference(label, each.over_raw, style))
    figure = new_figure(9.0, 6.6)
    axes = figure.add_subplot()
    fill_axes(axes, curves, references)
    axes.set_title(textwrap.fill(result.scene, 100), fontsize=9)
    # Below the axes, where it covers no points.
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    with atomic_write(path, HcssError) as draft:
        figure.savefig(draft, dpi=150, format=path.suffix.removeprefix("."))


def fill_axes(axes: Axes, curves: Sequence[Curve], references: Sequence[Reference]) -> None:
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
    for reference in references:
        axes.axvline(reference.cost, color=_COLOURS[-1], linestyle=reference.style, label=reference.label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(x=0.08)
    axes.set_xlabel("time of the whole run over the time of writing the same bytes raw")
    axes.set_ylabel("largest error, relative to the radiance of the band")
    axes.grid(True, which="major", alpha=0.3)


def power(value: float) -> str:
    """Format a power of ten as 1e-3, and other numbers with two digits."""
    text = f"{value:.0e}"
    mantissa, exponent = (text if float(text) == value else f"{value:.1e}").split("e")
    return f"{mantissa}e{int(exponent)}"
