"""Picture of run time against error: the front that can be had, and peers as points.

Run time against error as text for a terminal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import atomic_write
from hcss_twin.report.benchmarking.bench import AccuracyResult, BenchResult
from hcss_twin.report.benchmarking.stages import CERTIFICATE, KEPT_RUN, NEW_RUN, RAW, RUNS, STAGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#8a5fb5", "#c77d0a", "#444444")
_MARKERS = "osD^vP"


@dataclass(frozen=True)
class Curve:
    """Points of one way to the same cube.

    Attributes
    ----------
    label : str
    cost, error : sequence of float
        Time over that of writing the bytes raw; largest relative error. Points without error are left out.
    family : int
        Ways of one family share a colour.
    style : {"-", "--", ""}
        Line through the points; none for peers.
    notes : sequence of str
        Beside each point; empty for none.
    notes_left : bool
        On which side.
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
    """A way that others are measured against: it has a time and no error."""

    label: str
    cost: float
    style: str = ":"


def draw_bench(found: BenchResult, path: Path) -> None:
    """Draw what ``hcss bench`` found; raises HcssError if the file cannot be written."""
    checked = [each for each in found.accuracies if each.achieved]
    notes = [each.asked if each.asked.endswith("K") else power(each.accuracy) for each in checked]
    error = [each.achieved or 0.0 for each in checked]
    kept, new = ([each.over_raw[run] for each in checked] for run in (KEPT_RUN, NEW_RUN))
    curves = [
        Curve(f"{KEPT_RUN}; accuracy asked for beside points", kept, error, 0, "-", notes, True),
        Curve(f"{NEW_RUN}; the same beside points", new, error, 1, "-", notes),
    ]
    fewer = [each for each in found.brute_force if each.error > 0]
    curves.append(
        Curve(
            "every pixel integrated, wavenumbers beside points",
            [each.over_raw for each in fewer],
            [each.error for each in fewer],
            5,
            "",
            [str(each.wavenumbers) for each in fewer],
            True,
        )
    )
    whole = [
        Reference(
            f"the same at all {each.wavenumbers}, {_one_by_one(each.together)}: the reference",
            each.over_raw,
            "--" if each.together == 1 else ":",
        )
        for each in found.brute_force
        if each.every == 1
    ]
    draw_pareto(curves, whole, path, found.scene)


def draw_pareto(curves: Sequence[Curve], references: Sequence[Reference], path: Path, title: str) -> None:
    """Draw run time against error on logarithmic axes.

    Parameters
    ----------
    path : Path
        Ends in .png, .svg or .pdf.

    Raises
    ------
    HcssError
        If the file cannot be written.
    """
    import textwrap

    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.6), layout="constrained")
    axes = figure.add_subplot()
    fill_axes(axes, curves, references)
    axes.set_title("\n".join(textwrap.wrap(title, 100)), fontsize=9)
    # Below the axes, where no point can lie.
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    with atomic_write(path, HcssError) as draft:
        figure.savefig(draft, dpi=150, format=path.suffix.removeprefix("."))


def fill_axes(axes: Axes, curves: Sequence[Curve], references: Sequence[Reference]) -> None:
    """Draw run time against error into given axes."""
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
        for cost, error, note in zip(curve.cost, curve.error, curve.notes, strict=False):
            axes.annotate(
                note,
                (cost, error),
                (-7 if curve.notes_left else 7, 0),
                textcoords="offset points",
                ha="right" if curve.notes_left else "left",
                va="center",
                fontsize=8,
                color=colour,
            )
    for reference in references:
        axes.axvline(reference.cost, color=_COLOURS[-1], linestyle=reference.style, label=reference.label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(x=0.08)
    axes.set_xlabel("time of the whole run over the time of writing the same bytes raw")
    axes.set_ylabel("largest error found, relative to the radiance of the band")
    axes.grid(True, which="major", alpha=0.3)


def power(value: float) -> str:
    """Write a power of ten as 1e-3, and what is none with two digits."""
    text = f"{value:.0e}"
    mantissa, exponent = (text if float(text) == value else f"{value:.1e}").split("e")
    return f"{mantissa}e{int(exponent)}"


def _one_by_one(together: int) -> str:
    return "one by one" if together == 1 else f"{together} at once"


_WIDTH = 34
_CELL = 11
_OWN = "*"
_MISSED = "!"


def bench_text(found: BenchResult) -> str:
    """Return a table with a column for each accuracy, and one of brute force."""
    return "\n".join(_lines(found))


def _lines(found: BenchResult) -> Iterator[str]:
    results = found.accuracies
    yield found.scene
    yield (
        f"medians of {found.rounds} rounds that take turns (tables and certificates: once); "
        "trust ratios, seconds are this machine's of now"
    )
    yield ""
    yield _row("accuracy asked for", [_asked(each) for each in results])
    if any(_is_kelvin(each) for each in results):
        yield _row("as a share of the radiance", [f"{each.accuracy:.1e}" for each in results])
        yield _row("error found, K", [_found_K(each) for each in results])
    yield _row("error found, any band", [_found(each) for each in results])
    yield _row("error the tables estimate", [f"{each.estimated:.1e}" for each in results])
    yield "seconds"
    for stage in (*STAGES, CERTIFICATE, *RUNS, RAW):
        yield _row(f"  {stage}", [_short(each.seconds[stage]) for each in results])
    for title, ratio in _RATIOS:
        yield title
        for run in RUNS:
            yield _row(f"  {run}", [_short(ratio(each)[run]) for each in results])
    if any(each.own for each in results):
        yield f"{_OWN} the scenario's own accuracy"
    if any(each.exceeding for each in results):
        yield f"{_MISSED} pixels that exceed the accuracy asked for"
    checked = sorted({each.checked for each in results})
    yield (
        f"error found: of {' to '.join(map(str, checked))} random pixels against the reference path; whole runs are "
        "without the certificate"
    )
    yield ""
    yield (
        f"brute force, the spectrum of every point integrated: timed on {found.timed_points} points and scaled to "
        f"{found.points}; what the model computes once is left out"
    )
    yield _row("wavenumbers, points at once", ["ms a point", "hours", "over raw", "error"])
    for peer in found.brute_force:
        cells = [
            _short(1e3 * peer.seconds_per_point),
            _short(peer.seconds / 3600),
            _short(peer.over_raw),
            "reference" if peer.every == 1 else f"{peer.error:.1e}",
        ]
        yield _row(f"  {peer.wavenumbers}, {peer.together}", cells)


_RATIOS: tuple[tuple[str, Callable[[AccuracyResult], dict[str, float]]], ...] = (
    ("times as long as writing the same bytes raw", lambda each: each.over_raw),
    ("times faster than brute force", lambda each: each.over_brute_force),
)


def _row(name: str, cells: list[str]) -> str:
    return f"{name:<{_WIDTH}}" + "".join(f"{cell:>{_CELL}}" for cell in cells)


def _is_kelvin(result: AccuracyResult) -> bool:
    return result.asked.endswith("K")


def _asked(result: AccuracyResult) -> str:
    return (result.asked if _is_kelvin(result) else _power(result.accuracy)) + (_OWN if result.own else "")


def _power(value: float) -> str:
    """Write a power of ten as one, other numbers with the digits they have."""
    return f"{value:.0e}" if float(f"{value:.0e}") == value else f"{value:.3g}"


def _found_K(result: AccuracyResult) -> str:
    if not _is_kelvin(result):
        return "-"
    if result.achieved_K is None:
        return "unknown"
    return f"{result.achieved_K:.1e}" + (_MISSED if result.exceeding else "")


def _found(result: AccuracyResult) -> str:
    if result.achieved is None:
        return "unknown"
    return f"{result.achieved:.1e}" + (_MISSED if result.exceeding else "")


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
