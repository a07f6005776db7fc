"""Whether code is still the same: versions, and the files of packages by size and time."""

from __future__ import annotations

import hashlib
import importlib.util
import os
from contextlib import suppress


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
        files = [found.origin] if found.origin else []
    else:
        files = sorted(
            os.path.join(folder, name)
            for root in found.submodule_search_locations
            for folder, _, names in os.walk(root)
            if os.path.basename(folder) != "__pycache__"
            for name in names
        )
    for path in files:
        with suppress(FileNotFoundError):  # a link that leads nowhere
            about = os.stat(path)
            digest.update(f"{path}\0{about.st_size}\0{about.st_mtime_ns}\n".encode())
    return digest.hexdigest()
