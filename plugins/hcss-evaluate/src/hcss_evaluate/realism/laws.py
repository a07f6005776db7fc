"""Laws of clouds: statistics of masks and fields beside what is published of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_evaluate.realism.clouds import (
    SMALLEST,
    SPECK,
    Clouds,
    Mask,
    edge_exponent,
    ensemble_dimension,
    individual_dimension,
    organisation,
    size_exponent,
)
from hcss_evaluate.realism.intermittency import codimension, gradient_size
from hcss_twin.providers import Array

_CLOSED = 0.9
"""Cover of closed cloud."""


@dataclass(frozen=True)
class Published:
    """Range of a statistic in the literature, and where it is from."""

    low: float
    high: float
    source: str


PUBLISHED: dict[str, Published] = {
    "exponent of areas": Published(
        0.35, 1.0, "0.35: LES of cumulus, Neggers et al. 2003; 0.87: Wood and Field 2011; 1: DeWitt et al. 2024"
    ),
    "exponent of perimeters": Published(1.20, 1.32, "1.26 +- 0.06, DeWitt et al. 2024"),
    "dimension of a cloud": Published(1.25, 1.41, "4/3, Siebesma and Jonker 2000; 1.35, Lovejoy 1982; +- 0.08"),
    "dimension of the field": Published(1.59, 1.75, "5/3, Rees et al. 2024; +- 0.08"),
    "C1 of closed cloud": Published(0.06, 0.12, "0.08 and 0.10 in stratocumulus, Marshak et al. 1997; +- 0.02"),
}
"""Ranges of statistics of :func:`cloud_laws`; the others have none."""


@dataclass(frozen=True)
class Law:
    """A statistic of both sides; None if there are too few clouds for it.

    ``beyond`` names the sides that are outside of the published range, if there is one.
    """

    name: str
    real: float | None
    simulated: float | None
    published: Published | None
    beyond: tuple[str, ...]

    @classmethod
    def of(cls, name: str, real: float | None, simulated: float | None) -> Law:
        """Compare both sides with what is published."""
        known = PUBLISHED.get(name)
        sides = (("real", real), ("simulated", simulated))
        beyond = tuple(
            side
            for side, value in sides
            if known is not None and value is not None and not known.low <= value <= known.high
        )
        return cls(name, real, simulated, known, beyond)

    @property
    def cells(self) -> list[str]:
        """Name, both sides with a mark (!) beyond the published range, and that range, for tables."""
        values = []
        for side, value in (("real", self.real), ("simulated", self.simulated)):
            values.append("-" if value is None else f"{value:.3f}{' !' if side in self.beyond else ''}")
        known = self.published
        return [self.name, *values, "" if known is None else f"{known.low:g} to {known.high:g}"]


def cloud_laws(masks: Sequence[Mask], contrasts: Sequence[Array]) -> dict[str, float | None]:
    """Return statistics of clouds, all frames pooled, by name.

    Parameters
    ----------
    masks : sequence of ndarray of bool (rows, columns)
        Where there is cloud.
    contrasts : sequence of ndarray (rows, columns)
        What clouds add to clear sky, in any unit: optical thickness, kelvin below clear sky. Missing values are NaN;
        frames with any are left out of the intermittency.
    """
    frames = [Clouds.of(mask) for mask in masks]
    area, perimeter = (np.concatenate([getattr(clouds, name) for clouds in frames]) for name in ("area", "perimeter"))
    truncated = np.concatenate([clouds.truncated for clouds in frames])
    # A square of the smallest area has this outline.
    shortest = 4.0 * math.sqrt(SMALLEST)
    cover = float(sum(np.count_nonzero(mask) for mask in masks) / sum(mask.size for mask in masks))
    intermittency = codimension([gradient_size(field) for field in contrasts if np.isfinite(field).all()])
    return {
        "cover": cover,
        "clouds": float(len(area)),
        f"share of clouds of 1 to {SPECK} pixels": float(np.mean(area <= SPECK)) if len(area) else None,
        "exponent of areas": size_exponent(area, truncated, SMALLEST),
        "exponent of perimeters": size_exponent(perimeter, truncated, shortest, 2.0),
        "dimension of a cloud": individual_dimension(masks),
        "dimension of the field": ensemble_dimension(masks),
        # What is published is of closed cloud: nothing changes in clear sky, so that broken cloud has far more.
        "C1 of closed cloud": intermittency if cover >= _CLOSED else None,
        "C1 of broken cloud": None if cover >= _CLOSED else intermittency,
        "exponent of edges": edge_exponent(masks, contrasts),
        "organisation Iorg": organisation(frames),
    }
