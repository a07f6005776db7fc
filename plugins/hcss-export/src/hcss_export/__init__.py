"""Cubes of hcss_twin in the formats of other programs: FITS, ENVI, GeoTIFF and 16-bit PNG, one module per format.

    >>> from hcss_export import export_cube
    >>> export_cube("cube.nc", "geotiff", "frames.tif", bands=["mwir"]).files

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_export.cube_export import Exported, export_cube

__all__ = ["Exported", "export_cube"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'hcss_export' has no attribute '{name}'")
    return getattr(import_module("hcss_export.cube_export"), name)
