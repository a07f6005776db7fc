"""How like a real image or sequence a simulated one is."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from hcss_twin.comparison.choice import Choice
from hcss_twin.comparison.footage import Footage
from hcss_twin.comparison.grey_clouds import MEANINGS
from hcss_twin.comparison.metrics import build_metrics
from hcss_twin.comparison.opening import open_footage
from hcss_twin.comparison.result import Evaluation, Side
from hcss_twin.comparison.side import (
    In,
    Measured,
    Prepared,
    Progress,
    correlation_over_time,
    measure_side,
    pictured,
)
from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import SMALLEST_SIDE
from hcss_twin.evaluation.definitions import MODES, Mode, eq_24
from hcss_twin.evaluation.distributions import DistributionDistance, distribution_distance
from hcss_twin.evaluation.morphology import Morphology, MorphologyErrors
from hcss_twin.evaluation.power_spectrum import mean_spectrum, spectral_distance_db

BINS = 80

# Relative difference of pixel sizes that still counts as one size, as of the readers of images.
_SAME_SIZE = 0.01

# Relative difference of wavelengths above which temperatures are not of one kind.
_SAME_BAND = 0.1

_PathLike = str | os.PathLike[str]


def evaluate(
    real: _PathLike | Sequence[_PathLike],
    sim: _PathLike | Sequence[_PathLike],
    real_choice: Choice | None = None,
    sim_choice: Choice | None = None,
    *,
    whole: bool = False,
    progress: Progress | None = None,
) -> Evaluation:
    """Compare a simulated image, sequence or cube with a real one.

    Both sides are brought to one quantity: brightness temperature where both have it, else a unit that both share,
    else grey levels of cloud. Nothing is resampled: where shapes differ the central part that both have is compared,
    and measures that depend on the size of pixels are marked where sizes differ.

    Parameters
    ----------
    real, sim : path or sequence of paths
        An image (NetCDF, GOES ABI among them, GeoTIFF, picture, ``.npy``, ``.npz``), several of one sequence, or a
        cube.
    real_choice, sim_choice : Choice, optional
        Variable, band, frames, and what is cloud.
    whole : bool
        Compare all of both although their shapes differ.
    progress : callable, optional
        Wraps the iterable of frames of a side, given their number.

    Returns
    -------
    Evaluation

    Raises
    ------
    CatalogError
        If a file is not a usable image.
    CubeError
        If a cube cannot be read or lacks what is asked for.
    ImageError
        If a choice does not fit its file, an image is too small, or has no measurable cloud.
    """
    choices = (real_choice or Choice(), sim_choice or Choice())
    with ExitStack() as stack:
        first = open_footage("REAL", real, choices[0], stack, None)
        second = open_footage("SIM", sim, choices[1], stack, first)
        notes: list[str] = []
        quantity, unit, kind = _common_quantity(first, second, notes)
        parts = _parts(first, second, whole, notes)
        sides = (
            Prepared("REAL", first, choices[0], kind, parts[0]),
            Prepared("SIM", second, choices[1], kind, parts[1]),
        )
        measured = (measure_side(sides[0], progress), measure_side(sides[1], progress))
        return _compared(sides, measured, quantity, unit, notes)


def _common_quantity(real: Footage, sim: Footage, notes: list[str]) -> tuple[str, str, In]:
    """Return what both sides are compared in, its unit, and its kind."""
    if real.kelvin is not None and sim.kelvin is not None:
        wavelengths = (real.wavelength_um, sim.wavelength_um)
        if (
            None not in wavelengths
            and abs(math.log((wavelengths[1] or 1) / (wavelengths[0] or 1))) > _SAME_BAND
        ):
            notes.append(
                f"The bands differ, {wavelengths[0]:.4g} um and {wavelengths[1]:.4g} um: temperatures are not of one "
                "kind; compare shapes rather than values."
            )
        return "brightness temperature", "K", "kelvin"
    if real.units and real.units == sim.units:
        return sim.quantity, sim.units, "unit"
    told = [f"{each.quantity} in {each.units!r}" if each.units else each.quantity for each in (real, sim)]
    notes.append(
        f"No common quantity ({told[0]}; {told[1]}): values are grey levels of cloud, 0 clear, 1 to 255 from "
        "the least to the most, each side by its own."
    )
    return "grey level of cloud", "", "grey levels"


def _parts(
    real: Footage, sim: Footage, whole: bool, notes: list[str]
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return rows and columns of both sides that are compared."""
    for title, each in (("REAL", real), ("SIM", sim)):
        if min(each.shape) < SMALLEST_SIDE:
            raise ImageError(
                f"{title} {each.name}: {each.shape[0]} rows x {each.shape[1]} columns, allowed: {SMALLEST_SIDE} or "
                "more along each axis"
            )
    common = (min(real.shape[0], sim.shape[0]), min(real.shape[1], sim.shape[1]))
    sizes = (real.pixel_size_m, sim.pixel_size_m)
    if None in sizes:
        unknown = real if sizes[0] is None else sim
        notes.append(
            f"The pixel size of {unknown.name} is not known: whether measures that depend on it compare cannot be "
            "said; they are marked ~."
        )
    elif not _same_size(real, sim):
        notes.append(
            f"Pixels differ, {sizes[0]:.6g} m and {sizes[1]:.6g} m, and are not resampled: measures that depend on "
            "their size are marked ~, and spectra are given in cycles per pixel and per km."
        )
    if real.shape == sim.shape or whole:
        if real.shape != sim.shape:
            notes.append("The sides have different numbers of pixels; DP grows with it.")
        return _centre(real.shape, real.shape), _centre(sim.shape, sim.shape)
    notes.append(
        f"Compared are the central {common[0]} rows x {common[1]} columns of {real.shape[0]} x {real.shape[1]} and "
        f"{sim.shape[0]} x {sim.shape[1]}; clouds were found in the whole frames."
    )
    return _centre(real.shape, common), _centre(sim.shape, common)


def _same_size(real: Footage, sim: Footage) -> bool:
    one, other = real.pixel_size_m, sim.pixel_size_m
    return one is not None and other is not None and abs(one - other) <= _SAME_SIZE * max(one, other)


def _centre(shape: tuple[int, int], part: tuple[int, int]) -> tuple[slice, slice]:
    first = [(size - wanted) // 2 for size, wanted in zip(shape, part, strict=True)]
    return slice(first[0], first[0] + part[0]), slice(first[1], first[1] + part[1])


def _compared(
    sides: tuple[Prepared, Prepared],
    measured: tuple[Measured, Measured],
    quantity: str,
    unit: str,
    notes: list[str],
) -> Evaluation:
    real, sim = measured
    partners, pairing = _pairs(real, sim)
    errors: dict[Mode, Sequence[MorphologyErrors]] = {
        mode: _errors(real, sim, partners, mode, notes) for mode in MODES
    }
    distributions = _distances(sides, measured, partners)
    edges = _edges(real.kept, sim.kept)
    shown = _typical(errors["as-printed"], len(sim.frames))
    shown_real = partners[shown] if partners[shown] is not None else 0
    assert shown_real is not None
    results = [
        _side(side, each, side.footage.notes, edges, which)
        for side, each, which in zip(sides, measured, (shown_real, shown), strict=True)
    ]
    spectra = (results[0].spectrum, results[1].spectrum)
    metrics = build_metrics(
        real.frames,
        sim.frames,
        spectra,
        (results[0].temporal, results[1].temporal),
        unit,
        same_pixels=_same_size(sides[0].footage, sides[1].footage),
        same_count=sides[0].shape == sides[1].shape,
    )
    both = spectra[0] is not None and spectra[1] is not None
    return Evaluation(
        real=results[0],
        sim=results[1],
        quantity=quantity,
        unit=unit,
        pairing=pairing,
        metrics=metrics,
        errors=errors,
        distributions=distributions,
        spectral_distance_db=spectral_distance_db(spectra[0], spectra[1]) if both else math.nan,  # type: ignore[arg-type]
        edges=edges,
        notes=tuple(notes),
    )


def _pairs(real: Measured, sim: Measured) -> tuple[list[int | None], str]:
    """Return the real frame each simulated one is compared with, None for the mean of all; and say so."""
    count = len(sim.frames)
    if len(real.frames) == 1:
        told = "one real image with one simulated one"
        if count > 1:
            told = (
                f"the one real image with each of {count} simulated frames; its change over time is not known"
            )
        return [0] * count, told
    if len(real.frames) == count and not (real.left_out or sim.left_out):
        return list(range(count)), f"{count} real frames with {count} simulated ones, one by one"
    return [None] * count, (
        f"each simulated frame ({count}) with the mean of {len(real.frames)} real ones; values with those "
        "of all real ones"
    )


def _errors(
    real: Measured, sim: Measured, partners: list[int | None], mode: Mode, notes: list[str]
) -> tuple[MorphologyErrors, ...]:
    mean = _mean_morphology([frame.measures.morphology for frame in real.frames])
    try:
        return tuple(
            eq_24(
                mean if partner is None else real.frames[partner].measures.morphology,
                frame.measures.morphology,
                mode,
            )
            for frame, partner in zip(sim.frames, partners, strict=True)
        )
    except ImageError as error:
        notes.append(f"No RMSE of eq 24, {mode}: {error}.")
        return ()


def _mean_morphology(shapes: Sequence[Morphology]) -> Morphology:
    names = Morphology.__dataclass_fields__
    return Morphology(**{name: float(np.mean([getattr(each, name) for each in shapes])) for name in names})


def _distances(
    sides: tuple[Prepared, Prepared], measured: tuple[Measured, Measured], partners: list[int | None]
) -> tuple[DistributionDistance, ...]:
    found = []
    last: tuple[int | None, NDArray[np.floating]] = (None, measured[0].kept)
    for number, partner in zip(measured[1].numbers, partners, strict=True):
        if partner is not None and last[0] != partner:
            last = (partner, sides[0].frame(measured[0].numbers[partner])[0])
        found.append(distribution_distance(last[1], sides[1].frame(number)[0]))
    return tuple(found)


def _edges(real: NDArray[np.float32], sim: NDArray[np.float32]) -> NDArray[np.float64]:
    low = min(float(np.nanmin(real)), float(np.nanmin(sim)))
    high = max(float(np.nanmax(real)), float(np.nanmax(sim)))
    return np.linspace(low, high, BINS + 1)


def _typical(errors: Sequence[MorphologyErrors], count: int) -> int:
    """Return the simulated frame with the median RMSE, the lower of two; the first where there is none."""
    if not errors:
        return 0
    order = np.argsort([each.rmse for each in errors], kind="stable")
    return int(order[(count - 1) // 2])


def _side(
    side: Prepared, measured: Measured, told: Sequence[str], edges: NDArray[np.float64], shown: int
) -> Side:
    footage = side.footage
    notes = list(told)
    missing = sum(frame.missing for frame in measured.frames)
    if missing:
        share = missing / (len(measured.frames) * side.shape[0] * side.shape[1])
        notes.append(
            f"{100 * share:.2f} % of the pixels are missing: left out of pairs, coverage and histograms; boxes and "
            "spectra are of the largest rectangle without them."
        )
    for reason in dict.fromkeys(reason for frame in measured.frames for reason in frame.measures.left_out):
        notes.append(f"Not measured: {reason}.")
    for label, why in measured.left_out:
        notes.append(f"Frame {label} left out: {why}.")
    if len(measured.frames) > 1 and footage.method in ("otsu", "local"):
        notes.append("Each frame has a threshold of its own.")
    spectra = [frame.measures.spectrum for frame in measured.frames if frame.measures.spectrum is not None]
    spectrum = mean_spectrum(spectra)
    if spectra and spectrum is None:
        notes.append("No mean spectrum: missing pixels leave parts of different sizes in different frames.")
    counts, _ = np.histogram(measured.kept, bins=edges.astype(np.float64))
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
