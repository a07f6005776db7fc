"""Uncertainty of radiance due to uncertain cloud parameters and other inputs of a scenario.

    >>> from hcss_uncertainty import propagate
    >>> result = propagate("stratus", draws=200, uncertain={"sea.temperature": "normal:291:0.5"})

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_uncertainty.dataset import open_propagation
    from hcss_uncertainty.errors import PropagationError
    from hcss_uncertainty.propagation import Propagation, propagate

__all__ = ["Propagation", "PropagationError", "open_propagation", "propagate"]


def __getattr__(name: str) -> Any:
    homes = {
        "Propagation": "propagation",
        "PropagationError": "errors",
        "open_propagation": "dataset",
        "propagate": "propagation",
    }
    if name not in homes:
        raise AttributeError(f"module 'hcss_uncertainty' has no attribute '{name}'")
    return getattr(import_module(f"hcss_uncertainty.{homes[name]}"), name)
