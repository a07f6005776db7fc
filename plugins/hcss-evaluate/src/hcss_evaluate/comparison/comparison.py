"""Comparison of a simulated image, sequence or cube with a real one (``hcss evaluate``)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from hcss_evaluate.comparison.definitions import MODES, Mode
from hcss_evaluate.comparison.footage import EvaluationChoice
from hcss_evaluate.comparison.image_footage import open_footage
from hcss_evaluate.comparison.metrics import build_metrics
from hcss_evaluate.comparison.pairing import (
    common_parts,
    common_quantity,
    distances_of_frames,
    errors_of_frames,
    pair_frames,
    same_number,
    same_pixel_size,
    typical_frame,
)
from hcss_evaluate.comparison.result import Evaluation, Side
from hcss_evaluate.comparison.side import (
    MEANINGS,
    ComparedSide,
    Progress,
    SideMeasures,
    correlation_over_time,
    measure_side,
    pictured,
)
from hcss_evaluate.measures.morphology import MorphologyErrors
from hcss_evaluate.measures.power_spectrum import mean_spectrum, spectral_distance_db
from hcss_twin.core.arguments import checked
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, ImageError

BINS = 80
_PathLike = str | os.PathLike[str]


@checked
def evaluate(
    real: _PathLike | Sequence[_PathLike],
    sim: _PathLike | Sequence[_PathLike],
    real_choice: EvaluationChoice | None = None,
    sim_choice: EvaluationChoice | None = None,
    *,
    whole: bool = False,
    progress: Progress | None = None,
) -> Evaluation:
    """Compare a simulated image, sequence or cube with a real one.

    Both sides are converted to one quantity: brightness temperature if both have it, else a common unit, else grey
    levels of cloud. Nothing is resampled: if the shapes differ, the central part common to both is compared; if the
    pixel sizes differ, measures that depend on pixel size are marked.

    Parameters
    ----------
    real, sim : path or sequence of paths
        An image (NetCDF including GOES ABI, GeoTIFF, picture, ``.npy``, ``.npz``), several images of one sequence, or a
        cube.
    real_choice, sim_choice : EvaluationChoice, optional
        Variable, band, frames and cloud detection of each side.
    whole : bool
        Compare whole frames even if their shapes differ.
    progress : callable, optional
        Wraps the iterable of a side's frames, given their number.

    Returns
    -------
    Evaluation

    Raises
    ------
    CatalogError
        If a file is not a usable image.
    CubeError
        If a cube cannot be read or lacks the requested data.
    ImageError
        If an option does not apply to its file, or an image is too small or has no measurable cloud.
    """
    choices = (real_choice or EvaluationChoice(), sim_choice or EvaluationChoice())
    with ExitStack() as stack:
        first = open_footage("REAL", real, choices[0], stack, None)
        second = open_footage("SIM", sim, choices[1], stack, first)
        notes: list[str] = []
        quantity, unit, kind = common_quantity(first, second, notes)
        parts = common_parts(first, second, whole, notes)
        sides = (
            ComparedSide("REAL", first, choices[0], kind, parts[0]),
            ComparedSide("SIM", second, choices[1], kind, parts[1]),
        )
        measured = (_measured(sides[0], progress), _measured(sides[1], progress))
        return _compared(sides, measured, quantity, unit, notes)


def _measured(side: ComparedSide, progress: Progress | None) -> SideMeasures:
    """Measure a side; what its values cannot be measured for is an error that names its file."""
    with Reading(side.footage.name, ImageError, "its values cannot be measured"):
        return measure_side(side, progress)


def _compared(
    sides: tuple[ComparedSide, ComparedSide],
    measured: tuple[SideMeasures, SideMeasures],
    quantity: str,
    unit: str,
    notes: list[str],
) -> Evaluation:
    real, sim = measured
    partners, pairing = pair_frames(real, sim)
    errors: dict[Mode, Sequence[MorphologyErrors]] = {
        mode: errors_of_frames(real, sim, partners, mode, notes) for mode in MODES
    }
    distributions = distances_of_frames(sides, measured, partners)
    low = min(float(np.nanmin(side.values)) for side in measured)
    high = max(float(np.nanmax(side.values)) for side in measured)
    edges = np.linspace(low, high, BINS + 1)
    shown = typical_frame(errors["as-printed"], len(sim.frames))
    shown_real = partners[shown] if partners[shown] is not None else 0
    assert shown_real is not None
    results = [
        _side(side, measured_side, edges, which)
        for side, measured_side, which in zip(sides, measured, (shown_real, shown), strict=True)
    ]
    spectra = (results[0].spectrum, results[1].spectrum)
    metrics = build_metrics(
        (real.frames, sim.frames),
        spectra,
        (results[0].temporal, results[1].temporal),
        unit,
        same_pixels=same_pixel_size(sides[0].footage, sides[1].footage),
        same_count=same_number(sides, measured, notes),
    )
    return Evaluation(
        real=results[0],
        sim=results[1],
        quantity=quantity,
        unit=unit,
        pairing=pairing,
        metrics=metrics,
        errors=errors,
        distributions=distributions,
        spectral_distance_db=spectral_distance_db(*spectra),
        edges=edges,
        notes=tuple(notes),
    )


def _side(side: ComparedSide, measured: SideMeasures, edges: Array, shown: int) -> Side:
    footage = side.footage
    notes = list(footage.notes)
    missing = sum(frame.missing for frame in measured.frames)
    if missing:
        share = missing / (len(measured.frames) * side.shape[0] * side.shape[1])
        notes.append(
            f"{100 * share:.2f} % of the pixels are missing: excluded from pairs, coverage and histograms; boxes and "
            "spectra use the largest rectangle without missing pixels."
        )
    empty = float(np.mean(np.isnan(measured.values)))
    if footage.method == "valid" and empty > 0.0 and not missing:
        notes.append(f"{100 * empty:.2f} % of the pixels have no value: they are clear, and not in the histogram.")
    for reason in dict.fromkeys(reason for frame in measured.frames for reason in frame.measures.left_out):
        notes.append(f"Not measured: {reason}.")
    for label, why in measured.left_out:
        notes.append(f"Frame {label} is excluded: {why}.")
    if len(measured.frames) > 1 and footage.method in ("otsu", "local"):
        notes.append("Each frame has a threshold of its own.")
    spectra = [frame.measures.spectrum for frame in measured.frames if frame.measures.spectrum is not None]
    spectrum = mean_spectrum(spectra)
    if spectra and spectrum is None:
        notes.append("No mean spectrum: missing pixels leave parts of different sizes in different frames.")
    counts, _ = np.histogram(measured.values, bins=edges.astype(np.float64))
    temporal = correlation_over_time(measured, notes)
    return Side(
        name=footage.name,
        kind=footage.kind,
        quantity=footage.quantity,
        units=footage.units,
        band=footage.band,
        shape=footage.shape,
        part=side.shape,
        pixel_size_m=footage.pixel_size_m,
        method=footage.method,
        mask=MEANINGS[footage.method],
        bright_is_cloud=footage.bright_is_cloud,
        frames=measured.frames,
        left_out=measured.left_out,
        histogram=counts / max(1, int(counts.sum())),
        spectrum=spectrum,
        temporal=temporal,
        pictured=pictured(side, measured.numbers[shown]),
        notes=tuple(notes),
    )
