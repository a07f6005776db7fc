"""Which frames a page shows and how many pixels of them, so that it stays a file that can be sent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from hcss_twin.report.cube_report.content import READ_BYTES, Quantity, Reader, spread
from hcss_twin.report.cube_report.scale import Scale
from hcss_twin.report.cube_report.series import Series, binned, read_series

PICTURE_BYTES = 6_400_000
"""All pictures of frames together; a third more as text in the page."""

FRAMES = 24
"""Shown of radiance, or of what comes first."""

OTHER_FRAMES = 8
"""Shown of everything else."""

_PICTURES = 480
"""Most pictures of each of both groups: with very many bands there are fewer frames."""

_FIRST_SHARE = 0.55


@dataclass(frozen=True)
class Choice:
    """What is shown of one group of quantities.

    Attributes
    ----------
    frames : tuple of int
    binning : int
        Of the rows and columns that are read.
    """

    frames: tuple[int, ...]
    binning: int


def read_all(reader: Reader, shown: Sequence[Quantity]) -> tuple[list[Series], Choice, Choice]:
    """Read what the page shows of a cube.

    Returns
    -------
    series : list of Series
        Each part of each quantity.
    first, others : Choice
        Of the first quantity, and of the rest.
    """
    groups = [list(shown[:1]), list(shown[1:])]
    left = float(PICTURE_BYTES)
    found: list[list[Series]] = []
    choices = []
    for group, most in zip(groups, (FRAMES, OTHER_FRAMES), strict=True):
        budget = left * (_FIRST_SHARE if group is groups[0] and groups[1] else 1.0)
        choice = _choose(reader, group, budget, most)
        series = _read(reader, group, choice)
        while _size(series) > budget and _side(series) > 1:
            larger = max(choice.binning + 1, math.floor(choice.binning * math.sqrt(_size(series) / budget)))
            choice = replace(choice, binning=larger)
            series = _read(reader, group, choice)
        left -= _size(series)
        found.append(series)
        choices.append(choice)
    return [*found[0], *found[1]], choices[0], choices[1]


def _choose(reader: Reader, group: Sequence[Quantity], budget: float, most: int) -> Choice:
    count = reader.dataset.sizes["time"]
    parts = sum(len(quantity.parts) for quantity in group)
    if not parts:
        return Choice((), 1)
    moved = sum(reader.bytes_moved(quantity) for quantity in group)
    affordable = int(READ_BYTES / 2 // max(1, moved))
    frames = spread(count, max(1, min(most, affordable, _PICTURES // parts)))
    # one plane of each quantity tells how much space the others will take
    middle = frames[len(frames) // 2]
    samples = [(quantity, reader.plane(quantity, 0, middle)) for quantity in group]
    binning = 1
    while True:
        size = 0
        for quantity, plane in samples:
            shown = binned(plane, binning, bool(quantity.flags))
            picture = Scale.of(quantity, shown[None]).png(shown)
            size += len(picture) * len(quantity.parts) * len(frames)
        if size <= budget or max(shown.shape) == 1:
            return Choice(tuple(frames), binning)
        binning = max(binning + 1, math.floor(binning * math.sqrt(size / budget)))


def _read(reader: Reader, group: Sequence[Quantity], choice: Choice) -> list[Series]:
    return [
        read_series(reader, quantity, part, choice.frames, choice.binning, quantity.name in CURVES)
        for quantity in group
        for part in range(len(quantity.parts))
    ]


CURVES = ("radiance", "brightness_temperature")
"""Quantities with histogram, spectrum and course over time."""


def _size(series: Sequence[Series]) -> int:
    return sum(len(picture) for each in series for picture in each.pictures)


def _side(series: Sequence[Series]) -> int:
    """Longest side of the pictures in pixels, from the header of one of them."""
    header = series[0].pictures[0]
    return max(int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big"))
