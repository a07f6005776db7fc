"""What was measured of the real or the simulated side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.measures.image_measures import ImageMeasures
from hcss_twin.analysis.measures.power_spectrum import PowerSpectrum
from hcss_twin.analysis.measures.temporal import TemporalAutocorrelation
from hcss_twin.core.json_numbers import json_list, json_number


@dataclass(frozen=True)
class FrameResult:
    """One frame of one side.

    Attributes
    ----------
    label : str
    seconds : float
        After the first frame; NaN where times are not known.
    measures : ImageMeasures
    missing : int
        Pixels of which it is not known whether they are cloudy.
    truth_coverage : float
        Cloudy part by the file's own mask; NaN where it has none.
    """

    label: str
    seconds: float
    measures: ImageMeasures
    missing: int
    truth_coverage: float


@dataclass(frozen=True)
class Pictured:
    """The frame that is drawn.

    Attributes
    ----------
    label : str
    values : ndarray (rows, columns)
        Rows northward.
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
    """The real or the simulated side.

    Attributes
    ----------
    name, kind, quantity, units, band : str
        Of the file.
    shape, part : tuple of int
        Rows and columns of the file, and of what was compared.
    pixel_size_m : float or None
    method, mask : str
        How cloud was found, and in words.
    bright_is_cloud : bool
        In the values that are compared.
    frames : sequence of FrameResult
    left_out : sequence of (str, str)
        Frames that could not be measured, and why.
    histogram : ndarray (bins,)
        Share of all compared pixels of all frames in each bin of :attr:`Evaluation.edges`.
    spectrum : PowerSpectrum or None
        Mean over frames.
    temporal : TemporalAutocorrelation or None
        Where there are two frames or more.
    pictured : Pictured
    notes : sequence of str
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
        """Cloudy part of the known pixels of the pictured frame."""
        return int(np.count_nonzero(self.pictured.level)) / int(np.count_nonzero(self.pictured.known))


def side_document(side: Side) -> dict[str, Any]:
    """Return all of a side but its picture, for JSON."""
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
        "frames": [_frame(each) for each in side.frames],
        "frames_left_out": [{"frame": label, "reason": why} for label, why in side.left_out],
        "histogram": json_list(side.histogram),
        "spectrum": None
        if spectrum is None
        else {
            "wavenumber_cycles_per_pixel": json_list(spectrum.wavenumber),
            "power": json_list(spectrum.power),
            "direction_deg": json_list(spectrum.direction_deg),
            "by_direction": json_list(spectrum.by_direction),
        },
        "temporal_autocorrelation": None
        if temporal is None
        else {
            "lag_frames": temporal.lag.tolist(),
            "lag_s": json_list(temporal.lag_s),
            "correlation": json_list(temporal.correlation),
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
