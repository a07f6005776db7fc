"""``index.html`` of a data set: some frames with the boxes of their targets, and filters by label."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_dataset.png import encoded
from hcss_dataset.reader import LabelledFrame
from hcss_dataset.shards import Layout
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

INDEX = "index.html"

MOST_FRAMES, MOST_PIXELS, LONGEST_SIDE = 48, 4_000_000, 1024
"""Frames of a page, their pixels together, and pixels along the longer side of each."""

_FILTERS = """
const filters = [...document.querySelectorAll('[data-filter]')];
function show() {
  const by = Object.fromEntries(filters.map(filter => [filter.dataset.filter, filter.value]));
  let shown = 0;
  for (const frame of document.querySelectorAll('.frame')) {
    let boxes = 0;
    for (const box of frame.querySelectorAll('.target')) {
      const fits = +box.dataset.scr >= +by.scr && +box.dataset.visible >= +by.visible &&
        (!by.kind || box.dataset.kind === by.kind);
      box.style.display = fits ? '' : 'none';
      boxes += fits;
    }
    const narrow = +by.scr > 0 || +by.visible > 0 || by.kind !== '';
    const fits = (!by.split || frame.dataset.split === by.split) &&
      (by.targets === '' || (by.targets === 'with' ? boxes > 0 : frame.dataset.targets === '0')) &&
      (!narrow || boxes > 0 || by.targets === 'without');
    frame.style.display = fits ? '' : 'none';
    shown += fits;
  }
  document.getElementById('shown').textContent = shown;
}
filters.forEach(filter => filter.addEventListener('input', show));
show();
"""

FAINT_SNR = 3.0
"""Ratio of peak to noise below which a threshold with one false alarm in a thousand pixels of normal noise, 3.1 times
the noise, misses more than half of the targets."""

_GRID = "display:grid;grid-template-columns:repeat(auto-fill,minmax(16rem,1fr));gap:1rem"
_CONTROLS = "display:flex;flex-wrap:wrap;gap:1rem;align-items:end;margin:1rem 0"


def write_viewer(layout: Layout, summary: Mapping[str, Any]) -> None:
    """Write the page of a whole data set.

    Raises
    ------
    HcssError
        If it cannot be written.
    """
    frames = layout.draws * layout.per_draw
    first = summary["first"]
    count = min(max(MOST_PIXELS // (first["rows"] * first["columns"]), 4), MOST_FRAMES, frames)
    chosen = {round(number) for number in np.linspace(0, frames - 1, count)}
    records = [record for record in layout.records() if record["number"] in chosen]
    facts = [
        ("frames", f"{frames} of {first['columns']} x {first['rows']} pixels, {layout.per_draw} in a sequence"),
        ("targets", f"{summary['targets']} labels; {summary['empty']} frames without targets"),
        ("faint targets", f"{summary['faint']}, whose peak is below {FAINT_SNR:g} times the noise in every band"),
        ("bands", ", ".join(first["bands"])),
        ("licence", layout.distribution.licence),
    ]
    note = (
        f"{len(records)} of {frames} frames, evenly spread, in band {first['bands'][0]}; north is up, bright is warm, "
        "each frame with its own range. Boxes are red, and blue where nothing of a target is seen; point at one for "
        "its labels."
    )
    sections = [
        Page.Section("Data set", [Markup.facts(facts), _splits(summary)]),
        Page.Section("Frames", [Markup.paragraph(note), _controls(records), _frames(layout, records)]),
    ]
    Page(layout.distribution.title, "Labelled infrared frames", sections, [_FILTERS]).write(layout.folder / INDEX)


def _splits(summary: Mapping[str, Any]) -> Table:
    rows = [[split, str(summary["skies"][split]), str(count)] for split, count in summary["frames"].items()]
    return Table(["split", "skies", "frames"], rows, "No sky is in two splits.", text_columns=1)


def _controls(records: Sequence[Mapping[str, Any]]) -> Markup:
    kinds = sorted({_kind(target) for record in records for target in record["targets"]})
    splits = sorted({record["split"] for record in records})
    choices = (
        ("split", "Split", ["", *splits]),
        ("targets", "Targets", ["", "with", "without"]),
        ("kind", "Kind", ["", *kinds]),
    )
    selects = (
        Markup.element(
            "label",
            f"{title} ",
            Markup.element(
                "select", *(Markup.element("option", value or "all", value=value) for value in values), data_filter=name
            ),
        )
        for name, title, values in choices
    )
    numbers = (
        Markup.element(
            "label",
            f"{title} ",
            Markup.element("input", type="number", value="0", min="0", step=step, data_filter=name, style="width:5rem"),
        )
        for name, title, step in (("scr", "SCR from", "0.5"), ("visible", "Visible share from", "0.1"))
    )
    count = Markup.element("span", Markup.element("b", str(len(records)), id="shown"), " frames shown")
    return Markup.element("div", *selects, *numbers, count, style=_CONTROLS)


def _frames(layout: Layout, records: Sequence[Mapping[str, Any]]) -> Markup:
    return Markup.element("div", *(_frame(layout, record) for record in records), style=_GRID)


def _frame(layout: Layout, record: Mapping[str, Any]) -> Markup:
    image = LabelledFrame(layout.folder, dict(record)).image[0]
    rows, columns = image.shape
    step = math.ceil(max(rows, columns) / LONGEST_SIDE)
    address = "data:image/png;base64," + base64.b64encode(encoded(grey(image[::-step, ::step]))).decode()
    picture = Markup.element(
        "image", href=address, width=str(columns), height=str(rows), style="image-rendering:pixelated"
    )
    drawing = Markup.element(
        "svg",
        picture,
        *_boxes(record, rows),
        viewBox=f"0 0 {columns} {rows}",
        style="width:100%;display:block",
        role="img",
        aria_label=f"Frame {record['key']}",
    )
    targets = len(record["targets"])
    caption = (
        f"{record['key']}, {record['split']}, sequence {record['draw']}, frame {record['frame']}; {targets} targets"
    )
    return Markup.element(
        "figure",
        drawing,
        Markup.element("figcaption", caption),
        class_="frame",
        style="margin:0",
        data_split=record["split"],
        data_targets=str(targets),
    )


def _boxes(record: Mapping[str, Any], rows: int) -> Iterator[Markup]:
    """Yield the box of each target, some pixels wider than its mask, so that it can be seen."""
    for target in record["targets"]:
        x, y, width, height = target["box"] or (*(int(at) for at in reversed(target["place"])), 1, 1)
        room = 3
        scr = target["scr"][0]
        about = (
            f"{_kind(target)}, track {target['track']}: SCR {_number(scr)}, SNR {_number(target['snr'][0])}, visible "
            f"{_number(target['visible'][0])}, altitude {target['altitude_m']:.0f} m"
        )
        yield Markup.element(
            "rect",
            Markup.element("title", about),
            class_="target",
            x=str(x - room),
            y=str(rows - y - height - room),
            width=str(width + 2 * room),
            height=str(height + 2 * room),
            fill="transparent",
            stroke="#d33" if target["box"] else "#38c",
            stroke_width="1.5",
            vector_effect="non-scaling-stroke",
            data_scr=str(0.0 if scr is None else scr),
            data_visible=str(target["visible"][0] or 0.0),
            data_kind=_kind(target),
        )


def _kind(target: Mapping[str, Any]) -> str:
    return str(target.get("family") or target["kind"])


def _number(value: float | None) -> str:
    return "not known" if value is None else f"{value:.3g}"


def grey(image: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """Return an image as 8 bits between its darkest and brightest thousandth."""
    low, high = np.quantile(image, [0.001, 0.999])
    bytes_of_pixels: NDArray[np.uint8] = np.clip(
        np.rint((image - low) * (255.0 / max(high - low, 1.0))), 0, 255
    ).astype(np.uint8)
    return bytes_of_pixels
