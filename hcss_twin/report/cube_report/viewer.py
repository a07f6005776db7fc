"""Frames to step through: a slider of time, switches of bands and quantities; without a script the first frames."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Sequence
from importlib import resources
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.report.cube_report.choice import Choice
from hcss_twin.report.cube_report.content import Reader
from hcss_twin.report.cube_report.series import Series
from hcss_twin.report.page.page import Markup, element, joined
from hcss_twin.report.page.pictures import data_address
from hcss_twin.report.preview import FRAME_DURATION_MS, time_label

if TYPE_CHECKING:
    import xarray as xr


COARSE_PIXELS = 300
"""Pictures with a smaller longest side are drawn with their pixels to be seen."""

_LENGTHS = (1, 2, 5)


def viewer(reader: Reader, series: Sequence[Series], first: Choice, others: Choice) -> Markup:
    """Return the pictures and their controls; :func:`viewer_script` makes these work."""
    dataset = reader.dataset
    stills = [one for one in series if one.quantity == series[0].quantity]
    controls = element(
        "div",
        element("label", "show", element("select", class_="quantity")),
        element("label", element("span", ""), element("select", class_="part"), class_="parts"),
        element(
            "div",
            element("button", "Play", type="button", class_="play", aria_pressed="false"),
            _void("input", type="range", min="0", value="0", step="1", aria_label="frame"),
            class_="time",
        ),
        class_="controls",
    )
    numbers = [joined([f"{name} ", element("b", "", class_=name)]) for name in ("mean", "lowest", "highest")]
    stage = element(
        "div",
        _sky(dataset, "data:,", "", coarse=False),
        element(
            "div",
            element("div", class_="scale"),
            element(
                "p",
                element("b", "", class_="frame"),
                ", ",
                element("span", "", class_="instant"),
                element("span", "", class_="sun"),
                _void("br"),
                joined([joined(numbers, ", "), " ", element("span", "", class_="units")]),
                class_="about",
            ),
            class_="beside-sky",
        ),
        class_="stage",
    )
    hint = (
        "Keys, once this box is clicked: ← and → step, space plays, b is the next band, q the next quantity. "
        f"North is up, east to the right; {_extent(dataset)}. {_told(reader, first, others, series)}"
    )
    return element(
        "div",
        controls,
        stage,
        element("div", *(_still(dataset, one) for one in stills), class_="stills beside"),
        element("p", hint, class_="hint"),
        class_="viewer",
        tabindex="0",
    )


def _void(name: str, **attributes: str | None) -> Markup:
    return Markup(element(name, **attributes).removesuffix(f"</{name}>"))


def _sky(dataset: xr.Dataset, address: str, alternative: str, coarse: bool) -> Markup:
    """Return a picture with a length on it."""
    width_m = _side(dataset, "x")
    length_m = _round_length(width_m / 4.0)
    text = f"{length_m / 1e3:g} km" if length_m >= 1e3 else f"{length_m:g} m"
    bar = element("span", element("b", text), class_="length", style=f"width:{100 * length_m / width_m:.2f}%")
    return element(
        "div",
        _void("img", src=address, alt=alternative),
        bar,
        class_="sky coarse" if coarse else "sky",
        style=f"--aspect:{width_m / _side(dataset, 'y'):.4f}",
    )


def _side(dataset: xr.Dataset, dim: str) -> float:
    """Length of the image along a dimension, m; a single pixel has that of the other side, or one metre."""
    for name in (dim, "x", "y"):
        if dataset.sizes[name] > 1:
            return abs(float(dataset[name][1] - dataset[name][0])) * dataset.sizes[dim]
    return 1.0


def _round_length(length: float) -> float:
    power = 10.0 ** math.floor(math.log10(length))
    return max(factor * power for factor in _LENGTHS if factor * power <= length * (1 + 1e-9))


def _extent(dataset: xr.Dataset) -> str:
    return f"{_side(dataset, 'x') / 1e3:.4g} km east to west and {_side(dataset, 'y') / 1e3:.4g} km north to south"


def _is_coarse(picture: bytes) -> bool:
    sides = (int.from_bytes(picture[place : place + 4], "big") for place in (16, 20))
    return max(sides) < COARSE_PIXELS


def _still(dataset: xr.Dataset, one: Series) -> Markup:
    label = " ".join(word for word in (one.quantity.label, one.part) if word)
    picture = one.pictures[0]
    caption = element(
        "figcaption", element("b", label), ", ", element("span", _frame_text(dataset, one.frames[0]), class_="frame")
    )
    return element(
        "figure",
        _sky(dataset, data_address(picture), f"{label}, first frame", _is_coarse(picture)),
        element("div", one.scale.bar(one.quantity.units), class_="scale"),
        caption,
    )


def _frame_text(dataset: xr.Dataset, frame: int) -> str:
    times = dataset["time"].to_numpy()
    return f"frame {frame}, {time_label(times[frame], times[0])}"


def _told(reader: Reader, first: Choice, others: Choice, series: Sequence[Series]) -> str:
    """Say which frames and pixels are left out."""
    count = reader.dataset.sizes["time"]
    parts = [(first, series[0].quantity.label)]
    if others.frames:
        parts.append((others, "the others"))
    told = []
    for choice, label in parts:
        frames = (
            "all frames" if len(choice.frames) == count else f"{len(choice.frames)} of {count} frames, evenly spread"
        )
        if count == 1:
            frames = "its one frame"
        read = "" if reader.step == 1 else f" of every {_nth(reader.step)} row and column"
        pixels = "every pixel" if reader.step == 1 else f"those pixels{read}"
        if choice.binning > 1:
            pixels = f"means over {choice.binning} x {choice.binning} pixels{read} (flags: one of them)"
        told.append(f"of {label} {frames}, {pixels}")
    numbers = "all pixels" if reader.step == 1 else f"the pixels of every {_nth(reader.step)} row and column"
    return f"Shown are {'; '.join(told)}. Mean, lowest and highest are those of {numbers} of the frame."


def _nth(number: int) -> str:
    ending = {1: "st", 2: "nd", 3: "rd"}.get(number % 10 if number % 100 not in (11, 12, 13) else 0, "th")
    return f"{number}{ending}"


def viewer_script(dataset: xr.Dataset, series: Sequence[Series]) -> str:
    """Return the script of the viewer with all pictures, and nothing from elsewhere."""
    frames = sorted({frame for one in series for frame in one.frames})
    place = {frame: number for number, frame in enumerate(frames)}
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
                "coarse": _is_coarse(group[0].pictures[0]),
                "frames": [place[frame] for frame in group[0].frames],
                "parts": [_part(one, number == 0) for one in group],
            }
            for number, group in enumerate(groups)
        ],
    }
    # "</" would end the script, whatever stands around it
    data = json.dumps(view, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/").replace("<!", "<\\!")
    code = (resources.files(__package__) / "viewer.js").read_text(encoding="utf-8")
    return f"const VIEW = {data};\n{code}"


def viewer_style() -> str:
    """Return the style sheet of the viewer."""
    return (resources.files(__package__) / "viewer.css").read_text(encoding="utf-8")


def _part(one: Series, is_first: bool) -> dict[str, Any]:
    pictures = [base64.b64encode(picture).decode("ascii") for picture in one.pictures]
    if is_first:
        pictures[0] = ""  # the page has it already, for those without a script
    return {
        "name": one.part,
        "bar": one.scale.bar(one.quantity.units),
        "pictures": pictures,
        "numbers": [{name: _number(value) for name, value in vars(numbers).items()} for numbers in one.numbers],
    }


def _number(value: float) -> str:
    return "none" if math.isnan(value) else f"{value:.5g}"


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
