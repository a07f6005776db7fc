"""Picture of run time against error: the front that can be had, and peers as points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.benchmarking.bench import BenchResult
from hcss_twin.benchmarking.stages import KEPT_RUN, NEW_RUN
from hcss_twin.drafts import draft_of
from hcss_twin.errors import HcssError

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
    with draft_of(path, HcssError) as draft:
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
