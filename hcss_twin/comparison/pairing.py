"""Which real frame a simulated one is compared with, and the errors of all pairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.comparison.side import Measured, Prepared
from hcss_twin.errors import ImageError
from hcss_twin.evaluation.definitions import Mode, eq_24
from hcss_twin.evaluation.distributions import DistributionDistance, distribution_distance
from hcss_twin.evaluation.morphology import Morphology, MorphologyErrors


def pair_frames(real: Measured, sim: Measured) -> tuple[list[int | None], str]:
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


def errors_of_frames(
    real: Measured, sim: Measured, partners: list[int | None], mode: Mode, notes: list[str]
) -> tuple[MorphologyErrors, ...]:
    """Return eq 24 for each simulated frame; none, and why in ``notes``, where it divides by 0."""
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


def distances_of_frames(
    sides: tuple[Prepared, Prepared], measured: tuple[Measured, Measured], partners: list[int | None]
) -> tuple[DistributionDistance, ...]:
    """Return the distance of each simulated frame's values from those of its partner, or of all real frames."""
    found = []
    last: tuple[int | None, NDArray[np.floating]] = (None, measured[0].kept)
    for number, partner in zip(measured[1].numbers, partners, strict=True):
        if partner is not None and last[0] != partner:
            last = (partner, sides[0].frame(measured[0].numbers[partner]).values)
        found.append(distribution_distance(last[1], sides[1].frame(number).values))
    return tuple(found)


def typical_frame(errors: Sequence[MorphologyErrors], count: int) -> int:
    """Return the simulated frame with the median RMSE, the lower of two; the first where there is none."""
    if not errors:
        return 0
    order = np.argsort([each.rmse for each in errors], kind="stable")
    return int(order[(count - 1) // 2])
