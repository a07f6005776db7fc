"""Versions of what has a share in the numbers."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata

LIBRARIES = ("numpy", "numba", "scipy", "xarray", "netCDF4", "pvlib", "pydantic", "pluggy")


def versions() -> dict[str, str]:
    """Return the versions of this package, of Python and of the libraries that have a share in the numbers."""
    found = {"hcss-twin": _loaded("hcss-twin"), "python": platform.python_version()}
    found.update((name, _loaded(name)) for name in LIBRARIES)
    return found


def installed_version(distribution: str) -> str:
    """Return the version of a distribution, or ``not installed``."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "not installed"


@cache
def _loaded(distribution: str) -> str:
    """Version of what this process has loaded, whatever is installed later; reading it takes a millisecond."""
    return installed_version(distribution)
