"""Fig 12: stratus in three bands while the footprint moves by 50 pixels per second."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import fftconvolve

from hcss_paper.figure_base import BANDS, PHYSICAL_NOTE, blank, image_panel, radiance_by_band, radiance_inputs
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_paper.scene import Model
from hcss_twin.providers import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SECONDS = tuple(range(1, 9))
SPEED_M_S = 1000.0
PIXEL_M = 20.0
SHIFT_PIXELS = (50, 0)
"""Shift of the image along x and y per second."""

REACH_PIXELS = 80
SIDE_PIXELS = 800
MIN_CORRELATION = 0.98


def sequence(model: Model, seed: int, size: int = SIDE_PIXELS, frames: int = len(SECONDS)) -> dict[str, Array]:
    """Return radiance (frames, rows, columns) by band, starting at 1 s; the clouds evolve but do not drift."""
    return radiance_by_band(
        "stratus",
        model,
        {
            "frames": {"first": SECONDS[0], "count": frames, "interval": 1.0},
            "image": {"rows": size, "columns": size, "pixel_size": PIXEL_M},
            "motion.platform_speed": SPEED_M_S,
            "motion.wind_speed": 0.0,
            "clouds.coverage_mode": "frame",  # eq 5
            "seed": seed,
        },
    )


def shift_between(before: Array, after: Array, reach: int = REACH_PIXELS) -> tuple[int, int, float]:
    """Return the shift of the footprint in pixels along x and y, and the correlation at that shift.

    The central part of ``after`` is located in ``before`` by cross-correlation, at shifts of up to ``reach`` pixels in
    each direction.

    Parameters
    ----------
    before, after : ndarray (rows, columns)
        More than ``2 reach`` pixels along each side.
    reach : int
    """
    mean = before.mean()
    image, part = before - mean, after[reach:-reach, reach:-reach] - mean
    part = part - part.mean()
    sums, squares = (_window_sums(values, part.shape) for values in (image, image**2))
    products = fftconvolve(image, part[::-1, ::-1], "valid")
    spread = np.maximum(squares - sums**2 / part.size, 1e-300)
    correlation = products / np.sqrt(spread * np.sum(part**2))
    row, column = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    return int(column) - reach, int(row) - reach, float(correlation[row, column])


def _window_sums(values: Array, shape: tuple[int, ...]) -> Array:
    """Return the sum over each window of a shape: four corners of the sum from the first pixel on."""
    rows, columns = shape
    total = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    sums: Array = total[rows:, columns:] - total[:-rows, columns:] - total[rows:, :-columns] + total[:-rows, :-columns]
    return sums


def figure_12(seed: int) -> Reproduction:
    """Return eight seconds of stratus in three bands, and the motion of the images."""
    found, corrected = sequence("as-printed", seed), sequence("physical", seed)
    rows: list[Row] = []
    checks: list[Check] = []
    for band, name in BANDS.items():
        more_rows, check = motion(name, found[band])
        rows += more_rows
        checks.append(check)
    contrasts = {band: [_contrast(frames[band]) for frames in (found, corrected)] for band in BANDS}
    for band, name in BANDS.items():
        rows.append(Row(f"{name}, standard deviation over mean", "1", None, *contrasts[band]))
    checks.append(
        Check(
            "8-14 um has less contrast than 3-5 um: "
            f"{contrasts['lwir'][0]:.3f} against {contrasts['mwir'][0]:.3f} of the mean",
            contrasts["lwir"][0] < contrasts["mwir"][0],
        )
    )
    return judged(
        rows,
        checks,
        holds="The image moves by the printed 50 pixels per second along x and 0 along y in all bands, and 8-14 um "
        "has the least contrast.",
        fails="The image does not move as printed, or its contrast is not as described.",
        chosen=(
            *in_words("coverage 50 %, no wind, evolution of the largest structures in 1800 s: not stated"),
            *radiance_inputs(*BANDS),
        ),
        notes=(PHYSICAL_NOTE,),
        drawings=(
            Drawing(
                "Stratus at T = 1 to 8 s, as-printed; each row has its own grey scale",
                _drawn(found),
                "Three rows of eight images: clouds, dark on a bright sea, move to the left from image to image.",
            ),
            Drawing(
                "The same scene with the corrected physics",
                _drawn(corrected),
                "Three rows of eight images: clouds, darker than the sun glint, move to the left.",
            ),
        ),
    )


def motion(name: str, frames: Array) -> tuple[list[Row], Check]:
    """Return rows with the mean shift per second, and a check that every shift is the printed one."""
    shifts = [shift_between(before, after) for before, after in itertools.pairwise(frames)]
    rows = [
        Row(
            f"{name}, shift along {axis} each second, mean",
            "pixel",
            float(SHIFT_PIXELS[index]),
            float(np.mean([s[index] for s in shifts])),
        )
        for index, axis in enumerate("xy")
    ]
    least = min(agreement for *_, agreement in shifts)
    moved = all((x, y) == SHIFT_PIXELS for x, y, _ in shifts)
    check = Check(
        f"{name}: every second the image moves by {SHIFT_PIXELS[0]} pixels along x and {SHIFT_PIXELS[1]} along y, from "
        f"cross-correlation; correlation {least:.4f} or more, at least {MIN_CORRELATION}",
        moved and least >= MIN_CORRELATION,
    )
    return rows, check


def _contrast(frames: Array) -> float:
    return float(np.mean(frames.std(axis=(1, 2)) / frames.mean(axis=(1, 2))))


def _drawn(frames: dict[str, Array]) -> Figure:
    figure = blank(10.0, 4.2)
    axes = figure.subplots(len(BANDS), len(SECONDS))
    for number, (row, band) in enumerate(zip(axes, BANDS, strict=True), 1):
        limits = (float(frames[band].min()), float(frames[band].max()))
        for axis, image, second in zip(row, frames[band], SECONDS, strict=True):
            image_panel(axis, image, f"T = {second} s" if number == 1 else "", limits, most=100)
        row[0].set_ylabel(f"({number})", rotation=0, labelpad=12)
    return figure
