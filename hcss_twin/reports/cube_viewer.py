"""Viewer for the frames of a cube: a time slider, and buttons for bands and quantities.

Without JavaScript the page shows the first frame of every band of the first quantity.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.reports.cube_frames import FrameSelection, Reader, Series, png_size
from hcss_twin.reports.orientation import Orientation, length_text
from hcss_twin.reports.page import Markup, data_address, resource
from hcss_twin.reports.preview import FRAME_DURATION_MS, time_label
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    import xarray as xr


COARSE_PIXELS = 300
"""Pictures whose longest side is smaller are drawn with visible pixels."""


def viewer(reader: Reader, series: Sequence[Series], first: FrameSelection, others: FrameSelection) -> Markup:
    """Return the pictures and their controls, which need :func:`viewer_script` to work."""
    dataset = reader.dataset
    where = Orientation.of(dataset)
    controls = Markup.element(
        "div",
        Markup.element("label", "show", Markup.element("select", class_="quantity")),
        Markup.element("label", Markup.element("span"), Markup.element("select", class_="part"), class_="parts"),
        Markup.element(
            "div",
            Markup.element("button", "Play", type="button", class_="play", aria_pressed="false"),
            Markup.element("input", type="range", min="0", value="0", step="1", aria_label="frame"),
            class_="time",
        ),
        class_="controls",
    )
    numbers = Markup.joined(
        (Markup.joined([f"{name} ", Markup.element("b", class_=name)]) for name in ("mean", "lowest", "highest")), ", "
    )
    about = Markup.element(
        "p",
        Markup.element("b", class_="frame"),
        ", ",
        Markup.element("span", class_="instant"),
        Markup.element("span", class_="sun"),
        Markup.element("br"),
        numbers,
        " ",
        Markup.element("span", class_="units"),
        class_="about",
    )
    stage = Markup.element(
        "div",
        _sky(dataset, "data:,", "", coarse=False),
        Markup.element("div", Markup.element("div", class_="scale"), about, _compass(where), class_="beside-sky"),
        class_="stage",
    )
    stills = (_still(dataset, one) for one in series if one.quantity == series[0].quantity)
    hint = (
        "Keys, once this box has the focus: ← and → step, space plays, b is the next band, q the next quantity. "
        f"{_size_text(dataset, where)}{_selection_text(reader, first, others, series)}"
    )
    content = (
        controls,
        stage,
        Markup.element("div", *stills, class_="stills beside"),
        Markup.element("p", hint, class_="hint"),
    )
    return Markup.element("div", *content, class_="viewer", tabindex="0", role="group", aria_label="frames")


def _sky(dataset: xr.Dataset, address: str, alternative: str, coarse: bool) -> Markup:
    """Return a picture, with a scale bar if its middle is on the ground."""
    where, columns = Orientation.of(dataset), dataset.sizes["x"]
    content = [Markup.element("img", src=address, alt=alternative)]
    if where is not None:
        length_m = where.bar_m(columns)
        width = f"width:{100 * length_m / (where.column_m * columns):.2f}%"
        label = Markup.element("b", length_text(length_m))
        content.append(Markup.element("span", label, class_="length", style=width))
    return Markup.element(
        "div", *content, class_="sky coarse" if coarse else "sky", style=f"--aspect:{_aspect(dataset, where):.4f}"
    )


def _aspect(dataset: xr.Dataset, where: Orientation | None) -> float:
    """Width over height of the pictures."""
    pixel = where.ground[0, 0] / where.ground[1, 1] if where is not None and where.is_map else 1.0
    return float(pixel) * dataset.sizes["x"] / dataset.sizes["y"]


def _size_text(dataset: xr.Dataset, where: Orientation | None) -> str:
    if where is None:
        return ""
    if not where.is_map:
        return f"In the middle of the image a pixel is {where.column_m:.3g} m wide. "
    width, height = (where.ground[axis, axis] * dataset.sizes[dim] / 1e3 for axis, dim in enumerate("xy"))
    return f"North is up, east to the right; {width:.4g} km east to west and {height:.4g} km north to south. "


def _compass(where: Orientation | None) -> Markup:
    """Return a drawing of where north, the sun and the sensor are in the image, with their angles in words."""
    if where is None:
        return Markup("")
    words = where.words()
    arrows = []
    for name, (right, up) in where.arrows():
        x, y = 30.0 * right, -30.0 * up
        line = Markup.element("line", x1="0", y1="0", x2=f"{x:.2f}", y2=f"{y:.2f}")
        corners = " ".join(
            f"{x - 8 * along * right + side * up:.2f},{y + 8 * along * up + side * right:.2f}"
            for along, side in ((0, 0), (1, 3.5), (1, -3.5))
        )
        parts = [line, Markup.element("polygon", points=corners)]
        if name == "N":
            parts.append(Markup.element("text", name, x=f"{40 * right:.2f}", y=f"{4 - 40 * up:.2f}"))
        arrows.append(Markup.element("g", *parts, class_=f"to-{name}"))
    title = Markup.element("title", "; ".join(["north, sun and sensor in the image", *words.values()]))
    drawing = Markup.element("svg", title, *arrows, viewBox="-48 -48 96 96", role="img", class_="compass")
    lines = [Markup.element("span", text, class_=f"to-{name}") for name, text in words.items()]
    return Markup.element("div", drawing, Markup.element("p", *lines), class_="where")


def _is_coarse(one: Series) -> bool:
    return max(png_size(one.pictures[0])) < COARSE_PIXELS


def _still(dataset: xr.Dataset, one: Series) -> Markup:
    label = " ".join(word for word in (one.quantity.label, one.part) if word)
    times, frame = dataset["time"].to_numpy(), one.frames[0]
    moment = Markup.element("span", f"frame {frame}, {time_label(times[frame], times[0])}", class_="frame")
    return Markup.element(
        "figure",
        _sky(dataset, data_address(one.pictures[0]), f"{label}, first frame", _is_coarse(one)),
        Markup.element("div", one.scale.bar(one.quantity.units), class_="scale"),
        Markup.element("figcaption", Markup.element("b", label), ", ", moment),
    )


def _selection_text(reader: Reader, first: FrameSelection, others: FrameSelection, series: Sequence[Series]) -> str:
    """Describe which frames and pixels are shown."""
    count = reader.dataset.sizes["time"]
    every = f"every {Table.ordinal(reader.step)} row and column"
    shown = []
    for selection, label in ((first, series[0].quantity.label), (others, "the others")):
        if not selection.frames:
            continue
        frames = f"{len(selection.frames)} of {count} frames, evenly spread"
        if len(selection.frames) == count:
            frames = "the only frame" if count == 1 else "all frames"
        pixels = "every pixel" if reader.step == 1 else f"those pixels of {every}"
        if selection.binning > 1:
            read = "" if reader.step == 1 else f" of {every}"
            pixels = f"means over {selection.binning} x {selection.binning} pixels{read}, flags from one of them"
        shown.append(f"{label} ({frames}, {pixels})")
    numbers = "all pixels" if reader.step == 1 else f"the pixels of {every}"
    return f"Shown: {'; '.join(shown)}. Mean, lowest and highest are over {numbers} of the frame."


def viewer_script(dataset: xr.Dataset, series: Sequence[Series]) -> str:
    """Return the self-contained viewer script with all pictures."""
    frames = sorted({frame for one in series for frame in one.frames})
    groups = [list(group) for _, group in groupby(series, key=lambda one: one.quantity)]
    view = {
        "milliseconds": FRAME_DURATION_MS,
        "frames": [_frame(dataset, frame) for frame in frames],
        "quantities": [
            {
                "name": group[0].quantity.name,
                "label": group[0].quantity.label,
                "units": group[0].quantity.units,
                "dim": group[0].quantity.dim,
                "coarse": _is_coarse(group[0]),
                "frames": [frames.index(frame) for frame in group[0].frames],
                "parts": [_part(one, one.quantity == series[0].quantity) for one in group],
            }
            for group in groups
        ],
    }
    # "</" would end the script element, even within a string
    data = json.dumps(view, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/").replace("<!", "<\\!")
    return f"const VIEW = {data};\n{resource('viewer.js')}"


def _part(one: Series, in_page: bool) -> dict[str, Any]:
    pictures = [base64.b64encode(picture).decode("ascii") for picture in one.pictures]
    if in_page:
        pictures[0] = ""  # it is in the page already, for browsers without JavaScript
    return {
        "name": one.part,
        "number": one.quantity.parts.index(one.part),
        "bar": one.scale.bar(one.quantity.units),
        "pictures": pictures,
        "numbers": [
            {name: "none" if math.isnan(value) else f"{value:.5g}" for name, value in vars(numbers).items()}
            for numbers in one.numbers
        ],
    }


def _frame(dataset: xr.Dataset, frame: int) -> dict[str, Any]:
    times = dataset["time"].to_numpy()
    sun = ""
    if "solar_zenith_angle" in dataset.coords:
        zenith = np.broadcast_to(dataset["solar_zenith_angle"].to_numpy(), times.shape)[frame]
        sun = f", sun {zenith:.2f}° from the zenith"
    return {
        "number": frame,
        "time": time_label(times[frame], times[0]),
        "instant": f"{np.datetime_as_string(times[frame], unit='ms')}Z",
        "sun": sun,
    }
