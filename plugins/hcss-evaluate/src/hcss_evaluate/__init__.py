"""Simulated beside measured images: similarity metrics (:func:`evaluate`), the realism test, posteriors (:func:`fit`).

    >>> from hcss_evaluate import EvaluationChoice, evaluate
    >>> result = evaluate("measured.nc", "cube.nc", EvaluationChoice(variable="CMI"))

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_evaluate.comparison.comparison import evaluate
    from hcss_evaluate.comparison.footage import EvaluationChoice
    from hcss_evaluate.posterior.fit import fit, fit_dimension

__all__ = ["EvaluationChoice", "evaluate", "fit", "fit_dimension"]


def __getattr__(name: str) -> Any:
    homes = {
        "EvaluationChoice": "comparison.footage",
        "evaluate": "comparison.comparison",
        "fit": "posterior.fit",
        "fit_dimension": "posterior.fit",
    }
    if name not in homes:
        raise AttributeError(f"module 'hcss_evaluate' has no attribute '{name}'")
    return getattr(import_module(f"hcss_evaluate.{homes[name]}"), name)
