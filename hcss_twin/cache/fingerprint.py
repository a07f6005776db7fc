"""Whether code is still the same: versions, and the files of packages by size and time."""

from __future__ import annotations

import hashlib
import importlib.util
from pathlib import Path


def top_level(target: str) -> str:
    """Return the top-level package of ``package.module:name``."""
    return target.partition(":")[0].partition(".")[0]


def package_fingerprint(module: str) -> str:
    """Return a hash of the files of the package a module belongs to, by name, size and time of change.

    Parameters
    ----------
    module : str
        For example ``hcss_twin.sea.rough_sea``: its top-level package counts.
    """
    found = importlib.util.find_spec(module.partition(".")[0])
    if found is None:
        return "absent"
    digest = hashlib.sha256()
    if found.submodule_search_locations is None:
        files = [Path(found.origin)] if found.origin else []
    else:
        files = sorted(
            path
            for root in found.submodule_search_locations
            for path in Path(root).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        )
    for path in files:
        about = path.stat()
        digest.update(f"{path}\0{about.st_size}\0{about.st_mtime_ns}\n".encode())
    return digest.hexdigest()
