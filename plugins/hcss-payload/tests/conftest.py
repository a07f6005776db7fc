"""The folder of the tests, for their shared scenes, and a cache of their own."""

import sys
from pathlib import Path

from hcss_author.own_cache import own_cache  # noqa: F401

sys.path.insert(0, str(Path(__file__).parent))
