"""What is read of the cubes of a sweep: means of every band, and a few pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import HcssError
from hcss_twin.reporting.cube_report.choice import CURVES
from hcss_twin.reporting.cube_report.quantities import Quantity, quantities
from hcss_twin.reporting.cube_report.reading import Reader, spread
from hcss_twin.reporting.cube_report.series import FrameNumbers, binned
from hcss_twin.reporting.sweep_report.points import Point

READ_POINTS = 400
"""Points whose cubes are read, evenly spread."""

READ_FRAMES = 4
"""Of each of them, evenly spread."""

PICTURES = 8
"""Of each band, of points evenly spread."""

PICTURE_SIDE = 240
"""Longest side of a picture in pixels."""

_ALSO = ("cloud_fraction", "cloud_mask")

Means = Mapping[tuple[str, str], float]


@dataclass(frozen=True)
class Summary:
    """What was read of one point.

    Attributes
    ----------
    point : Point
    means : mapping of (quantity, band) to float
        Over pixels and frames that were read.
    certificate : str
        Of its cube, in words; empty where it has none.
    """

    point: Point
    means: Means
    certificate: str


@dataclass(frozen=True)
class Look:
    """Pictures to be of one band: the first frame of some points.

    Attributes
    ----------
    quantity : Quantity
    part : int
    planes : sequence of (Point, ndarray (y, x))
    """

    quantity: Quantity
    part: int
    planes: Sequence[tuple[Point, NDArray[np.float64]]]


@dataclass(frozen=True)
class Findings:
    """What was read of a sweep.

    Attributes
    ----------
    summaries : sequence of Summary
        Of the points that were read.
    looks : sequence of Look
        Of each band of radiance, or of the first quantity there is.
    columns : mapping of (quantity, band) to Quantity
        What there are means of.
    step : int
        Every so many rows and columns were read.
    frames : int
        Most frames of a point that were read.
    """

    summaries: Sequence[Summary]
    looks: Sequence[Look]
    columns: Mapping[tuple[str, str], Quantity]
    step: int
    frames: int


def read(points: Sequence[Point]) -> tuple[Findings, list[tuple[Point, str]]]:
    """Read the cubes of points.

    Returns
    -------
    Findings
    list of (Point, str)
        Points whose cube cannot be read, and why.
    """
    with_cube = [point for point in points if point.cube is not None]
    chosen = [with_cube[place] for place in spread(len(with_cube), READ_POINTS)] if with_cube else []
    shown = {chosen[place].number for place in spread(len(chosen), PICTURES)} if chosen else set()
    summaries: list[Summary] = []
    unreadable: list[tuple[Point, str]] = []
    planes: dict[tuple[str, int], list[tuple[Point, NDArray[np.float64]]]] = {}
    kinds: dict[str, Quantity] = {}
    columns: dict[tuple[str, str], Quantity] = {}
    step = most = 1
    for point in chosen:
        assert point.cube is not None
        try:
            with point.cube() as dataset:
                found = quantities(dataset)
                reader = Reader.of(dataset)
                frames = spread(dataset.sizes["time"], READ_FRAMES)
                wanted = [each for each in found if each.name in (*CURVES, *_ALSO)]
                means: dict[tuple[str, str], float] = {}
                for quantity in wanted or found[:1]:
                    for part, name in enumerate(quantity.parts):
                        numbers = [
                            FrameNumbers.of(reader.plane(quantity, part, frame)).mean for frame in frames
                        ]
                        means[quantity.name, name] = float(np.mean(numbers))
                        columns.setdefault((quantity.name, name), quantity)
                summaries.append(Summary(point, means, str(dataset.attrs.get("hcss_certificate", ""))))
                step, most = max(step, reader.step), max(most, len(frames))
                if point.number in shown and found:
                    kinds.setdefault(found[0].name, found[0])
                    for part in range(len(found[0].parts)):
                        planes.setdefault((found[0].name, part), []).append(
                            (point, _small(reader, found[0], part))
                        )
        except HcssError as error:
            unreadable.append((point, str(error)))
    looks = [Look(kinds[name], part, listed) for (name, part), listed in planes.items()]
    return Findings(summaries, looks, columns, step, most), unreadable


def _small(reader: Reader, quantity: Quantity, part: int) -> NDArray[np.float64]:
    plane = reader.plane(quantity, part, 0)
    return np.asarray(
        binned(plane, max(1, -(-max(plane.shape) // PICTURE_SIDE)), bool(quantity.flags)), dtype=np.float64
    )
