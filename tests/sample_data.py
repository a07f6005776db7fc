"""Real files that are not part of the project: satellite images and MODTRAN output.

The environment variable HCSS_SAMPLE_DATA names a folder with the sub-folders ``images``, ``modtran`` and ``seviri``.
Tests that need such a file are skipped where it is absent.
"""

import os
from pathlib import Path

import pytest


def sample_file(pattern: str) -> Path:
    """Return the first file that a pattern such as ``images/*.jpg`` matches, or skip the test."""
    folder = os.environ.get("HCSS_SAMPLE_DATA")
    files = sorted(Path(folder).glob(pattern)) if folder else []
    if not files:
        pytest.skip(f"HCSS_SAMPLE_DATA names no folder with {pattern}")
    return files[0]
