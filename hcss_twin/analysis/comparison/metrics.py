"""The metrics of a comparison: each is a measure of single frames, averaged over the frames of each side."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcss_twin.analysis.comparison.result import FrameResult, Metric, Scale
from hcss_twin.analysis.measures.image_measures import TemporalAutocorrelation
from hcss_twin.analysis.measures.morphology import Mode, four_measures
from hcss_twin.analysis.measures.power_spectrum import PowerSpectrum

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

# Of the dimension of a surface.
_SURFACE = (2.0, 3.0)

_PIXEL: Scale = "pixel size"
_PIXELS: Scale = "pixel size and number of pixels"
_ANY: Scale = "any"


def build_metrics(
    real: Sequence[FrameResult],
    sim: Sequence[FrameResult],
    spectra: tuple[PowerSpectrum | None, PowerSpectrum | None],
    temporal: tuple[TemporalAutocorrelation | None, TemporalAutocorrelation | None],
    unit: str,
    *,
    same_pixels: bool,
    same_count: bool,
) -> tuple[Metric, ...]:
    """Return all measures of both sides.

    Parameters
    ----------
    real, sim : sequence of FrameResult
    spectra, temporal : tuple
        Of the real and of the simulated side.
    unit : str
        Of the values.
    same_pixels : bool
        Whether both sides are known to have pixels of one size.
    same_count : bool
        Whether both have as many pixels.
    """
    comparable = {_ANY: True, _PIXEL: same_pixels, _PIXELS: same_pixels and same_count}
    metrics = []
    for row in _rows(unit):
        sides = [np.array([row.measure(frame) for frame in frames]) for frames in (real, sim)]
        if all(np.isnan(side).all() for side in sides):
            continue
        (mean_real, spread_real), (mean_sim, spread_sim) = (_mean_and_spread(side) for side in sides)
        metrics.append(
            Metric(
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
                comparable=comparable[row.scale],
                is_ratio=row.is_ratio,
                limits=row.limits,
            )
        )
    directions = _directions(real, sim, spectra, same_pixels)
    place = next(n for n, each in enumerate(metrics) if each.group == VALUES)
    metrics[place:place] = directions
    times = [math.nan if each is None else each.decorrelation_s for each in temporal]
    if not all(map(math.isnan, times)):
        metrics.append(
            Metric(
                name="decorrelation",
                meaning="time until the correlation at fixed pixels falls below 1/e",
                unit="s",
                definition="both",
                group=TIME,
                real=times[0],
                sim=times[1],
                real_spread=math.nan,
                sim_spread=math.nan,
                difference=times[1] - times[0],
                scale=_PIXEL,
                comparable=same_pixels,
            )
        )
    return tuple(metrics)


@dataclass(frozen=True)
class _Row:
    """A measure that every frame has for itself."""

    group: str
    name: str
    meaning: str
    measure: Measure
    unit: str = "1"
    definition: Definition = "both"
    scale: Scale = _PIXEL
    is_ratio: bool = True
    limits: tuple[float, float] | None = None


def _rows(unit: str) -> Iterator[_Row]:
    """Yield the rows; values have ``unit``."""
    yield _Row(FOUR, "EV", "entropy of neighbouring grey levels (eq 21)", _four("as-printed", "entropy"), unit="bit")
    yield _Row(FOUR, "Den, printed", "ten times eq 22", _four("as-printed", "density"), definition="as-printed")
    yield _Row(
        FOUR,
        "Den",
        "mean of 1 / (1 + difference of neighbours) (eq 22)",
        _four("corrected", "density"),
        definition="corrected",
    )
    yield _Row(
        FOUR,
        "DP, printed",
        "pairs of equal neighbours over W - 1 (eq 23)",
        _four("as-printed", "diagonal_peak"),
        definition="as-printed",
        scale=_PIXELS,
    )
    yield _Row(
        FOUR,
        "DP",
        "over W, the entries of the diagonal",
        _four("corrected", "diagonal_peak"),
        definition="corrected",
        scale=_PIXELS,
    )
    yield _Row(
        FOUR,
        "equal",
        "share of equal neighbours: DP without the number of pixels",
        lambda frame: frame.measures.equal_neighbours,
        definition="corrected",
    )
    yield _Row(FOUR, "FD", "boxes that fill the body of the cloud (eq 6)", _shape("fractal_dimension"))
    yield _Row(CLOUDS, "coverage", "cloudy part of the pixels", _shape("coverage"), scale=_ANY)
    yield _Row(
        CLOUDS,
        "coverage, truth",
        "the same by the file's own cloud mask",
        lambda frame: frame.truth_coverage,
        scale=_ANY,
    )
    yield _Row(
        CLOUDS,
        "level",
        "mean grey level of cloudy pixels, 1 to 255",
        lambda frame: frame.measures.mean_level,
        scale=_ANY,
    )
    yield _Row(
        DIMENSIONS, "tops", "surface of the cloudy pixels: variogram", _shape("surface_dimension"), limits=_SURFACE
    )
    yield _Row(DIMENSIONS, "outline", "outlines of the clouds: boxes on the boundary", _shape("boundary_dimension"))
    for name, meaning, key in (
        ("variogram", "surface of all values: variogram, lags 1 and 2", "variogram"),
        ("spectrum", "surface of all values: slope of the spectrum, 4 - beta / 2", "spectrum"),
        ("boxes", "surface of all values: differential box counting, calibrated", "box counting"),
        ("boxes, raw", "the same as its authors define it", "box counting, raw"),
    ):
        yield _Row(DIMENSIONS, name, meaning, _dimension(key), limits=_SURFACE)
    yield _Row(
        DIRECTIONS, "semivariance", "of cloudy pixels along y over that along x, 1 and 2 pixels", _shape("anisotropy")
    )
    yield _Row(DIRECTIONS, "aspect", "length along x over length along y", _shape("aspect"))
    # Kelvin has a zero, but nothing here is near it.
    yield _Row(
        VALUES, "mean", "of all pixels", lambda frame: frame.measures.mean, unit, scale=_ANY, is_ratio=unit != "K"
    )
    yield _Row(
        VALUES,
        "deviation",
        "standard deviation of all pixels",
        lambda frame: frame.measures.deviation,
        unit,
        scale=_ANY,
    )


def _four(mode: Mode, name: str) -> Measure:
    return lambda frame: float(getattr(four_measures(frame.measures.morphology, mode), name))


def _shape(name: str) -> Measure:
    return lambda frame: float(getattr(frame.measures.morphology, name))


def _dimension(name: str) -> Measure:
    def measure(frame: FrameResult) -> float:
        found = frame.measures.dimensions.get(name)
        return math.nan if found is None else found.dimension

    return measure


def _mean_and_spread(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[float, float]:
    known = values[~np.isnan(values)]
    return (float(np.mean(known)), float(np.std(known))) if known.size else (math.nan, math.nan)


def _directions(
    real: Sequence[FrameResult],
    sim: Sequence[FrameResult],
    spectra: tuple[PowerSpectrum | None, PowerSpectrum | None],
    same_pixels: bool,
) -> list[Metric]:
    """Return strength and direction of the anisotropy of the mean spectra."""
    if spectra[0] is None or spectra[1] is None or math.isnan(spectra[0].degree + spectra[1].degree):
        return []
    spreads = [
        float(np.std([f.measures.spectrum.degree for f in frames if f.measures.spectrum is not None]))
        for frames in (real, sim)
    ]
    degrees = [each.degree for each in spectra if each is not None]
    axes = [each.long_axis_deg for each in spectra if each is not None]
    turn = (axes[1] - axes[0] + 90.0) % 180.0 - 90.0
    noise = max(spectra[0].degree_noise, spectra[1].degree_noise)
    return [
        Metric(
            name="degree",
            meaning=f"a, where power by direction goes as 1 + a cos 2 (direction - d); by chance about {noise:.2g}",
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
            meaning="direction along which things are long, from x (east) toward y (north); means nothing where a is "
            "what chance gives",
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
