"""EV, Den, DP, FD and RMSE of the HCSS paper, as printed and in a corrected form.

Common factors cancel in eq 24: printing ten times Den and dividing DP by W - 1 do not change the errors or the RMSE.
Only the denominator of eq 24 matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hcss_evaluate.measures.morphology import Morphology, MorphologyErrors, morphology_errors

GREY_LEVELS = 256

PRINTED_DENSITY = 10.0
"""Ratio of the paper's Den (7.3 to 8.5 in Tables VIII and IX) to eq 22, which is at most 1."""

Mode = Literal["as-printed", "corrected"]
MODES: tuple[Mode, ...] = ("as-printed", "corrected")


@dataclass(frozen=True)
class Definition:
    """One metric in both definitions.

    Attributes
    ----------
    name : str
        EV, Den, DP, FD or RMSE.
    as_printed, corrected : str
        Description of each definition.
    """

    name: str
    as_printed: str
    corrected: str


DEFINITIONS = (
    Definition(
        "EV",
        "entropy of the 2-D histogram of horizontal neighbours in bits (eq 21); the paper's printed values are about "
        "half of what eq 21 gives for such clouds",
        "the same",
    ),
    Definition("Den", "ten times eq 22: the printed values exceed its bound of 1", "eq 22: mean of 1 / (1 + |g - g'|)"),
    Definition(
        "DP",
        "pairs of equal neighbours over W - 1 = 255 (eq 23)",
        "over W = 256, the entries of the diagonal; either grows with the number of pixels",
    ),
    Definition(
        "FD",
        "eq 6 needs interpretation (wrong limit direction, no set named): boxes that fill the body of the cloud, "
        "the only count that reproduces the printed values",
        "the same; dimensions of surface and outline are separate rows",
    ),
    Definition(
        "RMSE",
        "eq 24: errors relative to the simulated values",
        "errors relative to the real values, which do not depend on the simulation",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class FourMeasures:
    """EV, Den, DP and FD in one of the definitions."""

    entropy: float
    density: float
    diagonal_peak: float
    fractal_dimension: float


def four_measures(measured: Morphology, mode: Mode) -> FourMeasures:
    """Return EV, Den, DP and FD of an image in the definition of ``mode``."""
    if mode == "as-printed":
        density, peak = PRINTED_DENSITY * measured.density, measured.diagonal_peak
    else:
        density, peak = measured.density, measured.diagonal_peak * (GREY_LEVELS - 1) / GREY_LEVELS
    return FourMeasures(measured.entropy, density, peak, measured.fractal_dimension)


def eq_24(real: Morphology, simulated: Morphology, mode: Mode) -> MorphologyErrors:
    """Compare two images by eq 24, relative to the simulated (as printed) or to the real values (corrected).

    Raises ImageError if a divisor is 0.
    """
    # |a - b| / b: exchanging the images exchanges the denominators.
    return morphology_errors(real, simulated) if mode == "as-printed" else morphology_errors(simulated, real)
