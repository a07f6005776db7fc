"""The folder of the tests, for their shared scenes."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
