"""What scenes load and compute: nothing that they do not need. The table of the page "Fast and accurate".

    python benchmarks/needed.py           # print: about two minutes of processor time
    python benchmarks/needed.py --write   # and rewrite the table of the page

Each line is a process of its own with an empty cache of results; kernels are compiled by the
process before it, which counts.
Counted are imported modules of the package, solved layers, those solved for sunlight, columns times wavenumbers asked
of the radiance model, and calls of the clouds' generator.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

PAGE = Path(__file__).parents[1] / "docs" / "development" / "accuracy-and-speed.md"
SMALL = {"image.rows": 64, "image.columns": 64, "frames.count": 1, "output.certificate": 0}
NIGHT = {"time": "2024-04-20T00:30:00+10:00"}
MASK = {"output.variables": ["cloud_mask"]}
SCENES: dict[str, dict[str, Any] | None] = {
    "`hcss --help`": None,
    "mask alone": MASK,
    "clear sky, night": NIGHT | {"clouds.coverage": 0.0},
    "clear sky, day": {"clouds.coverage": 0.0},
    "stratus, night": NIGHT,
    "stratus, day": {},
    "overcast, day": {"clouds.coverage": 1.0},
}
"""Changes to the shipped scene ``stratus`` in 64 x 64 pixels and one frame, without certificate."""

OF_SUNLIGHT = ("solve_sun", "solve_sunlit_layers", "transmit_beams")


def counts_of(changes: dict[str, Any]) -> dict[str, int]:
    """Compute a scene in this process, and return counts."""
    import counts

    from hcss_twin import Scenario
    from hcss_twin.engine.simulate import run
    from hcss_twin.models.radiance.physical import slab_operators
    from hcss_twin.plan.make_plan import make_plan

    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="hcss-needed-") as folder, counts.counting(found):
        solvers = [getattr(slab_operators, name) for name in OF_SUNLIGHT]
        for name, solver in zip(OF_SUNLIGHT, solvers, strict=True):
            setattr(slab_operators, name, _counted(solver, found))
        try:
            run(make_plan(Scenario.load("stratus", SMALL | changes)), Path(folder) / "cube.nc")
        finally:
            for name, solver in zip(OF_SUNLIGHT, solvers, strict=True):
                setattr(slab_operators, name, solver)
    return {
        "layers": found["layers solved"],
        "sunlight": found["sunlight solved"],
        "spectra": found["radiance, columns: wavenumbers"],
        "clouds": sum(count for name, count in found.items() if name.startswith("clouds, ") and "thickness" in name),
    }


def _counted(solver: Any, found: Counter[str]) -> Any:
    def call(*arguments: Any, **keywords: Any) -> Any:
        found["sunlight solved"] += 1
        return solver(*arguments, **keywords)

    return call


COMMAND = """
import json, sys, time
sys.argv = ["hcss", *sys.argv[1:]]
from hcss_twin.cli import main
try:
    main()
except SystemExit as left:
    assert not left.code, left.code
own = [name for name in sys.modules if name.startswith("hcss")]
print(json.dumps({"modules": len(own), "seconds": time.process_time(),
    "libraries": [name for name in ("numpy", "numba", "scipy", "netCDF4", "pydantic") if name in sys.modules]}))
"""


def loaded_by(words: list[str], environment: dict[str, str]) -> dict[str, Any]:
    """Run a command, and return its modules, its libraries and its seconds of a processor."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *words], env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-300:])
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def line(name: str, changes: dict[str, Any] | None) -> str:
    """Measure a scene, and return its line of the table."""
    words = ["--help"]
    if changes is not None:
        keys = [f"{key}={json.dumps(value)}" for key, value in (SMALL | changes).items()]
        words = ["run", "stratus", "--quiet", "--force", "-o", "cube.nc", *(w for key in keys for w in ("--set", key))]
    with tempfile.TemporaryDirectory(prefix="hcss-needed-") as folder:
        words = [word.replace("cube.nc", str(Path(folder) / "cube.nc")) for word in words]
        counted = {"layers": 0, "sunlight": 0, "spectra": 0, "clouds": 0}
        if changes is not None:
            code = f"import json; from needed import counts_of; print(json.dumps(counts_of({changes!r})))"
            path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
            environment = os.environ | {"HCSS_CACHE_DIR": str(Path(folder) / "counted"), "PYTHONPATH": path}
            done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)
            counted = json.loads(done.stdout.splitlines()[-1])
        found = loaded_by(words, os.environ | {"HCSS_CACHE_DIR": str(Path(folder) / "cache")})
    libraries = ", ".join(found["libraries"]) or "none"
    computed = " | ".join(f"{counted[key]:,}" for key in ("clouds", "spectra", "layers", "sunlight"))
    return f"| {name} | {found['modules']} | {libraries} | {computed} | {found['seconds']:.2f} |"


HEAD = (
    "| scene | modules | libraries | fields of clouds | wavenumbers of radiance | layers solved "
    "| solutions for the sun | s |\n|---|---|---|---|---|---|---|---|"
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="rewrite the table of the page")
    given = parser.parse_args()
    rows = [HEAD]
    print(HEAD)
    for name, changes in SCENES.items():
        rows.append(line(name, changes))
        print(rows[-1], flush=True)
    if given.write:
        from page import put

        put("needed", "\n".join(rows), PAGE)


if __name__ == "__main__":
    main()
