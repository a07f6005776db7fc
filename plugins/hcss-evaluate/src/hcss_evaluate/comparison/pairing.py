"""Common quantity, part and pixel count of both sides of a comparison, and the pairing of frames."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.definitions import Mode, eq_24
from hcss_evaluate.comparison.footage import Footage
from hcss_evaluate.comparison.image_measures import DistributionDistance, distribution_distance
from hcss_evaluate.comparison.side import ComparedAs, ComparedSide, SideMeasures
from hcss_evaluate.measures.images import SMALLEST_SIDE
from hcss_evaluate.measures.morphology import Morphology, MorphologyErrors
from hcss_twin.providers import ImageError

# Largest relative difference of pixel sizes that count as equal, as in the image readers.
_SAME_SIZE = 0.01

# Largest relative difference of pixel counts that is negligible for DP.
_SAME_COUNT = 1e-3

# Relative difference of wavelengths above which brightness temperatures are not comparable.
_SAME_BAND = 0.1


def common_quantity(real: Footage, sim: Footage, notes: list[str]) -> tuple[str, str, ComparedAs]:
    """Return the compared quantity, its unit and its kind."""
    if real.kelvin is not None and sim.kelvin is not None:
        wavelengths = (real.wavelength_um, sim.wavelength_um)
        if None not in wavelengths and abs(math.log((wavelengths[1] or 1) / (wavelengths[0] or 1))) > _SAME_BAND:
            notes.append(
                f"The bands differ, {wavelengths[0]:.4g} um and {wavelengths[1]:.4g} um: temperatures are not "
                "comparable; compare shapes rather than values."
            )
        return "brightness temperature", "K", "kelvin"
    if real.units and real.units == sim.units:
        return sim.quantity, sim.units, "unit"
    described = [
        f"{footage.quantity} in {footage.units!r}" if footage.units else footage.quantity for footage in (real, sim)
    ]
    notes.append(
        f"No common quantity ({described[0]}; {described[1]}): values are grey levels of cloud, 0 clear, 1 to 255 from "
        "the thinnest to the thickest cloud, each side on its own scale."
    )
    return "grey level of cloud", "", "grey levels"


def common_parts(
    real: Footage, sim: Footage, whole: bool, notes: list[str]
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the compared rows and columns of both sides."""
    for title, footage in (("REAL", real), ("SIM", sim)):
        if min(footage.shape) < SMALLEST_SIDE:
            raise ImageError(
                f"{title} {footage.name}: {footage.shape[0]} rows x {footage.shape[1]} columns, allowed: "
                f"{SMALLEST_SIDE} or more along each axis"
            )
    common = (min(real.shape[0], sim.shape[0]), min(real.shape[1], sim.shape[1]))
    sizes = (real.pixel_size_m, sim.pixel_size_m)
    if None in sizes:
        unknown = " and ".join(footage.name for footage in (real, sim) if footage.pixel_size_m is None)
        notes.append(
            f"The pixel size of {unknown} is not known: measures that depend on it may not be comparable and "
            "are marked ~."
        )
    elif not same_pixel_size(real, sim):
        notes.append(
            f"Pixels differ, {sizes[0]:.6g} m and {sizes[1]:.6g} m, and are not resampled: measures that depend on "
            "their size are marked ~, and spectra are given in cycles per pixel and per km."
        )
    if real.shape == sim.shape or whole:
        if real.shape != sim.shape:
            notes.append(
                "The sides have different numbers of pixels: DP, which counts pairs, is marked ~, and the RMSE of eq "
                "24 includes that difference."
            )
        return _centre(real.shape, real.shape), _centre(sim.shape, sim.shape)
    notes.append(
        f"The compared part is the central {common[0]} rows x {common[1]} columns of {real.shape[0]} x {real.shape[1]} "
        f"and {sim.shape[0]} x {sim.shape[1]}; cloud thresholds are those of the whole frames."
    )
    return _centre(real.shape, common), _centre(sim.shape, common)


def same_pixel_size(real: Footage, sim: Footage) -> bool:
    """Whether both sides are known to have the same pixel size."""
    one, other = real.pixel_size_m, sim.pixel_size_m
    return one is not None and other is not None and abs(one - other) <= _SAME_SIZE * max(one, other)


def _centre(shape: tuple[int, int], part: tuple[int, int]) -> tuple[slice, slice]:
    first = [(size - wanted) // 2 for size, wanted in zip(shape, part, strict=True)]
    return slice(first[0], first[0] + part[0]), slice(first[1], first[1] + part[1])


def same_number(
    sides: tuple[ComparedSide, ComparedSide], measured: tuple[SideMeasures, SideMeasures], notes: list[str]
) -> bool:
    """Whether both sides have the same number of valid pixels; adds a note if only the missing pixels differ."""
    known = [
        side.shape[0] * side.shape[1] - float(np.mean([frame.missing for frame in measured_side.frames]))
        for side, measured_side in zip(sides, measured, strict=True)
    ]
    if abs(known[0] - known[1]) <= _SAME_COUNT * max(known):
        return True
    if sides[0].shape == sides[1].shape:
        notes.append(
            "Missing pixels leave one side fewer pairs of neighbours: DP, which counts them, is marked ~, and the RMSE "
            "of eq 24 includes that difference."
        )
    return False


def pair_frames(real: SideMeasures, sim: SideMeasures) -> tuple[list[int | None], str]:
    """Return the real frame paired with each simulated one (None: the mean of all), and describe the pairing."""
    count = len(sim.frames)
    if len(real.frames) == 1:
        if count == 1:
            return [0], "one real image with one simulated one"
        return [
            0
        ] * count, f"the one real image with each of {count} simulated frames; its change over time is not known"
    if len(real.frames) == count and not (real.left_out or sim.left_out):
        return list(range(count)), f"{count} real frames with {count} simulated ones, one by one"
    return [None] * count, (
        f"each simulated frame ({count}) with the mean of {len(real.frames)} real ones; values with those "
        "of all real ones"
    )


def errors_of_frames(
    real: SideMeasures, sim: SideMeasures, partners: list[int | None], mode: Mode, notes: list[str]
) -> tuple[MorphologyErrors, ...]:
    """Return eq 24 for each simulated frame; if it divides by 0, return none and add the reason to ``notes``."""
    mean = _mean_morphology([frame.measures.morphology for frame in real.frames])
    try:
        return tuple(
            eq_24(
                mean if partner is None else real.frames[partner].measures.morphology, frame.measures.morphology, mode
            )
            for frame, partner in zip(sim.frames, partners, strict=True)
        )
    except ImageError as error:
        notes.append(f"No RMSE of eq 24, {mode}: {error}.")
        return ()


def _mean_morphology(shapes: Sequence[Morphology]) -> Morphology:
    names = Morphology.__dataclass_fields__
    return Morphology(**{name: float(np.mean([getattr(shape, name) for shape in shapes])) for name in names})


def distances_of_frames(
    sides: tuple[ComparedSide, ComparedSide], measured: tuple[SideMeasures, SideMeasures], partners: list[int | None]
) -> tuple[DistributionDistance, ...]:
    """Return the distance between the values of each simulated frame and those of its partner or of all real frames."""
    distances = []
    last: tuple[int | None, NDArray[np.floating]] = (None, measured[0].values)
    for number, partner in zip(measured[1].numbers, partners, strict=True):
        if partner is not None and last[0] != partner:
            last = (partner, sides[0].frame(measured[0].numbers[partner]).values)
        distances.append(distribution_distance(last[1], sides[1].frame(number).values))
    return tuple(distances)


def typical_frame(errors: Sequence[MorphologyErrors], count: int) -> int:
    """Return the simulated frame with the (lower) median RMSE; the first frame if there is no RMSE."""
    if not errors:
        return 0
    order = np.argsort([error.rmse for error in errors], kind="stable")
    return int(order[(count - 1) // 2])
