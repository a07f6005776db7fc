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
        Spread of the estimator on surfaces of known dimension and this size, as documented; NaN where
        it was not measured.
    method : str
        Name of the estimator and its settings.
    """

    dimension: float
    standard_error: float
    method: str
