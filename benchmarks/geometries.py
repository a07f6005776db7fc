"""What do plan and tables of a scene cost in any geometry, beside another version in one run?

    python benchmarks/geometries.py                                       # a quarter of an hour
    python benchmarks/geometries.py --scenes stratus --number 5           # a minute
    python benchmarks/geometries.py --beside ../old --with ../old/.venv/bin/python
    python benchmarks/geometries.py --shipped --number 5 --beside ../old     # of shipped scenes, with all effects
    python benchmarks/geometries.py --streaming --number 5 --beside ../old   # a frame of 256 x 256 of shipped scenes

One lucky geometry proves nothing: the same clouds cost between one and ten times as much under other suns, because
sunlight needs more streams there. Seconds are those of a processor, with empty caches and kernels that are compiled
already. Both versions compute each geometry in turn, so that they meet the machine in the same state.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

STRATUS = {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"}
CIRRUS = {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field"}
SCENES: dict[str, dict[str, Any]] = {
    "stratus": {},
    "cirrus": {"clouds": CIRRUS},
    "stratus, 1e-1": {"accuracy": 1e-1},
    "stratus, 1e-2": {"accuracy": 1e-2},
    "stratus, 1e-4": {"accuracy": 1e-4},
    "night": {"time": "2024-06-20T14:00:00Z", "bands": [[8.0, 14.0]]},
    "two layers": {"clouds": {"layers": [STRATUS, CIRRUS]}},
    "250 km": {"image": {"rows": 250, "columns": 250, "pixel_size": 1000.0}, "platform": {"altitude": 8e5}},
}
"""Scenes, and what differs in them from ``COMMON``, a copy of the shipped stratus that later versions do not change."""

COMMON: dict[str, Any] = {
    "place": {"latitude": 30.0, "longitude": 140.0},
    "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
    "bands": [[2.7, 3.0], [3.0, 5.0], [8.0, 14.0]],
    "clouds": STRATUS,
    "accuracy": 1e-3,
    "output": {"certificate": 0},
    "sea": {"wind_from": 200.0, "temperature": 291.4, "wind_speed": 10.0, "waves": "off"},
    "slant": {"shadows": "off", "parallax": "off"},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
}
SHIPPED = "shipped "
SHIPPED_SCENES = ("stratus", "cumulus", "cirrus")
"""Measured with all effects that they have by themselves."""

FRAMES = 9
SIDE = 256
"""Pixels along each side of streamed images: enough that a frame costs mostly its points."""
SEED = 43


def scenario(scene: str, number: int) -> dict[str, Any]:
    """Keys of a scene in one of the random geometries: times of a day in June, and views."""
    if scene.startswith(SHIPPED):
        return {"shipped": scene.removeprefix(SHIPPED), **geometry(number, 1.0)}
    return {**COMMON, **geometry(number, 0.5 if "platform" in SCENES[scene] else 1.0), **SCENES[scene]}


def geometry(number: int, share: float) -> dict[str, Any]:
    """Time and view, whose zenith is a share of its range."""
    hours, zenith, azimuth = np.random.default_rng([SEED, number]).uniform((22.5, 0.0, 0.0), (30.0, 60.0, 360.0))
    minutes = int(hours * 60.0)
    day, minutes = 20 + minutes // 1440, minutes % 1440
    return {
        "time": f"2024-06-{day}T{minutes // 60:02d}:{minutes % 60:02d}:00Z",
        "view": {"zenith": share * float(zenith), "azimuth": float(azimuth)},
    }


def of_a_frame(scene: Any) -> float:
    """Median seconds of a frame of a scene; its tables are compiled before."""
    from hcss_twin import make_plan
    from hcss_twin.engine.compile import tables_of
    from hcss_twin.engine.stream import stream

    plan = make_plan(scene)
    each, seconds = stream(plan, tables_of(plan)), []
    next(each)  # compiles kernels
    for _ in range(1, FRAMES):
        start = time.process_time()
        next(each)
        seconds.append(time.process_time() - start)
    return statistics.median(seconds)


def serve() -> None:
    """Answer each line of keys with the seconds of its plan and its tables, or of a frame; nan if it is refused."""
    from hcss_twin import Scenario, make_plan
    from hcss_twin.core.errors import HcssError
    from hcss_twin.engine.compile import compile_tables
    from hcss_twin.scenario import section_types

    for line in sys.stdin:
        keys = json.loads(line)
        shipped, streams = keys.pop("shipped", ""), keys.pop("streams", False)
        if shipped:
            dotted = {"time": keys["time"], **{f"view.{name}": value for name, value in keys["view"].items()}}
            small = {"image.rows": SIDE, "image.columns": SIDE} if streams else {}
            scene = Scenario.load(shipped, {**dotted, **small, "frames.count": FRAMES, "output.certificate": 0})
        else:
            if not hasattr(section_types, "Switch"):  # versions before have these effects off
                del keys["slant"], keys["sea"]["waves"]
            scene = Scenario.from_dict(keys)
        start = time.process_time()
        try:
            if streams:
                seconds = of_a_frame(scene)
            else:
                compile_tables(make_plan(scene, keeps_results=False))
                seconds = time.process_time() - start
        except HcssError as error:
            print(error, file=sys.stderr)
            seconds = float("nan")
        print(seconds, flush=True)


class Version:
    """A process of one version."""

    def __init__(self, python: str, checkout: Path | None) -> None:
        environment = os.environ | {"HCSS_CACHE_DIR": tempfile.mkdtemp()}
        if checkout is not None:
            environment["PYTHONPATH"] = str(checkout)
        self._process = subprocess.Popen(
            [python, __file__, "--serve"], env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def seconds(self, keys: dict[str, Any]) -> float:
        """Seconds of a processor of one scene."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(keys) + "\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=[*SCENES, "cumulus"], help="default: all")
    parser.add_argument("--shipped", action="store_true", help="shipped scenes, with the effects they have")
    parser.add_argument("--streaming", action="store_true", help="seconds of a frame after plan and tables")
    parser.add_argument("--number", type=int, default=20, help="of geometries")
    parser.add_argument("--beside", type=Path, help="checkout of another version")
    parser.add_argument("--with", dest="python", default=sys.executable, help="the Python that has what it needs")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    are_shipped = options.shipped or options.streaming
    known = SHIPPED_SCENES if are_shipped else tuple(SCENES)
    if unknown := sorted(set(options.scenes or ()).difference(known)):
        parser.error(f"--scenes: {', '.join(unknown)} given, allowed here: {', '.join(known)}")
    if options.serve:
        serve()
        return
    versions = {"here": Version(sys.executable, Path(__file__).parents[1])}
    if options.beside is not None:
        versions["beside"] = Version(options.python, options.beside.resolve())
    print(f"{'scene':16}{'version':10}{'median':>8}{'90 %':>8}{'largest':>9}  s of a processor")
    for name in options.scenes or known:
        scene = SHIPPED + name if are_shipped else name
        found: dict[str, list[float]] = {name: [] for name in versions}
        for number in range(-1, options.number):  # the first compiles kernels
            for name, version in versions.items():
                seconds = version.seconds({**scenario(scene, number + 1), "streams": options.streaming})
                if number >= 0:
                    found[name].append(seconds)
        done = np.all(np.isfinite(list(found.values())), axis=0)
        if not np.any(done):
            print(f"{scene:16}refused in all geometries")
            continue
        for name, values in found.items():
            median, most, largest = np.quantile(np.array(values)[done], (0.5, 0.9, 1.0))
            print(f"{scene:16}{name:10}{median:8.3g}{most:8.3g}{largest:9.3g}", flush=True)
        if len(found) > 1:
            ratio = (np.array(found["here"]) / np.array(found["beside"]))[done]
            low, median, high = np.quantile(ratio, (0.0, 0.5, 1.0))
            print(f"{scene:16}{'ratio':10}{median:8.2f}   from {low:.2f} to {high:.2f}", flush=True)


if __name__ == "__main__":
    main()
