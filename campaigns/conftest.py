"""Samples of campaigns share the fixtures and helpers of the other tests."""

import sys
from pathlib import Path

from hcss_author.own_cache import fresh_results, own_cache  # noqa: F401

sys.path.append(str(Path(__file__).parents[1] / "tests"))
