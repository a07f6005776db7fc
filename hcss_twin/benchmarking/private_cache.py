"""A cache of its own, so that nothing kept earlier is used and nothing is left to later runs."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def private_cache(folder: Path) -> Iterator[None]:
    """Keep tables and optics in a folder while the block runs, without a limit that would keep none."""
    wanted = {"HCSS_CACHE_DIR": str(folder), "HCSS_CACHE_MB": "10000"}
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
