"""hcss_twin: calibrated infrared image sequences of clouds over sea, seen from space.

    >>> import hcss_twin
    >>> cube = hcss_twin.simulate("stratus")         # an xarray.Dataset
    >>> cube.hcss.plot()                             # or .brightness_temperature(), .at(lat, lon), .to_ground()

The names in ``__all__`` are imported on first use, so that ``import hcss_twin`` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from hcss_twin.version import __version__

if TYPE_CHECKING:
    from hcss_twin.core.errors import CatalogError, CubeError, HcssError, ImageError, ProviderError, ScenarioError
    from hcss_twin.cube.reader import open_cube
    from hcss_twin.engine.column_spectra import ColumnSpectra, column_spectra
    from hcss_twin.engine.cube_temperature import brightness_temperature
    from hcss_twin.engine.sense import sense
    from hcss_twin.engine.simulate import simulate
    from hcss_twin.engine.twin import Twin
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.providers.registry.specs import ProviderSpec, hookimpl
    from hcss_twin.reports.report import report
    from hcss_twin.scenario.scenario import Scenario


__all__ = [
    "CatalogError",
    "ColumnSpectra",
    "CubeError",
    "HcssError",
    "ImageError",
    "ProviderError",
    "ProviderSpec",
    "Scenario",
    "ScenarioError",
    "Twin",
    "__version__",
    "brightness_temperature",
    "column_spectra",
    "hookimpl",
    "make_plan",
    "open_cube",
    "report",
    "sense",
    "simulate",
]


def __getattr__(name: str) -> Any:
    homes = {
        "CatalogError": "core.errors",
        "ColumnSpectra": "engine.column_spectra",
        "CubeError": "core.errors",
        "HcssError": "core.errors",
        "ImageError": "core.errors",
        "ProviderError": "core.errors",
        "ScenarioError": "core.errors",
        "ProviderSpec": "providers.registry.specs",
        "Twin": "engine.twin",
        "brightness_temperature": "engine.cube_temperature",
        "column_spectra": "engine.column_spectra",
        "hookimpl": "providers.registry.specs",
        "Scenario": "scenario.scenario",
        "make_plan": "plan.make_plan",
        "open_cube": "cube.reader",
        "report": "reports.report",
        "sense": "engine.sense",
        "simulate": "engine.simulate",
    }
    if name not in homes:
        raise AttributeError(f"module 'hcss_twin' has no attribute '{name}'")
    if name in ("open_cube", "sense", "simulate"):  # what returns datasets, which have the accessor ``.hcss``
        import_module("hcss_twin.reports.accessor")
    return getattr(import_module(f"hcss_twin.{homes[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
