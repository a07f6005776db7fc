"""Peak memory of this process."""

from __future__ import annotations

import sys
from pathlib import Path


def peak_memory_mb() -> float:
    """Return the largest resident size since the program was started, in units of 1024^2 bytes; not on Windows.

    Linux counts what ``getrusage`` gives from the process that started this one, whose size a child has for a moment:
    the kernel's own high-water mark is that of the program alone.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024
    # imported here: Windows has none, where benchmarks do without
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak) / (1024**2 if sys.platform == "darwin" else 1024)  # bytes there, else kilobytes
