"""The page of a sweep."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.report.cube_report.content import Quantity
from hcss_twin.report.cube_report.curves import INK, LETTERS, axis_label, panels
from hcss_twin.report.cube_report.provenance import origin
from hcss_twin.report.cube_report.quality import TONES
from hcss_twin.report.cube_report.scale import Scale
from hcss_twin.report.cube_report.viewer import viewer_style
from hcss_twin.report.page.page import Markup, Page, Section, badge, beside, element, facts, note, paragraph, table
from hcss_twin.report.page.pictures import drawing, picture
from hcss_twin.report.sweep_report.points import Findings, Look, Point, Summary, Sweep, opened, read

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LISTED = 200
"""Points in the table; the index has all."""

DRAWN_BANDS = 8
_VALUES_LISTED = 12
_STYLE = """
.thumbnails { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(7.8rem, 45%), 1fr));
  gap: .4rem .8rem; }
.thumbnails figure { margin: .2rem 0; } .thumbnails img { width: 100%; image-rendering: pixelated;
  border: 1px solid var(--line); }
.thumbnails figcaption { font-size: .8rem; overflow-wrap: anywhere; }
"""


def sweep_page(path: Path) -> Page:
    """Return the page of a sweep: of its folder, or of its dataset.

    Raises
    ------
    SweepError, CubeError
        If it cannot be read.
    """
    with opened(path) as sweep:
        found, unreadable = read(sweep.points)
        failed = [
            (point, point.error or "no reason is known")
            for point in sweep.points
            if point.state in ("failed", "missing")
        ]
        sections = [
            Section("Axes", list(_axes(sweep))),
            Section("Against each axis", list(_against(sweep, found))),
            Section("Pictures", list(_pictures(found.looks))),
            Section("Points", list(_points(sweep, found))),
            Section("Failed points", list(_failed([*failed, *unreadable]))),
            Section("Provenance", list(_provenance(sweep))),
        ]
        title = sweep.title or f"Sweep over {', '.join(sweep.keys)}"
        states = [point.state for point in sweep.points]
        told = ", ".join(
            f"{states.count(state)} {state}" for state in ("done", "failed", "missing", "pending") if state in states
        )
        return Page(
            title, f"Sweep {path.resolve().name}: {len(states)} points, {told}", sections, (), [viewer_style(), _STYLE]
        )


def _axes(sweep: Sweep) -> Iterator[Markup]:
    failed = any(point.state in ("failed", "missing") for point in sweep.points)
    pending = any(point.state == "pending" for point in sweep.points)
    word, tone = ("points failed", "bad") if failed else ("not finished", "fair") if pending else ("all done", "good")
    yield element("p", badge(word, "bad" if tone == "bad" else "fair" if tone == "fair" else "good"))
    rows = []
    for key in sweep.keys:
        values = _distinct(sweep, key)
        listed = ", ".join(_text(value) for value in values[:_VALUES_LISTED])
        more = f", ... {_text(values[-1])}" if len(values) > _VALUES_LISTED else ""
        rows.append([key, str(len(values)), listed + more])
    how = (
        "All combinations of the values."
        if sweep.combine == "product"
        else "The first values of all keys, then the second."
    )
    yield table(
        ["key", "values", "which"], rows, f"{how} Quantities are in SI units, angles in degrees.", text_columns=3
    )


def _distinct(sweep: Sweep, key: str) -> list[Any]:
    found: dict[str, Any] = {}
    for point in sweep.points:
        found.setdefault(json.dumps(point.values.get(key)), point.values.get(key))
    return list(found.values())


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else json.dumps(value)


def _against(sweep: Sweep, found: Findings) -> Iterator[Markup]:
    if not found.summaries:
        yield note("No point has a cube.")
        return
    names = list(dict.fromkeys(name for name, _ in found.columns))
    figures: dict[str, list[Markup]] = {}
    for key in sweep.keys:
        if len(_distinct(sweep, key)) < 2:
            continue
        figures[key] = []
        for name in names:
            parts = [part for other, part in found.columns if other == name][:DRAWN_BANDS]
            quantity = found.columns[name, parts[0]]
            told = f"Mean of {quantity.label} against {key}"
            figures[key].append(drawing(_scatter(sweep, found.summaries, key, quantity, parts), told, f"{told}."))
    if not figures:
        yield note("No key has more than one value.")
        return
    others = ", the line their mean over all other axes" if len(sweep.keys) > 1 else ", joined by a line"
    pixels = (
        "all pixels" if found.step == 1 else f"the pixels of every row and column whose number {found.step} divides"
    )
    frames = "the one frame" if found.frames == 1 else f"up to {found.frames} frames, evenly spread"
    count = sum(point.cube is not None for point in sweep.points)
    read_points = "" if count == len(found.summaries) else f" {len(found.summaries)} of {count} points, evenly spread."
    yield paragraph(f"Dots are points{others}. Means are over {pixels} of {frames}, of each point.{read_points}")
    for key, drawn in figures.items():
        yield element("h3", key)
        yield beside(*drawn)


def _scatter(sweep: Sweep, summaries: Sequence[Summary], key: str, quantity: Quantity, parts: Sequence[str]) -> Figure:
    values = _distinct(sweep, key)
    # the seed has no order: nothing lies between two of its values
    numeric = key != "seed" and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    place = {json.dumps(value): float(value) if numeric else float(number) for number, value in enumerate(values)}
    figure, axes = panels(len(parts))
    for axis, part in zip(axes, parts, strict=True):
        pairs = np.array(
            [
                (place[json.dumps(each.point.values.get(key))], each.means[quantity.name, part])
                for each in summaries
                if (quantity.name, part) in each.means
            ]
        )
        at = np.unique(pairs[:, 0])
        if numeric:
            axis.plot(at, [np.nanmean(pairs[pairs[:, 0] == one, 1]) for one in at], "-", color=INK, lw=1.3)
        axis.plot(pairs[:, 0], pairs[:, 1], "o", color=INK, ms=4, alpha=0.5, mew=0)
        axis.set_title(part, fontsize=LETTERS, loc="left")
        axis.set_ylabel(quantity.units if part else axis_label(quantity.label, quantity.units), fontsize=LETTERS)
        if not numeric:
            step = -(-len(values) // 8)
            axis.set_xticks(
                range(0, len(values), step), [_short(value) for value in values[::step]], rotation=20, ha="right"
            )
    axes[-1].set_xlabel(axis_label(key, ""), fontsize=LETTERS)
    return figure


def _short(value: Any) -> str:
    text = _text(value)
    return text if len(text) <= 20 else f"{text[:19]}…"


def _pictures(looks: Sequence[Look]) -> Iterator[Markup]:
    if not looks:
        yield note("There is nothing to show.")
        return
    yield paragraph("The first frame of some points, evenly spread; one scale of colours for each band. North is up.")
    for look in looks[:DRAWN_BANDS]:
        name = " ".join(word for word in (look.quantity.label, look.quantity.parts[look.part]) if word)
        # images of a sweep may differ in size
        scale = Scale.of(look.quantity, np.concatenate([plane.ravel() for _, plane in look.planes])[None])
        shown = [picture(scale.png(plane), f"{name}, {_values(point)}", _values(point)) for point, plane in look.planes]
        yield element("h3", name)
        yield element("div", *shown, class_="thumbnails")
        yield element("div", scale.bar(look.quantity.units), class_="scale")


def _values(point: Point) -> str:
    return ", ".join(f"{key} {_text(value)}" for key, value in point.values.items())


def _points(sweep: Sweep, found: Findings) -> Iterator[Markup]:
    read_of = {each.point.number: each for each in found.summaries}
    headings = [
        " ".join([quantity.label, part, f"({quantity.units})" if quantity.units else ""]).replace("  ", " ").strip()
        for (_, part), quantity in found.columns.items()
    ]
    rows = []
    for point in sweep.points[:LISTED]:
        summary = read_of.get(point.number)
        means = [f"{summary.means[each]:.5g}" if summary and each in summary.means else "" for each in found.columns]
        certificate = _certificate(summary.certificate) if summary else ""
        keys = [_text(point.values.get(key)) for key in sweep.keys]
        rows.append([str(point.number), *keys, point.state, certificate, *means])
    caption = "Means over pixels and frames as above."
    if len(sweep.points) > LISTED:
        caption += f" The first {LISTED} of {len(sweep.points)} points."
    header = ["point", *sweep.keys, "state", "certificate", *headings]
    yield element("div", table(header, rows, caption, text_columns=3 + len(sweep.keys)), class_="nowrap")


def _certificate(text: str) -> Markup | str:
    for word, tone in TONES.items():
        if text.startswith(word):
            return badge(word.lower(), tone)
    return "none"


def _failed(failed: Sequence[tuple[Point, str]]) -> Iterator[Markup]:
    if not failed:
        yield paragraph("None.")
        return
    rows = [[str(point.number), _values(point), why] for point, why in failed[:LISTED]]
    caption = "" if len(failed) <= LISTED else f"The first {LISTED} of {len(failed)}."
    yield table(["point", "values", "error"], rows, caption, text_columns=3)


def _provenance(sweep: Sweep) -> Iterator[Markup]:
    yield facts((name, value) for name, value in sweep.about.items() if value)
    for point in sweep.points:
        if point.cube is not None:
            yield paragraph(f"Of point {point.number}; others differ in the swept keys.")
            with point.cube() as dataset:
                yield from origin(dataset)
            return
