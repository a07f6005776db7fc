"""Results of a comparison: measures of each side, metrics of both, and their JSON form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.definitions import DEFINITIONS, Mode
from hcss_evaluate.comparison.image_measures import DistributionDistance, ImageMeasures, TemporalAutocorrelation
from hcss_evaluate.measures.morphology import MorphologyErrors
from hcss_evaluate.measures.power_spectrum import PowerSpectrum
from hcss_evaluate.numbers import json_number
from hcss_twin.core.json_numbers import json_value


@dataclass(frozen=True)
class FrameResult:
    """Measures of one frame of one side.

    Attributes
    ----------
    seconds : float
        Time after the first frame; NaN if unknown.
    missing : int
        Number of pixels that are neither known cloudy nor known clear.
    truth_coverage : float
        Cloud fraction from the file's own mask; NaN if it has none.
    """

    label: str
    seconds: float
    measures: ImageMeasures
    missing: int
    truth_coverage: float


@dataclass(frozen=True)
class Pictured:
    """The frame shown in the report, rows northward.

    Attributes
    ----------
    level : ndarray of float32 (rows, columns)
        0 clear, 1 to 255.
    known : ndarray of bool (rows, columns)
        Whether a pixel is known to be cloudy or clear.
    pairs : ndarray of int64 (256, 256)
        2-D histogram of horizontal neighbours.
    """

    label: str
    values: NDArray[np.float64]
    level: NDArray[np.float32]
    known: NDArray[np.bool_]
    pairs: NDArray[np.int64]


@dataclass(frozen=True)
class Side:
    """Measures of the real or the simulated side.

    Attributes
    ----------
    name, kind, quantity, units, band : str
        Of the file.
    shape, part : tuple of int
        Rows and columns of the file and of the compared part.
    method, mask : str
        Cloud detection method and its description; ``bright_is_cloud`` refers to the compared values.
    left_out : sequence of (str, str)
        Excluded frames and the reasons.
    histogram : ndarray (bins,)
        Fraction of all compared pixels in each bin of :attr:`Evaluation.edges`.
    spectrum, temporal : PowerSpectrum, TemporalAutocorrelation or None
        Mean spectrum over frames, and correlation over time if there are two frames or more.
    """

    name: str
    kind: str
    quantity: str
    units: str
    band: str
    shape: tuple[int, int]
    part: tuple[int, int]
    pixel_size_m: float | None
    method: str
    mask: str
    bright_is_cloud: bool
    frames: Sequence[FrameResult]
    left_out: Sequence[tuple[str, str]]
    histogram: NDArray[np.float64]
    spectrum: PowerSpectrum | None
    temporal: TemporalAutocorrelation | None
    pictured: Pictured
    notes: Sequence[str]

    @property
    def pictured_coverage(self) -> float:
        """Cloud fraction of the known pixels of the pictured frame."""
        return int(np.count_nonzero(self.pictured.level)) / int(np.count_nonzero(self.pictured.known))


def side_document(side: Side) -> dict[str, Any]:
    """Return the side without its picture, for JSON."""
    spectrum, temporal = side.spectrum, side.temporal
    return {
        **{key: getattr(side, key) for key in ("name", "kind", "quantity", "units", "band", "method", "mask")},
        "pixel_size_m": side.pixel_size_m,
        "rows": side.shape[0],
        "columns": side.shape[1],
        "compared_rows": side.part[0],
        "compared_columns": side.part[1],
        "cloud_is": "bright" if side.bright_is_cloud else "dark",
        "notes": list(side.notes),
        "frames": [_frame(frame) for frame in side.frames],
        "frames_left_out": [{"frame": label, "reason": why} for label, why in side.left_out],
        "histogram": json_value(side.histogram),
        "spectrum": None
        if spectrum is None
        else {
            "wavenumber_cycles_per_pixel": json_value(spectrum.wavenumber),
            "power": json_value(spectrum.power),
            "direction_deg": json_value(spectrum.direction_deg),
            "by_direction": json_value(spectrum.by_direction),
        },
        "temporal_autocorrelation": None
        if temporal is None
        else {
            "lag_frames": temporal.lag.tolist(),
            "lag_s": json_value(temporal.lag_s),
            "correlation": json_value(temporal.correlation),
            "decorrelation_s": json_number(temporal.decorrelation_s),
            "pixels": temporal.pixels,
        },
    }


def _frame(frame: FrameResult) -> dict[str, Any]:
    measured = frame.measures
    shape = {name: json_number(getattr(measured.morphology, name)) for name in vars(measured.morphology)}
    return {
        "label": frame.label,
        "seconds": json_number(frame.seconds),
        "missing_pixels": frame.missing,
        "mean": measured.mean,
        "deviation": measured.deviation,
        "mean_level": measured.mean_level,
        **shape,
        "truth_coverage": json_number(frame.truth_coverage),
        "dimensions": {
            name: {"dimension": found.dimension, "standard_error": json_number(found.standard_error)}
            for name, found in measured.dimensions.items()
        },
        "left_out": list(measured.left_out),
    }


TERMS: dict[Mode, dict[str, str]] = {
    "as-printed": {"EV": "EV", "Den": "Den, printed", "DP": "DP, printed", "FD": "FD"},
    "corrected": {"EV": "EV", "Den": "Den", "DP": "DP", "FD": "FD"},
}
"""Terms of eq 24 in each definition, and the corresponding metrics."""

Dependence = Literal["any", "pixel size", "pixel size and number of pixels"]


@dataclass(frozen=True)
class Metric:
    """One metric of both sides.

    Attributes
    ----------
    definition : {"as-printed", "corrected", "both"}
        Definition of eqs 21 to 24 to which the metric belongs.
    group : str
        Heading in reports.
    real, sim, real_spread, sim_spread : float
        Means and standard deviations over frames; the spread is 0 for one frame and NaN for none.
    difference : float
        sim - real; directions modulo 180 degrees.
    scale, comparable
        Image property on which the metric depends (such as pixel size), and whether both sides share it.
    is_ratio : bool
        Whether a difference relative to the real value is meaningful.
    limits : (float, float) or None
        Theoretical minimum and maximum; an estimator may exceed them.
    """

    name: str
    meaning: str
    unit: str
    definition: Literal["as-printed", "corrected", "both"]
    group: str
    real: float
    sim: float
    real_spread: float
    sim_spread: float
    difference: float
    scale: Dependence
    comparable: bool
    is_ratio: bool = True
    limits: tuple[float, float] | None = None

    def is_out_of_range(self, value: float) -> bool:
        """Whether a value is outside the limits; NaN is not."""
        return self.limits is not None and (value < self.limits[0] or value > self.limits[1])

    @property
    def relative(self) -> float:
        """Difference divided by the real value; NaN where that is meaningless."""
        if not self.is_ratio:
            return math.nan
        if self.difference == 0.0:
            return 0.0
        return self.difference / self.real if self.real else math.nan


@dataclass(frozen=True)
class Evaluation:
    """Result of comparing a simulated image or sequence with a real one.

    Attributes
    ----------
    quantity, unit : str
        Compared quantity: brightness temperature (K), one in a common unit, or grey levels ("").
    pairing : str
        Description of the pairing of frames.
    errors : dict of str to sequence of MorphologyErrors
        Eq 24 for each simulated frame, "as-printed" and "corrected"; empty if a divisor is 0.
    distributions : sequence of DistributionDistance
        Distance of each simulated frame from its reference.
    spectral_distance_db : float
        Root mean square difference of the mean spectra.
    edges : ndarray (bins + 1,)
        Bin edges of both histograms, in the compared unit.
    notes : sequence of str
        Limitations of the comparison.
    """

    real: Side
    sim: Side
    quantity: str
    unit: str
    pairing: str
    metrics: Sequence[Metric]
    errors: dict[Mode, Sequence[MorphologyErrors]]
    distributions: Sequence[DistributionDistance]
    spectral_distance_db: float
    edges: NDArray[np.float64]
    notes: Sequence[str]

    def metric(self, name: str) -> Metric:
        """Return a metric by its name.

        Raises KeyError if there is none.
        """
        for metric in self.metrics:
            if metric.name == name:
                return metric
        raise KeyError(name)

    def rmse(self, mode: Mode) -> float:
        """Return the mean over frames of eq 24's RMSE, as a fraction; NaN if undefined."""
        errors = self.errors[mode]
        return float(np.mean([error.rmse for error in errors])) if errors else math.nan

    def rmse_compares(self, mode: Mode) -> bool:
        """Whether all terms of eq 24's RMSE are comparable between the sides."""
        names = TERMS[mode].values()
        return all(metric.comparable for metric in self.metrics if metric.name in names)

    def distance(self, name: str) -> float:
        """Return the mean over frames of a distance between distributions, selected by attribute name."""
        return float(np.mean([getattr(distribution, name) for distribution in self.distributions]))

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the pictures, for JSON; undefined numbers are None."""
        return {
            "quantity": self.quantity,
            "unit": self.unit,
            "pairing": self.pairing,
            "notes": list(self.notes),
            "definitions": {
                definition.name: {"as-printed": definition.as_printed, "corrected": definition.corrected}
                for definition in DEFINITIONS
            },
            "eq24": {mode: self._eq_24(mode) for mode in self.errors},
            "metrics": [
                {
                    **{key: getattr(metric, key) for key in _OF_A_METRIC},
                    **{key: json_number(getattr(metric, key)) for key in _NUMBERS_OF_A_METRIC},
                }
                for metric in self.metrics
            ],
            "distributions": {
                key: json_number(self.distance(key)) for key in DistributionDistance.__dataclass_fields__
            },
            "spectral_distance_db": json_number(self.spectral_distance_db),
            "histogram_edges": json_value(self.edges),
            "real": side_document(self.real),
            "sim": side_document(self.sim),
        }

    def _eq_24(self, mode: Mode) -> dict[str, Any]:
        errors = self.errors[mode]
        names = {"EV": "entropy", "Den": "density", "DP": "diagonal_peak", "FD": "fractal_dimension", "RMSE": "rmse"}
        return {
            **{
                name: json_number(float(np.mean([getattr(error, field) for error in errors]))) if errors else None
                for name, field in names.items()
            },
            "RMSE_spread": float(np.std([error.rmse for error in errors])) if errors else None,
            "RMSE_of_frames": [error.rmse for error in errors],
        }


_OF_A_METRIC = ("name", "meaning", "unit", "definition", "group", "scale", "comparable")
_NUMBERS_OF_A_METRIC = ("real", "real_spread", "sim", "sim_spread", "difference", "relative")
