"""Sweeps: many scenes from one file, computed locally or on a cluster, with resume.

    >>> from hcss_sweep import sweep
    >>> result = sweep("stratus", "out", over={"view.zenith": [0, 30, 60]})

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_sweep.dataset import open_sweep
    from hcss_sweep.errors import SweepError
    from hcss_sweep.run import SweepResult, sweep

__all__ = ["SweepError", "SweepResult", "open_sweep", "sweep"]


def __getattr__(name: str) -> Any:
    homes = {"SweepError": "errors", "SweepResult": "run", "open_sweep": "dataset", "sweep": "run"}
    if name not in homes:
        raise AttributeError(f"module 'hcss_sweep' has no attribute '{name}'")
    return getattr(import_module(f"hcss_sweep.{homes[name]}"), name)
