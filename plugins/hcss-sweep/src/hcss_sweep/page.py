"""Report page of a sweep: axes, means as functions of each axis, pictures, points, failures, provenance."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_sweep.page_points import PointEntry, PointSummary, Sweep, SweepSummary, opened, read
from hcss_twin.reports.cube_frames import Reader
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.provenance import Provenance
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LISTED = 200
"""Maximum number of points in the table; the index has all."""

_VALUES_LISTED = 12


def sweep_page(path: Path) -> Page:
    """Return the page of a sweep from its folder or its dataset.

    Raises
    ------
    SweepError, CubeError
        If it cannot be read.
    """
    with opened(path) as sweep:
        summary = read(sweep.points)
        sections = [
            Page.Section("Axes", list(_axes(sweep))),
            Page.Section("Against each axis", list(_against(sweep, summary))),
            Page.Section("Pictures", list(_pictures(summary))),
            Page.Section("Points", [_points(sweep, summary)]),
            Page.Section("Failed points", list(_failed(sweep, summary))),
            Page.Section("Provenance", list(_provenance(sweep))),
        ]
        states = [point.state for point in sweep.points]
        counts = ", ".join(
            f"{states.count(state)} {state}" for state in ("done", "failed", "missing", "pending") if state in states
        )
        title = sweep.title or f"Sweep over {', '.join(sweep.keys)}"
        return Page(title, f"Sweep {path.resolve().name}: {len(states)} points, {counts}", sections)


def _axes(sweep: Sweep) -> Iterator[Markup.Block]:
    states = {point.state for point in sweep.points}
    verdict: tuple[str, Markup.Tone] = ("all done", "good")
    if states & {"failed", "missing"}:
        verdict = ("points failed", "bad")
    elif "pending" in states:
        verdict = ("not finished", "fair")
    yield Markup.element("p", Markup.badge(*verdict))
    rows = []
    for key in sweep.keys:
        values = _distinct(sweep, key)
        listed = ", ".join(_text(value) for value in values[:_VALUES_LISTED])
        more = f", ... {_text(values[-1])}" if len(values) > _VALUES_LISTED else ""
        rows.append([key, str(len(values)), listed + more])
    combinations = "All combinations of the values."
    if sweep.combine != "product":
        combinations = "The first values of all keys, then the second."
    caption = f"{combinations} Quantities are in SI units, angles in degrees."
    yield Table(["key", "values", "which"], rows, caption, text_columns=3)


def _distinct(sweep: Sweep, key: str) -> list[Any]:
    values = (point.values.get(key) for point in sweep.points)
    return list({json.dumps(value): value for value in values}.values())


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else json.dumps(value)


def _against(sweep: Sweep, summary: SweepSummary) -> Iterator[Markup.Block]:
    if not summary.points:
        yield Markup.note("No point has a cube.")
        return
    keys = [key for key in sweep.keys if len(_distinct(sweep, key)) > 1]
    if not keys:
        yield Markup.note("No key has more than one value.")
        return
    others = ", the line their mean over all other axes" if len(sweep.keys) > 1 else ", joined by a line"
    pixels = "all pixels" if summary.step == 1 else f"one in {summary.step} rows and columns"
    frames = "the one frame" if summary.frames == 1 else f"up to {Table.frames_text(summary.frames)}, evenly spread"
    count = sum(point.cube is not None for point in sweep.points)
    points = (
        "" if len(summary.points) == count else f" {len(summary.points)} of {count} points, evenly spread, were read."
    )
    yield Markup.paragraph(
        f"Each dot is a point of the sweep{others}. Values are means over {pixels} and {frames}.{points}"
    )
    for key in keys:
        drawn = []
        for name in dict.fromkeys(name for name, _ in summary.columns):
            parts = [part for other, part in summary.columns if other == name][: Figures.DRAWN_BANDS]
            quantity = summary.columns[name, parts[0]]
            words = f"Mean of {quantity.label} against {key}"
            drawn.append(Markup.drawing(_scatter(sweep, summary.points, key, quantity, parts), words, f"{words}."))
        yield Markup.element("h3", key)
        yield Markup.beside(*drawn)


def _scatter(
    sweep: Sweep, summaries: Sequence[PointSummary], key: str, quantity: Reader.Quantity, parts: Sequence[str]
) -> Figure:
    values = _distinct(sweep, key)
    # seeds are unordered, so no line connects their values
    numeric = key != "seed" and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    position_of = {json.dumps(value): float(value) if numeric else float(number) for number, value in enumerate(values)}
    figure, axes = Figures.panels(len(parts))
    for axis, part in zip(axes, parts, strict=True):
        pairs = np.array(
            [
                (position_of[json.dumps(summary.point.values.get(key))], summary.means[quantity.name, part])
                for summary in summaries
                if (quantity.name, part) in summary.means
            ]
        )
        at = np.unique(pairs[:, 0])
        if numeric:
            axis.plot(at, [np.nanmean(pairs[pairs[:, 0] == one, 1]) for one in at], "-", color=Figures.INK, lw=1.3)
        axis.plot(pairs[:, 0], pairs[:, 1], "o", color=Figures.INK, ms=4, alpha=0.5, mew=0)
        axis.set_title(part, fontsize=Figures.LETTERS, loc="left")
        axis.set_ylabel(
            quantity.units if part else Figures.axis_label(quantity.label, quantity.units), fontsize=Figures.LETTERS
        )
        if not numeric:
            step = -(-len(values) // 8)
            labels = [text if len(text) <= 20 else f"{text[:19]}…" for text in map(_text, values[::step])]
            axis.set_xticks(range(0, len(values), step), labels, rotation=20, ha="right")
    axes[-1].set_xlabel(Figures.axis_label(key, ""), fontsize=Figures.LETTERS)
    return figure


def _pictures(summary: SweepSummary) -> Iterator[Markup.Block]:
    if not summary.looks:
        yield Markup.note("There is nothing to show.")
        return
    yield Markup.paragraph("The first frame of some points, evenly spread; one colour scale per band. North is up.")
    for look in summary.looks[: Figures.DRAWN_BANDS]:
        quantity = look.quantity
        name = " ".join(word for word in (quantity.label, quantity.parts[look.part]) if word)
        # images of a sweep may differ in size
        pixels = np.concatenate([plane.ravel() for _, plane in look.planes])[None]
        scale = Reader.scale(quantity, look.part, pixels)
        shown = [
            Markup.picture(scale.png(plane), f"{name}, {_values(point)}", _values(point))
            for point, plane in look.planes
        ]
        yield Markup.element("h3", name)
        yield Markup.element("div", *shown, class_="thumbnails")
        yield Markup.element("div", scale.bar(quantity.units), class_="scale")


def _values(point: PointEntry) -> str:
    return ", ".join(f"{key} {_text(value)}" for key, value in point.values.items())


def _points(sweep: Sweep, summary: SweepSummary) -> Markup.Block:
    read_of = {entry.point.number: entry for entry in summary.points}
    headings = [
        " ".join(word for word in (quantity.label, part, f"({quantity.units})" if quantity.units else "") if word)
        for (_, part), quantity in summary.columns.items()
    ]
    rows = []
    for point in sweep.points[:LISTED]:
        entry = read_of.get(point.number)
        means = [f"{entry.means[column]:.5g}" if entry and column in entry.means else "" for column in summary.columns]
        certificate = (Provenance.badge(entry.certificate) or "none") if entry else ""
        keys = [_text(point.values.get(key)) for key in sweep.keys]
        rows.append([str(point.number), *keys, point.state, certificate, *means])
    caption = f"Means over pixels and frames as above.{_first_of(sweep.points, ' points')}"
    header = ["point", *sweep.keys, "state", "certificate", *headings]
    return Table(header, rows, caption, text_columns=3 + len(sweep.keys))


def _first_of(items: Sequence[object], name: str = "") -> str:
    return f" The first {LISTED} of {len(items)}{name}." if len(items) > LISTED else ""


def _failed(sweep: Sweep, summary: SweepSummary) -> Iterator[Markup.Block]:
    failed = [
        (point, point.error or "reason unknown") for point in sweep.points if point.state in ("failed", "missing")
    ]
    failed += summary.unreadable
    if not failed:
        yield Markup.paragraph("None.")
        return
    rows = [[str(point.number), _values(point), why] for point, why in failed[:LISTED]]
    yield Table(["point", "values", "error"], rows, _first_of(failed).strip(), text_columns=3)


def _provenance(sweep: Sweep) -> Iterator[Markup.Block]:
    yield Markup.facts((name, value) for name, value in sweep.about.items() if value)
    for point in sweep.points:
        if point.cube is not None:
            yield Markup.paragraph(f"Of point {point.number}; others differ in the swept keys.")
            with point.cube() as dataset:
                yield from Provenance.origin(dataset.attrs)
            return
