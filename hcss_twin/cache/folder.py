"""Where results are kept between runs."""

from __future__ import annotations

import os
from pathlib import Path


def cache_root() -> Path | None:
    """Folder of everything that is kept: HCSS_CACHE_DIR, or hcss-twin in the user's cache folder; None without a home.

    That is XDG_CACHE_HOME or ~/.cache, and LOCALAPPDATA on Windows.
    """
    own = os.environ.get("HCSS_CACHE_DIR")
    if own:
        return Path(own)
    usual = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME")
    try:
        root = Path(usual) if usual else Path.home() / ".cache"
    except RuntimeError:  # a user of the system without a folder
        return None
    return root / "hcss-twin"
