"""Uncertainty of the inputs beside the errors of the models, by band and pixel class."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hcss_twin.engine.certificate.certificate import Certificate
from hcss_uncertainty.draw_statistics import ALL
from hcss_uncertainty.joint_sample import SEED

if TYPE_CHECKING:
    import xarray as xr


MODEL_ERRORS = "hcss_error_budget"
"""Attribute of a propagation with the errors that models state, JSON, as :data:`Stated`."""

Stated = Mapping[str, Mapping[str, Mapping[str, Any]]]
"""Errors by class (``clear``, or the name of a cloud layer) and band.

``contributions`` is a list of mappings with ``name``, and ``relative`` and ``kelvin``, which are None where unknown;
``unknown`` lists what is unknown in all or part of the band.
"""


@dataclass(frozen=True)
class ErrorSize:
    """An error as a share of the radiance, and as a brightness temperature in K; NaN where it is unknown.

    ``is_limit``: the estimate of its square is not above 0, and both values are those of one standard error above 0.
    """

    relative: float
    kelvin: float
    is_limit: bool = False


UNKNOWN = ErrorSize(math.nan, math.nan)


@dataclass(frozen=True)
class BudgetRow:
    """Errors of the mean over the pixels of a class.

    Attributes
    ----------
    parameters, seed : ErrorSize
        Parts of the standard deviation over draws due to uncertain inputs and to the realisation of the clouds.
    models : mapping of str to ErrorSize
        By name of the contribution; empty if no model states anything for the class.
    total : ErrorSize
        Root of the sum of squares of what is known; unknown if nothing is known of models.
    is_least : bool
        Whether a model's contribution is unknown in all or part of the band, so that the total is a lower limit.
    """

    kind: str
    parameters: ErrorSize
    seed: ErrorSize
    models: Mapping[str, ErrorSize]
    total: ErrorSize
    is_least: bool


def joint_budget(drawn: xr.Dataset, band: str, stated: Stated) -> list[BudgetRow]:
    """Return a row for each pixel class of a band; ``stated`` may be empty.

    The classes of one cloud layer have that layer's model errors. Those of two layers and of all pixels together are
    not stated, as they mix columns.
    """
    rows = []
    for name in drawn["class"].values:
        kind = str(name)
        at = drawn.sel({"band": band, "class": kind})
        mean = abs(float(at["radiance_mean"]))
        relative = float(at["radiance_standard_deviation"]) / mean if mean > 0.0 else math.nan
        kelvin = float(at["brightness_temperature_standard_deviation"])
        by_seed = at.sel(source=SEED)
        sizes = {"radiance": relative, "brightness_temperature": kelvin}
        parts = [
            _parts(size, *(float(by_seed[f"{name}_total{end}"]) for end in ("", "_error")))
            for name, size in sizes.items()
        ]
        inputs, seed = (
            ErrorSize(of_radiance, of_kelvin, is_limit)
            for (of_radiance, _), (of_kelvin, is_limit) in zip(*parts, strict=True)
        )
        cell = _of_class(kind, band, stated)
        models = _model_errors(cell)
        known = [model for model in models.values() if math.isfinite(model.kelvin)]
        total = UNKNOWN
        if known and math.isfinite(kelvin):
            total = ErrorSize(
                math.hypot(relative, *(error.relative for error in known)),
                math.hypot(kelvin, *(e.kelvin for e in known)),
            )
        rows.append(BudgetRow(kind, inputs, seed, models, total, len(known) < len(models) or bool(cell.get("unknown"))))
    return rows


def _parts(spread: float, seed_share: float, error: float) -> list[tuple[float, bool]]:
    """Divide a standard deviation into the parts of inputs and seed, whose squares add up to its own.

    A part whose estimated share of the variance is not above 0 is that of the share's standard error, and marked.
    """
    if spread == 0.0 or math.isnan(seed_share):
        return [(0.0 if spread == 0.0 else math.nan, False)] * 2
    shares = [min(max(share, 0.0), 1.0) for share in (1.0 - seed_share, seed_share)]  # estimates may be beyond
    limits = [share == 0.0 and error > 0.0 for share in shares]
    return [(spread * math.sqrt(error if at else share), at) for share, at in zip(shares, limits, strict=True)]


def _of_class(kind: str, band: str, stated: Stated) -> Mapping[str, Any]:
    clouds = [name for name in stated if name != Certificate.CLEAR]
    class_name = kind if kind == Certificate.CLEAR else clouds[0] if kind != ALL and len(clouds) == 1 else None
    return {} if class_name is None else stated.get(class_name, {}).get(band, {})


def _model_errors(cell: Mapping[str, Any]) -> dict[str, ErrorSize]:
    return {
        str(contribution["name"]): UNKNOWN
        if contribution["relative"] is None or contribution["kelvin"] is None
        else ErrorSize(float(contribution["relative"]), float(contribution["kelvin"]))
        for contribution in cell.get("contributions", ())
    }
