"""hcss_twin: calibrated infrared image sequences of clouds over sea, seen from space.

    >>> import hcss_twin
    >>> scenario = hcss_twin.Scenario.load("stratus")
    >>> cube = hcss_twin.simulate(scenario)          # an xarray.Dataset

Everything named in ``__all__`` is imported when it is first used, so that ``import hcss_twin`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from hcss_twin.version import __version__

if TYPE_CHECKING:
    from hcss_twin.comparison.choice import EvaluationChoice
    from hcss_twin.comparison.evaluate import evaluate
    from hcss_twin.cube.reader import open_cube
    from hcss_twin.errors import (
        CatalogError,
        CubeError,
        HcssError,
        ImageError,
        PosteriorError,
        PropagationError,
        ProviderError,
        ScenarioError,
        SweepError,
    )
    from hcss_twin.export.cube_export import export_cube
    from hcss_twin.propagation.dataset import open_propagation
    from hcss_twin.propagation.propagate import propagate
    from hcss_twin.registry.hookspecs import hookimpl
    from hcss_twin.registry.specs import ProviderSpec
    from hcss_twin.reporting.report import report
    from hcss_twin.scenario.scenario import Scenario
    from hcss_twin.scene.make_plan import make_plan
    from hcss_twin.scene.sensing.sense import sense
    from hcss_twin.scene.simulate import simulate
    from hcss_twin.sweeps.reader import open_sweep
    from hcss_twin.sweeps.run import sweep
    from hcss_twin.uncertainty.fit import fit
    from hcss_twin.uncertainty.fit_dimension import fit_dimension
    from hcss_twin.uncertainty.posterior_file import read_posterior

__all__ = [
    "CatalogError",
    "CubeError",
    "EvaluationChoice",
    "HcssError",
    "ImageError",
    "PosteriorError",
    "PropagationError",
    "ProviderError",
    "ProviderSpec",
    "Scenario",
    "ScenarioError",
    "SweepError",
    "__version__",
    "evaluate",
    "export_cube",
    "fit",
    "fit_dimension",
    "hookimpl",
    "make_plan",
    "open_cube",
    "open_propagation",
    "open_sweep",
    "propagate",
    "read_posterior",
    "report",
    "sense",
    "simulate",
    "sweep",
]


def __getattr__(name: str) -> Any:
    homes = {
        "CatalogError": "errors",
        "CubeError": "errors",
        "EvaluationChoice": "comparison.choice",
        "HcssError": "errors",
        "ImageError": "errors",
        "PosteriorError": "errors",
        "PropagationError": "errors",
        "ProviderError": "errors",
        "ScenarioError": "errors",
        "SweepError": "errors",
        "ProviderSpec": "registry.specs",
        "evaluate": "comparison.evaluate",
        "export_cube": "export.cube_export",
        "fit": "uncertainty.fit",
        "fit_dimension": "uncertainty.fit_dimension",
        "hookimpl": "registry.hookspecs",
        "read_posterior": "uncertainty.posterior_file",
        "Scenario": "scenario.scenario",
        "make_plan": "scene.make_plan",
        "open_cube": "cube.reader",
        "open_propagation": "propagation.dataset",
        "open_sweep": "sweeps.reader",
        "report": "reporting.report",
        "propagate": "propagation.propagate",
        "sense": "scene.sensing.sense",
        "simulate": "scene.simulate",
        "sweep": "sweeps.run",
    }
    if name not in homes:
        raise AttributeError(f"module 'hcss_twin' has no attribute '{name}'")
    return getattr(import_module(f"hcss_twin.{homes[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
