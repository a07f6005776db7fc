"""Metrics of a comparison: measures of single frames, averaged over the frames of each side."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcss_evaluate.comparison.definitions import Mode, four_measures
from hcss_evaluate.comparison.image_measures import TemporalAutocorrelation
from hcss_evaluate.comparison.result import Dependence, FrameResult, Metric
from hcss_evaluate.measures.power_spectrum import PowerSpectrum
from hcss_twin.providers import Array

Definition = Literal["as-printed", "corrected", "both"]
Measure = Callable[[FrameResult], float]

FOUR, CLOUDS, DIMENSIONS, DIRECTIONS, VALUES, TIME = (
    "Neighbouring grey levels and fractal dimension (eqs 6, 21-23)",
    "Clouds",
    "Fractal dimensions",
    "Anisotropy",
    "Values",
    "Change over time",
)

# Limits of a surface dimension.
_SURFACE = (2.0, 3.0)
_PIXEL: Dependence = "pixel size"
_PIXELS: Dependence = "pixel size and number of pixels"
_ANY: Dependence = "any"


@dataclass(frozen=True)
class _FrameMeasure:
    """A metric that is computed for each frame."""

    group: str
    name: str
    meaning: str
    measure: Measure
    unit: str = "1"
    definition: Definition = "both"
    scale: Dependence = _PIXEL
    is_ratio: bool = True
    limits: tuple[float, float] | None = None


def _four(mode: Mode, name: str) -> Measure:
    return lambda frame: float(getattr(four_measures(frame.measures.morphology, mode), name))


def _shape(name: str) -> Measure:
    return lambda frame: float(getattr(frame.measures.morphology, name))


def _dimension(name: str) -> Measure:
    def measure(frame: FrameResult) -> float:
        estimate = frame.measures.dimensions.get(name)
        return math.nan if estimate is None else estimate.dimension

    return measure


_PRINTED: Mode = "as-printed"
_CORRECTED: Mode = "corrected"

_FRAME_MEASURES = (
    _FrameMeasure(FOUR, "EV", "entropy of neighbouring grey levels (eq 21)", _four(_PRINTED, "entropy"), "bit"),
    _FrameMeasure(FOUR, "Den, printed", "ten times eq 22", _four(_PRINTED, "density"), "1", _PRINTED),
    _FrameMeasure(
        FOUR, "Den", "mean of 1 / (1 + difference of neighbours) (eq 22)", _four(_CORRECTED, "density"), "1", _CORRECTED
    ),
    _FrameMeasure(
        FOUR,
        "DP, printed",
        "pairs of equal neighbours over W - 1 (eq 23)",
        _four(_PRINTED, "diagonal_peak"),
        "1",
        _PRINTED,
        _PIXELS,
    ),
    _FrameMeasure(
        FOUR, "DP", "over W, the entries of the diagonal", _four(_CORRECTED, "diagonal_peak"), "1", _CORRECTED, _PIXELS
    ),
    _FrameMeasure(
        FOUR,
        "equal",
        "fraction of equal neighbours: DP normalised by pixel count",
        lambda frame: frame.measures.equal_neighbours,
        "1",
        _CORRECTED,
    ),
    _FrameMeasure(FOUR, "FD", "box counting of the cloud body (eq 6)", _shape("fractal_dimension")),
    _FrameMeasure(CLOUDS, "coverage", "cloudy part of the pixels", _shape("coverage"), scale=_ANY),
    _FrameMeasure(
        CLOUDS,
        "coverage, truth",
        "the same by the file's own cloud mask",
        lambda frame: frame.truth_coverage,
        scale=_ANY,
    ),
    _FrameMeasure(
        CLOUDS,
        "level",
        "mean grey level of cloudy pixels, 1 to 255",
        lambda frame: frame.measures.mean_level,
        scale=_ANY,
    ),
    _FrameMeasure(
        DIMENSIONS, "tops", "surface of the cloudy pixels: variogram", _shape("surface_dimension"), limits=_SURFACE
    ),
    _FrameMeasure(DIMENSIONS, "outline", "outlines of the clouds: boxes on the boundary", _shape("boundary_dimension")),
    *(
        _FrameMeasure(DIMENSIONS, name, meaning, _dimension(key), limits=_SURFACE)
        for name, meaning, key in (
            ("variogram", "surface of all values: variogram, lags 1 and 2", "variogram"),
            ("spectrum", "surface of all values: slope of the spectrum, 4 - beta / 2", "spectrum"),
            ("boxes", "surface of all values: differential box counting, calibrated", "box counting"),
            ("boxes, raw", "the same as its authors define it", "box counting, raw"),
        )
    ),
    _FrameMeasure(
        DIRECTIONS, "semivariance", "of cloudy pixels along y over that along x, 1 and 2 pixels", _shape("anisotropy")
    ),
    _FrameMeasure(DIRECTIONS, "aspect", "length along x over length along y", _shape("aspect")),
)


def _value_measures(unit: str) -> tuple[_FrameMeasure, ...]:
    # Differences relative to an absolute temperature say little.
    return (
        _FrameMeasure(
            VALUES, "mean", "of all pixels", lambda frame: frame.measures.mean, unit, scale=_ANY, is_ratio=unit != "K"
        ),
        _FrameMeasure(
            VALUES,
            "deviation",
            "standard deviation of all pixels",
            lambda frame: frame.measures.deviation,
            unit,
            scale=_ANY,
        ),
    )


def build_metrics(
    frames: tuple[Sequence[FrameResult], Sequence[FrameResult]],
    spectra: tuple[PowerSpectrum | None, PowerSpectrum | None],
    temporal: tuple[TemporalAutocorrelation | None, TemporalAutocorrelation | None],
    unit: str,
    *,
    same_pixels: bool,
    same_count: bool,
) -> tuple[Metric, ...]:
    """Return all metrics of both sides in the order of the reports.

    ``unit`` is the unit of the values; ``same_pixels`` states whether both sides are known to have the same pixel size,
    ``same_count`` whether they have the same number of pixels.
    """
    comparable = {_ANY: True, _PIXEL: same_pixels, _PIXELS: same_pixels and same_count}

    def of_frames(rows: Sequence[_FrameMeasure]) -> list[Metric]:
        averaged = [_averaged(row, frames, comparable[row.scale]) for row in rows]
        return [metric for metric in averaged if not (math.isnan(metric.real) and math.isnan(metric.sim))]

    return (
        *of_frames(_FRAME_MEASURES),
        *_directions(frames, spectra, same_pixels),
        *of_frames(_value_measures(unit)),
        *_decorrelation(temporal, same_pixels),
    )


def _averaged(
    row: _FrameMeasure, frames: tuple[Sequence[FrameResult], Sequence[FrameResult]], comparable: bool
) -> Metric:
    (mean_real, spread_real), (mean_sim, spread_sim) = (
        _mean_and_spread(np.array([row.measure(frame) for frame in side])) for side in frames
    )
    return Metric(
        name=row.name,
        meaning=row.meaning,
        unit=row.unit,
        definition=row.definition,
        group=row.group,
        real=mean_real,
        sim=mean_sim,
        real_spread=spread_real,
        sim_spread=spread_sim,
        difference=mean_sim - mean_real,
        scale=row.scale,
        comparable=comparable,
        is_ratio=row.is_ratio,
        limits=row.limits,
    )


def _mean_and_spread(values: Array) -> tuple[float, float]:
    known = values[~np.isnan(values)]
    return (float(np.mean(known)), float(np.std(known))) if known.size else (math.nan, math.nan)


def _decorrelation(
    temporal: tuple[TemporalAutocorrelation | None, TemporalAutocorrelation | None], same_pixels: bool
) -> list[Metric]:
    real, sim = (
        math.nan if autocorrelation is None else autocorrelation.decorrelation_s for autocorrelation in temporal
    )
    if math.isnan(real) and math.isnan(sim):
        return []
    return [
        Metric(
            name="decorrelation",
            meaning="time until the correlation at fixed pixels falls below 1/e",
            unit="s",
            definition="both",
            group=TIME,
            real=real,
            sim=sim,
            real_spread=math.nan,
            sim_spread=math.nan,
            difference=sim - real,
            scale=_PIXEL,
            comparable=same_pixels,
        )
    ]


def _directions(
    frames: tuple[Sequence[FrameResult], Sequence[FrameResult]],
    spectra: tuple[PowerSpectrum | None, PowerSpectrum | None],
    same_pixels: bool,
) -> list[Metric]:
    """Return the strength and direction of the anisotropy in the mean spectra."""
    if spectra[0] is None or spectra[1] is None or math.isnan(spectra[0].degree + spectra[1].degree):
        return []
    spreads = [
        float(np.std([frame.measures.spectrum.degree for frame in side if frame.measures.spectrum is not None]))
        for side in frames
    ]
    degrees = (spectra[0].degree, spectra[1].degree)
    axes = (spectra[0].long_axis_deg, spectra[1].long_axis_deg)
    turn = (axes[1] - axes[0] + 90.0) % 180.0 - 90.0
    noise = max(spectra[0].degree_noise, spectra[1].degree_noise)
    return [
        Metric(
            name="degree",
            meaning=f"a, where power varies with direction as 1 + a cos 2 (direction - d); by chance about {noise:.2g}",
            unit="1",
            definition="both",
            group=DIRECTIONS,
            real=degrees[0],
            sim=degrees[1],
            real_spread=spreads[0],
            sim_spread=spreads[1],
            difference=degrees[1] - degrees[0],
            scale=_PIXEL,
            comparable=same_pixels,
            is_ratio=False,
        ),
        Metric(
            name="long axis",
            meaning="direction of elongation, from x (east) toward y (north); meaningless if a is at the chance level",
            unit="deg",
            definition="both",
            group=DIRECTIONS,
            real=axes[0],
            sim=axes[1],
            real_spread=math.nan,
            sim_spread=math.nan,
            difference=turn,
            scale=_PIXEL,
            comparable=same_pixels,
            is_ratio=False,
        ),
    ]
