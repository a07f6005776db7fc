"""One side of a comparison: convert its frames, detect clouds and measure them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.footage import EvaluationChoice, Footage, Method
from hcss_evaluate.comparison.image_measures import TemporalAutocorrelation, measure_image, temporal_autocorrelation
from hcss_evaluate.comparison.result import FrameResult, Pictured
from hcss_evaluate.measures.histogram_metrics import joint_histogram, to_grey_levels
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.providers import Array, ImageError
from hcss_twin.reports.tables import Table

LEVELS = (1.0, 255.0)
"""Grey levels of cloudy pixels."""

MEANINGS: dict[Method, str] = {
    "otsu": "Otsu's threshold of the frame's own histogram",
    "local": "the mean of the surroundings, between the sea's limit and Otsu's threshold",
    "coverage": "the cloudiest pixels, up to the fraction --coverage",
    "valid": "every pixel with a value",
    "truth": "the cube's own cloud mask",
}


def grey_clouds(
    values: Array, bright: bool, method: Method, choice: EvaluationChoice, truth: NDArray[np.bool_] | None
) -> NDArray[np.float32]:
    """Return the grey levels of a frame (rows, columns): 0 clear or missing, 1 to 255 cloudy, not rounded.

    Eq 7 of the HCSS paper: linear from the threshold (from the least cloudy value if the mask is not a threshold) to
    the 99.9th percentile of the cloudy pixels. ``values`` (rows, columns) are NaN where missing, ``bright`` states
    whether large values are cloud, ``method`` is not ``auto``, and ``truth`` is the mask for method ``truth``. Raises
    ImageError if there is no contrast or no cloud.
    """
    known = ~np.isnan(values)
    if not known.any():
        raise ImageError(f"all {values.size} pixels are missing")
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if low == high:
        raise ImageError(f"all pixels have the value {low:g}; clouds need a contrast")
    level = values if bright else -values
    if method == "truth":
        if truth is None:
            raise ImageError("method 'truth': there is no mask; allowed: another method")
        cloudy = truth & known
        lowest = float(level[cloudy].min()) if cloudy.any() else 0.0
    elif method == "valid":
        cloudy, lowest = known, float(np.nanmin(level))
    else:
        assert method != "auto"
        coverage = 0.5 if choice.coverage is None else choice.coverage
        try:
            threshold, lowest = SatelliteImage.Cloudy.threshold(level, method, choice.window_pixels, coverage, level)
        except ValueError as error:
            raise ImageError(f"method '{method}': {error}") from error
        cloudy = level > threshold
    if not cloudy.any():
        raise ImageError(f"no pixel is cloudy by the method '{method}'; allowed: another method or frame")
    grey = np.zeros(values.shape, dtype=np.float32)
    grey[cloudy] = SatelliteImage.Cloudy.thickness_of(
        SatelliteImage.Cloudy.relative_grey(level[cloudy], lowest), *LEVELS
    )
    return grey


Progress = Callable[[Iterable[Any], int], Iterable[Any]]
ComparedAs = Literal["kelvin", "unit", "grey levels"]

MAX_VALUES = 2**25
"""Values kept for histograms and temporal correlation; larger sequences are thinned to every n-th row and column."""

# Relative range of values below which contrast cannot be distinguished from the error of the radiance tables.
_INVISIBLE = 1e-3


@dataclass(frozen=True)
class FrameArrays:
    """One frame (rows, columns): values, NaN where missing, and grey levels, 0 clear or missing, 1 to 255 cloudy.

    ``known`` is true where a pixel is known to be cloudy or clear.
    """

    values: Array
    level: NDArray[np.float32]
    known: NDArray[np.bool_]


@dataclass(frozen=True)
class ComparedSide:
    """Converts frames of one side to the compared quantity and crops them to the compared part (rows, columns).

    ``title`` (REAL or SIM) is used in messages.
    """

    title: str
    footage: Footage
    choice: EvaluationChoice
    quantity: ComparedAs
    part: tuple[slice, slice]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the compared part."""
        rows, columns = self.part
        return rows.stop - rows.start, columns.stop - columns.start

    def frame(self, number: int) -> FrameArrays:
        """Return the compared part of a frame; clouds are detected in the whole frame.

        Raises ImageError if there is no contrast or no cloud.
        """
        footage = self.footage
        values = footage.values(number)
        if self.quantity == "kelvin":
            assert footage.kelvin is not None
            values = footage.kelvin(values)
        truth = None if footage.truth is None else footage.truth(number)
        level = grey_clouds(values, footage.bright_is_cloud, footage.method, self.choice, truth)[self.part]
        if not level.any():
            raise ImageError(
                f"the compared part, {level.shape[0]} x {level.shape[1]} pixels, has no cloud; allowed: another "
                "method, or a file cropped to a cloudy part"
            )
        part = values[self.part]
        # Cloud products have no value in clear pixels, which are not missing.
        known = np.ones(part.shape, np.bool_) if footage.method == "valid" else ~np.isnan(part)
        if self.quantity == "grey levels":
            part = np.where(known, level.astype(np.float64), np.nan)
        return FrameArrays(np.ascontiguousarray(part), np.ascontiguousarray(level), np.ascontiguousarray(known))


@dataclass(frozen=True)
class SideMeasures:
    """Measures of the frames of one side with their numbers; labels of excluded frames with the reasons.

    ``values`` (T, rows, columns) holds the values, thinned by ``step`` along both axes.
    """

    frames: tuple[FrameResult, ...]
    numbers: tuple[int, ...]
    left_out: tuple[tuple[str, str], ...]
    values: NDArray[np.float32]
    step: int


def measure_side(side: ComparedSide, progress: Progress | None = None) -> SideMeasures:
    """Measure all frames of a side; frames without measurable clouds are excluded and listed with the reason.

    Raises ImageError if no frame can be measured.
    """
    footage = side.footage
    rows, columns = side.shape
    step = math.ceil(math.sqrt(max(1.0, footage.count * rows * columns / MAX_VALUES)))
    frames, numbers, left_out, thinned = [], [], [], []
    every: Iterable[int] = range(footage.count)
    for number in every if progress is None else progress(every, footage.count):
        label = footage.labels[number]
        try:
            frame = side.frame(number)
            measures = measure_image(frame.values, frame.level, frame.known)
        except ImageError as error:
            left_out.append((label, str(error)))
            continue
        mask = None if footage.truth is None else footage.truth(number)[side.part]
        frames.append(
            FrameResult(
                label=label,
                seconds=math.nan if footage.seconds is None else footage.seconds[number],
                measures=measures,
                missing=int(np.count_nonzero(~frame.known)),
                truth_coverage=math.nan if mask is None else float(np.mean(mask)),
            )
        )
        numbers.append(number)
        thinned.append(frame.values[::step, ::step].astype(np.float32))
    if not frames:
        label, why = left_out[0]
        which = "" if footage.count == 1 else f", frame {label}"
        raise ImageError(f"{side.title} {footage.name}{which}: {_without_contrast(side) or why}")
    return SideMeasures(tuple(frames), tuple(numbers), tuple(left_out), np.stack(thinned), step)


def _without_contrast(side: ComparedSide) -> str:
    """Return a message if clouds are invisible in the variable or band of a cube, else an empty string."""
    footage = side.footage
    if footage.kind != "cube":
        return ""
    ranges, largest = [], 0.0
    for number in range(footage.count):
        values = footage.values(number)
        if not np.isnan(values).all():
            ranges.append(float(np.nanmax(values) - np.nanmin(values)))
            largest = max(largest, float(np.nanmax(np.abs(values))))
    if not ranges or max(ranges) > _INVISIBLE * largest:
        return ""
    where = f"band {footage.band}" if footage.band else footage.quantity
    option = f"--{side.title.lower()}"
    return (
        f"no pixel differs from clear sea by more than {max(ranges):.2g} {footage.units}".rstrip()
        + f", {max(ranges) / max(largest, 1e-300):.1g} of the {footage.quantity}: clouds are invisible in {where}; "
        f"choose another band ({option}-band) or variable ({option}-variable)"
    )


def correlation_over_time(measured: SideMeasures, notes: list[str]) -> TemporalAutocorrelation | None:
    """Return the temporal autocorrelation of a side; None, with the reason in ``notes``, if undefined."""
    if len(measured.frames) < 2:
        return None
    if measured.left_out:
        notes.append("No correlation over time: frames are missing between others.")
        return None
    seconds = np.array([frame.seconds for frame in measured.frames])
    steps = np.diff(seconds)
    if np.isnan(seconds).any():
        notes.append("The files give no times: the correlation over time is by frame number.")
    elif np.ptp(steps) > 0.01 * float(np.mean(steps)):
        notes.append("Frames are not evenly spaced in time: the correlation over time is by frame number.")
    if measured.step > 1:
        notes.append(
            f"Correlation over time and histograms use every {Table.ordinal(measured.step)} row and column of the "
            f"{len(measured.frames)} frames."
        )
    try:
        correlation = temporal_autocorrelation(measured.values, None if np.isnan(seconds).any() else seconds)
    except ImageError as error:
        notes.append(f"No correlation over time: {error}.")
        return None
    if correlation.is_unresolved:
        after = "" if np.isnan(seconds).any() else f", {correlation.lag_s[1]:g} s later"
        notes.append(
            f"Decorrelation is faster than the interval between frames: in the next frame{after}, the correlation is "
            f"{correlation.correlation[1]:.2g}, below 1/e."
        )
    return correlation


def pictured(side: ComparedSide, number: int) -> Pictured:
    """Return a frame for the report with its 2-D histogram, counted as in ``morphology``."""
    frame = side.frame(number)
    level = frame.level
    cloudy = level > 0.0
    grey = to_grey_levels(level, float(level[cloudy].min()), float(level[cloudy].max()), mask=cloudy)
    pairs = joint_histogram(grey, valid=frame.known)
    return Pictured(side.footage.labels[number], frame.values, level, frame.known, pairs)
