"""Which packages of plugins/ are installed, for tests that need one.

A source folder on the path makes its modules importable, but only an installed package has entry points.
"""

from importlib.metadata import PackageNotFoundError, distribution

import pytest


def has(name: str) -> bool:
    """Whether a package is installed."""
    try:
        distribution(name)
    except PackageNotFoundError:
        return False
    return True


def need(*names: str) -> None:
    """Skip a test if one of some packages is not installed."""
    for name in names:
        if not has(name):
            pytest.skip(f"needs {name}")
