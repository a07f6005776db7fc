"""Clouds in images: import, measures, match, posterior, and comparison of simulated with measured images.

    >>> from hcss_evaluate import EvaluationChoice, evaluate, match, read_target
    >>> found = match(read_target(Path("clouds.png"), ImageChoice(pixel_size_m=1000.0)))   # parameters of the generator
    >>> result = evaluate("measured.nc", "cube.nc", EvaluationChoice(variable="CMI"))      # similarity metrics

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_evaluate.comparison.comparison import evaluate
    from hcss_evaluate.comparison.footage import EvaluationChoice
    from hcss_evaluate.database.cloud_import import ImportOptions, import_image
    from hcss_evaluate.errors import PosteriorError
    from hcss_evaluate.matching.dimension_range import match_dimension
    from hcss_evaluate.matching.match import match
    from hcss_evaluate.matching.target import ImageChoice, read_target
    from hcss_evaluate.posterior.fit import fit, fit_dimension
    from hcss_evaluate.posterior.posterior_file import read_posterior

__all__ = [
    "EvaluationChoice",
    "ImageChoice",
    "ImportOptions",
    "PosteriorError",
    "evaluate",
    "fit",
    "fit_dimension",
    "import_image",
    "match",
    "match_dimension",
    "read_posterior",
    "read_target",
]


def __getattr__(name: str) -> Any:
    homes = {
        "EvaluationChoice": "comparison.footage",
        "ImageChoice": "matching.target",
        "ImportOptions": "database.cloud_import",
        "PosteriorError": "errors",
        "evaluate": "comparison.comparison",
        "fit": "posterior.fit",
        "fit_dimension": "posterior.fit",
        "import_image": "database.cloud_import",
        "match": "matching.match",
        "match_dimension": "matching.dimension_range",
        "read_posterior": "posterior.posterior_file",
        "read_target": "matching.target",
    }
    if name not in homes:
        raise AttributeError(f"module 'hcss_evaluate' has no attribute '{name}'")
    return getattr(import_module(f"hcss_evaluate.{homes[name]}"), name)
