"""Does one run of several sensors cost at most what its sensors cost alone, less the sky that they share?

    python benchmarks/one_sky.py             # 1 + 8 sensors, three minutes of a processor
    python benchmarks/one_sky.py --low 2     # one minute

A geostationary grid of 2 km pixels and low sensors of 375 m in other directions see one sky. Seconds are those of a
processor, with empty caches in all cases and kernels that are compiled already. The sky of a sensor is a run that
writes the clouds alone, without radiance: what each sensor alone makes again. One run may make it once: the largest of
these skies, which is left out of what the other sensors may cost. Needs hcss-sweep.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from typing import Any

SKY: dict[str, Any] = {
    "time": "2024-07-20T12:40:00+09:00",
    "place": {"latitude": 30.0, "longitude": 140.0},
    "seed": 3,
    "clouds": {"type": "cumulus", "coverage": 0.3, "generator": "fractal"},
    "accuracy": 1e-2,
    "bands": ["lwir-10.8"],
    "frames": {"count": 1},
}
GEOSTATIONARY: dict[str, Any] = {
    "name": "geostationary",
    "platform": {"longitude": 140.7},
    "image": {"rows": 12, "columns": 12, "pixel_size": 2000.0},
}

_CHILD = """
import json, sys, time
from hcss_sweep import sweep
began = time.process_time()
result = sweep(json.loads(sys.argv[1]), sys.argv[2])
assert not result.failed, result.failed
print(json.dumps([time.process_time() - began, max(point.certified or 0.0 for point in result.points)]))
"""

CLOUDS_ALONE: dict[str, Any] = {"output": {"variables": ["cloud_top_altitude", "cloud_mask"]}}


def low(number: int) -> dict[str, Any]:
    """Keys of a sensor in low orbit, each with a direction of its own."""
    return {
        "name": f"low {number}",
        "platform": {"altitude": 829e3},
        "view": {"zenith": 10.0 + 5.0 * number, "azimuth": 45.0 * number},
        "image": {"rows": 48, "columns": 48, "pixel_size": 375.0},
    }


def cost(sensors: Sequence[dict[str, Any]], **keys_of_all: Any) -> tuple[float, float]:
    """Return the processor seconds of a run with empty caches, and its largest error as a share of the accuracy."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "HCSS_CACHE_DIR": f"{folder}/cache"}
        keys = json.dumps({**SKY, **keys_of_all, "sensors": list(sensors)})
        command = [sys.executable, "-c", _CHILD, keys, f"{folder}/sky"]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        seconds, share = json.loads(done.stdout.splitlines()[-1])
        return seconds, share


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--low", type=int, default=8, choices=range(1, 9), help="sensors in low orbit")
    sensors = [GEOSTATIONARY, *map(low, range(parser.parse_args().low))]
    together, share = cost(sensors)
    print(f"together: {together:.1f} s, largest error {share:.2g} of the accuracy", flush=True)
    alone, skies = [], []
    for sensor in sensors:
        alone.append(cost([sensor])[0])
        skies.append(cost([sensor], **CLOUDS_ALONE)[0])
        print(f"{sensor['name']} alone: {alone[-1]:.1f} s, of which the sky {skies[-1]:.1f} s", flush=True)
    shared = sum(skies) - max(skies)
    allowed = sum(alone) - shared
    print(f"together {together:.1f} s; allowed {allowed:.1f} s: {sum(alone):.1f} s alone less {shared:.1f} s of sky")
    print(f"together / sum of all alone: {together / sum(alone):.2f}; / allowed: {together / allowed:.2f}")


if __name__ == "__main__":
    main()
