"""What runs of some scenes cost, as counts that no other load on the machine changes, against the committed ones.

    python benchmarks/counts.py             # print
    python benchmarks/counts.py --check     # and fail where a count differs from benchmarks/counts.json by over 10 %
    python benchmarks/counts.py --update    # and write that file

Counted are layers solved for multiple scattering, calls of providers through their guards and the wavenumbers and
columns they were asked for, wavenumbers and thicknesses of the tables, and bytes of the cube. A count that fell is to
be committed, too: what is committed stays the truth.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import inspect
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from hcss_bench.stages import private_cache

from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.models.radiance.physical import slab_operators
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.providers.registry.guards.base import Guard
from hcss_twin.providers.registry.guards.images import GuardedClouds
from hcss_twin.providers.registry.guards.spectra import GuardedOptics, GuardedRadiance, GuardedSea, GuardedTransmittance

COMMITTED = Path(__file__).with_name("counts.json")
ALLOWED = 0.1
SMALL = {"image.rows": 200, "image.columns": 200, "frames.count": 2, "output.certificate": 4}
QUICK = "stratus, 10.8 um, 1e-2"
SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    QUICK: ("stratus", {"bands": ["lwir-10.8"], "accuracy": 1e-2}),
    "stratus": ("stratus", {}),
    "stratus, as-printed": ("stratus", {"radiance.model": "as-printed"}),
    "cirrus over cumulus, 3.7 um": ("cirrus-over-cumulus", {"bands": ["mwir-3.7"]}),
}
SOLVERS = ("solve_layers", "solve_sun", "solve_sunlit_layers", "transmit_beams", "solve_coupled_layers")
GUARDS: dict[str, type[Guard]] = {
    "clouds": GuardedClouds,
    "sea": GuardedSea,
    "optics": GuardedOptics,
    "gas": GuardedTransmittance,
    "radiance": GuardedRadiance,
}


def _counted(function: Callable[..., Any], add: Callable[[Mapping[str, Any]], None]) -> Callable[..., Any]:
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*arguments: Any, **keywords: Any) -> Any:
        add(signature.bind(*arguments, **keywords).arguments)
        return function(*arguments, **keywords)

    return call


@contextlib.contextmanager
def counting(counts: Counter[str]) -> Iterator[None]:
    """Count solutions and calls while the block runs."""

    def solved(given: Mapping[str, Any]) -> None:
        counts["layers solved"] += np.size(given["optical_thickness"])
        counts["layers solved, times streams"] += np.size(given["optical_thickness"]) * given["streams"]

    def called(name: str, given: Mapping[str, Any]) -> None:
        counts[f"{name}: calls"] += 1
        if "wavenumber_cm1" in given:
            counts[f"{name}: wavenumbers"] += np.size(given["wavenumber_cm1"])
        if "states" in given:
            counts[f"{name}: columns"] += len(given["states"])

    with contextlib.ExitStack() as stack:
        for name in SOLVERS:
            stack.enter_context(
                mock.patch.object(slab_operators, name, _counted(getattr(slab_operators, name), solved))
            )
        for kind, wrapper in GUARDS.items():
            for member, method in list(vars(wrapper).items()):
                plain = member.removeprefix("_checked_")  # an optional member
                if inspect.isfunction(method) and not plain.startswith("_"):
                    add = functools.partial(called, f"{kind}, {plain}")
                    stack.enter_context(mock.patch.object(wrapper, member, _counted(method, add)))
        yield


def counts_of(name: str) -> dict[str, int]:
    """Run a scene with an empty cache, and return its counts."""
    scene, changes = SCENES[name]
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="hcss-counts-") as folder, private_cache(Path(folder) / "cache"):
        scenario, cube = Scenario.load(scene, SMALL | changes), Path(folder) / "cube.nc"
        with counting(counts):
            run(make_plan(scenario), cube)
        tables = tables_of(make_plan(scenario))
        counts["tables: wavenumbers"] = tables.spectrum.nodes.wavenumber_cm1.size
        counts["tables: thicknesses"] = sum(axis.dense_m.size for axis in tables.axes if axis is not None)
        counts["cube: bytes"] = cube.stat().st_size
    return dict(sorted(counts.items()))


def differences(committed: Mapping[str, int], counted: Mapping[str, int], allowed: float = ALLOWED) -> list[str]:
    """Return a line for each count that differs by more than is allowed, is new, or is no longer counted."""
    lines = []
    for name in sorted({*committed, *counted}):
        before, now = committed.get(name, 0), counted.get(name, 0)
        if abs(now - before) > allowed * before:
            change = f"{100 * (now / before - 1):+.0f} %" if before else "new"
            lines.append(f"{name}: {now}, committed {before} ({change}, allowed {100 * allowed:g} %)")
    return lines


def committed_counts() -> dict[str, dict[str, int]]:
    """Read the committed counts of each scene."""
    found: dict[str, dict[str, int]] = json.loads(COMMITTED.read_text(encoding="utf-8"))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--check", action="store_true", help="fail where a count differs by more than is allowed")
    parser.add_argument("--update", action="store_true", help="commit what was counted")
    given = parser.parse_args()
    before = committed_counts() if COMMITTED.exists() else {}
    lines = []
    for name in given.scenes:
        counted = counts_of(name)
        print(f"\n{name}\n" + "\n".join(f"  {what}: {count}" for what, count in counted.items()), flush=True)
        lines += [f"{name}: {line}" for line in differences(before.get(name, {}), counted)]
        if given.update:
            before[name] = counted
            COMMITTED.write_text(json.dumps(before, indent=1) + "\n", encoding="utf-8")
    if given.check:
        print("\n" + ("\n".join(lines) or f"no count differs from the committed one by more than {100 * ALLOWED:g} %"))
    return 1 if given.check and lines else 0


if __name__ == "__main__":
    sys.exit(main())
