"""Uncertainty of the inputs beside the errors of the models, by band and pixel class."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hcss_twin.sweeps.propagation.joint_sample import SEED

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class ErrorSize:
    """An error as a share of the radiance, and as a brightness temperature in K; NaN where it is unknown."""

    relative: float
    kelvin: float

    @classmethod
    def together(cls, errors: Iterable[ErrorSize]) -> ErrorSize:
        """Return the root of the sum of squares of independent errors; NaN if one is unknown."""
        each = list(errors)
        return cls(math.hypot(*(one.relative for one in each)), math.hypot(*(one.kelvin for one in each)))


@dataclass(frozen=True)
class ModelError:
    """Error of a model against the best reference known, one standard deviation.

    ``sizes`` has an entry for each (band, class) for which it is stated.
    """

    name: str
    sizes: Mapping[tuple[str, str], ErrorSize]


@dataclass(frozen=True)
class BudgetRow:
    """Errors of the mean over the pixels of a class, and their sum, which is unknown if no model states an error."""

    kind: str
    parameters: ErrorSize
    seed: ErrorSize
    models: tuple[ErrorSize, ...]
    total: ErrorSize


def error_budget(drawn: xr.Dataset, band: str, models: Iterable[ModelError] = ()) -> list[BudgetRow]:
    """Return a row for each pixel class of a band.

    ``parameters`` and ``seed`` are the parts of the standard deviation over draws that are due to the uncertain inputs
    and to the realisation of the clouds; NaN if their share of the variance is unknown. An error that a model does not
    state is NaN.
    """
    unknown, rows = ErrorSize(math.nan, math.nan), []
    stated = tuple(models)
    for kind in drawn["class"].values:
        at = drawn.sel({"band": band, "class": kind})
        mean = abs(float(at["radiance_mean"]))
        spread = ErrorSize(
            float(at["radiance_standard_deviation"]) / mean if mean > 0.0 else math.nan,
            float(at["brightness_temperature_standard_deviation"]),
        )
        share = [
            float(at[f"{name}_total"].sel(source=SEED)) if size > 0.0 else 0.0
            for name, size in (("radiance", spread.relative), ("brightness_temperature", spread.kelvin))
        ]
        seed, rest = (
            ErrorSize(spread.relative * math.sqrt(max(one, 0.0)), spread.kelvin * math.sqrt(max(other, 0.0)))
            for one, other in (share, [1.0 - each for each in share])
        )
        each = tuple(model.sizes.get((band, str(kind)), unknown) for model in stated)
        total = ErrorSize.together((spread, *each)) if each else unknown
        rows.append(BudgetRow(str(kind), rest, seed, each, total))
    return rows
