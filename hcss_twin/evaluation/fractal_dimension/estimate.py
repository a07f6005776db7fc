"""What an estimator of the fractal dimension returns."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DimensionEstimate:
    """A fractal dimension and how far to trust it.

    Attributes
    ----------
    dimension : float
        Fractal dimension: 2 to 3 of a grey-level surface, 1 to 2 of a boundary.
    standard_error : float
        Root mean square error (bias and spread) of the estimator on surfaces of this dimension and size, as
        measured in docs/fractal-dimension.md; NaN where it was not measured.
    method : str
        Name of the estimator and its settings.
    """

    dimension: float
    standard_error: float
    method: str
