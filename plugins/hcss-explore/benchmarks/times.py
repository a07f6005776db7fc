"""Processor time of what the page asks, for the README: ``python plugins/hcss-explore/benchmarks/times.py [SCENARIO]``.

With an empty cache of results (``HCSS_CACHE_DIR``) the first picture is a cold one, as is each
change that needs tables.
"""

import os
import sys
import time
from collections.abc import Callable

import numpy as np
from hcss_explore.explorer import Explorer

CHANGES = {
    "frame": ({}, 1),
    "seed": ({"seed": "21"}, 0),
    "cover": ({"clouds.coverage": "0.37"}, 0),
    "hour of the day (sun)": ({"time": "2024-04-20T09:45:00+10:00"}, 0),
    "zenith angle of the view": ({"view.zenith": "33"}, 0),
    "sea temperature": ({"sea.temperature": "288.3"}, 0),
    "cloud type": ({"clouds.type": "cumulus"}, 0),
    "one band alone": ({"bands": ["lwir-10.8"]}, 0),
}


def measure(label: str, work: Callable[[], object]) -> None:
    """Print processor and wall time of a call."""
    processor, wall = time.process_time(), time.perf_counter()
    work()
    print(f"{label:<42}{time.process_time() - processor:8.3f} s{time.perf_counter() - wall:10.3f} s", flush=True)


def main() -> None:
    """Measure each change twice: made for the first time, and with its tables in the cache of another process."""
    name = sys.argv[1] if len(sys.argv) > 1 else "stratus"
    start = os.times()
    print(f"{name:<42}{'processor':>10}{'wall':>12}")
    print(f"{'until the imports are done':<42}{start.user + start.system:8.3f} s")
    found: list[Explorer] = []
    measure("explorer", lambda: found.append(Explorer(name)))
    explorer = found[0]
    measure("first picture", lambda: explorer.picture({}, 0, False))
    thickness = explorer.picture({}, 0, False).thickness
    places = [tuple(map(int, place)) for place in np.argwhere(thickness > 0.0)[[0, -1]]]
    for label, place in zip(("first spectrum of a cloudy pixel, 8-14 um", "spectrum of another"), places, strict=True):
        measure(label, lambda place=place: explorer.pixel({}, 0, *place, 2))  # type: ignore[misc]
    for label, (given, number) in CHANGES.items():
        measure(label, lambda given=given, number=number: explorer.picture(given, number, False))  # type: ignore[misc]
    measure("another frame again", lambda: explorer.picture({}, 2, False))


if __name__ == "__main__":
    main()
