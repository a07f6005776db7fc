"""Results of a version, recorded, so that a change of the code can be shown to leave them as they are.

    python tests/bits/record.py                   compare all cases with recorded.json
    python tests/bits/record.py night plan        compare some
    python tests/bits/record.py --write           record all cases
    python tests/bits/record.py --write night     record one again; the others stay

``cases.py`` lists the cases, and the packages that some of them need (``pip install ./plugins/hcss-skies``); without
these they are left out. For every variable that holds numbers, ``recorded.json`` has the SHA-256 of its type, shape and
little-endian bytes, and its smallest, mean and largest value. For answers in JSON it has every number with its place.
Text and global attributes are left out, except the numbers of certificates.

Bits depend on processor and packages. In the environment that was recorded, bits are compared. In any other one,
smallest, mean and largest values and numbers are compared within a relative 1e-6, and cases in which rounding decides
about the further course (fits, matches) are not compared.

The cache of results is a temporary folder, so that no result of an earlier run is compared; --cache names another one.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import platform
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

RECORDED = Path(__file__).with_name("recorded.json")

PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "netCDF4", "xarray", "pvlib", "emcee", "pillow", "zarr")

TOLERANCE = 1e-6
"""Relative to the largest value of a variable, where the environment is another one."""

DIGITS = 16
"""Of hashes, hexadecimal."""

CERTIFICATE = ("hcss_certificate", "hcss_table_error")
"""How the names of global attributes begin whose numbers are recorded."""

NOT_RECORDED = {"bytes", "seconds", "compiled"}
"""Numbers of an answer that are no result: sizes of files, which hold text, run times, and tables not in the cache."""


def environment() -> dict[str, Any]:
    """Return what bits depend on, and under "model" the processor's name for the reader."""
    import scipy.linalg  # noqa: F401  for the BLAS that it brings
    from llvmlite import binding
    from numba.core import config
    from threadpoolctl import threadpool_info

    features = sorted(name for name, has in binding.get_host_cpu_features().items() if has)
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    blas = {
        f"{each['internal_api']} {each['version']} {each.get('architecture')}"
        for each in threadpool_info()
        if each["user_api"] == "blas"
    }
    return {
        "packages": {name: version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "system": " ".join((platform.system(), platform.machine(), *platform.libc_ver())),
        "blas": sorted(blas),
        "processor": {
            "llvm": binding.get_host_cpu_name(),
            "compiled for": config.CPU_NAME or "host",
            "features": hashlib.sha256(" ".join(features).encode()).hexdigest()[:16],
            "numpy": [*simd["baseline"], *simd["found"]],
        },
        "model": _model(),
    }


def _model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")


def differences_of_environment(recorded: dict[str, Any]) -> list[str]:
    """Return what is other here than where the results were recorded; empty if bits can be compared."""
    here = environment()
    return [
        f"{name}: {recorded.get(name)} recorded, {here[name]} here"
        for name in here
        if name != "model" and recorded.get(name) != here[name]
    ]


# --- what is recorded of a result -------------------------------------------------------


def numbers_of(case: Any, folder: Path) -> dict[str, Any]:
    """Run a case in an empty folder, and return what is recorded of it.

    BLAS has one thread: how it cuts its sums depends on their number, and so does the last bit of a few results.
    """
    from threadpoolctl import threadpool_limits

    folder.mkdir(parents=True)
    recorded: dict[str, Any] = {}
    with threadpool_limits(1, user_api="blas"):
        results = case(folder)
    for part, result in results.items():
        if isinstance(result, dict):
            recorded[part] = {"numbers": dict(_leaves(result))}
        elif isinstance(result, np.ndarray):
            recorded[part] = {"variables": {"values": of_array(result)}}
        else:
            recorded[part] = of_dataset(result)
    return recorded


def of_dataset(result: Any) -> dict[str, Any]:
    """Return what is recorded of a NetCDF file as it is on the disk, or of a dataset in memory."""
    import xarray as xr

    if isinstance(result, Path):
        with xr.open_dataset(result, decode_cf=False, cache=False) as dataset:
            return of_dataset(dataset.load())
    variables = {
        str(name): of_array(variable.values)
        for name, variable in sorted(result.variables.items())
        if variable.dtype.kind in "biufMm"
    }
    result.close()
    checked = {}
    for name, value in result.attrs.items():
        if name.startswith(CERTIFICATE):
            checked |= dict(_leaves(_parsed(value), name))
    return {"variables": variables, **({"numbers": checked} if checked else {})}


def of_array(values: np.ndarray) -> dict[str, Any]:
    """Return the hash, and smallest, mean and largest value; times count as integers."""
    values = np.ascontiguousarray(values)
    values = values.astype(values.dtype.newbyteorder("<"), copy=False)
    digest = hashlib.sha256(f"{values.dtype.str} {values.shape} ".encode())
    digest.update(values.tobytes())
    recorded: dict[str, Any] = {
        "sha256": digest.hexdigest()[:DIGITS],
        "type": values.dtype.str,
        "shape": list(values.shape),
    }
    if values.dtype.kind in "Mm":
        values = values.astype(np.int64)
    finite = values[np.isfinite(values)].astype(np.float64)
    recorded["finite"] = int(finite.size)
    if finite.size:
        extent = {"min": finite.min(), "mean": math.fsum(finite) / finite.size, "max": finite.max()}
        recorded |= {name: float(f"{value:.10g}") for name, value in extent.items()}
    return recorded


def _parsed(value: Any) -> Any:
    if isinstance(value, str):
        try:
            return json.loads(value)
        except ValueError:
            return None
    return value.item() if isinstance(value, np.generic) else value


def _leaves(value: Any, place: str = "") -> Iterator[tuple[str, float | int | bool | None]]:
    """Yield the numbers of an answer with their places; keys that are sentences are prose."""
    if isinstance(value, dict):
        for key, each in value.items():
            if key not in NOT_RECORDED and " " not in key:
                yield from _leaves(each, f"{place}.{key}" if place else key)
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from _leaves(each, f"{place}[{number}]")
    elif isinstance(value, bool | int | float):
        yield place, value


# --- comparison -------------------------------------------------------------------------


def compare(recorded: dict[str, Any], here: dict[str, Any], exact: bool) -> list[str]:
    """Return the differences between two records of a case, a line each."""
    found = [f"{part}: recorded only" for part in recorded.keys() - here.keys()]
    found += [f"{part}: not recorded" for part in here.keys() - recorded.keys()]
    for part in sorted(recorded.keys() & here.keys()):
        for kind, same in (("variables", _same_array), ("numbers", _same_number)):
            one, other = (each[part].get(kind, {}) for each in (recorded, here))
            found += [f"{part}: {name}: recorded only" for name in sorted(one.keys() - other.keys())]
            found += [f"{part}: {name}: not recorded" for name in sorted(other.keys() - one.keys())]
            found += [
                f"{part}: {name}: {_brief(one[name])} recorded, {_brief(other[name])} here"
                for name in sorted(one.keys() & other.keys())
                if not same(one[name], other[name], exact)
            ]
    return found


def _same_array(one: dict[str, Any], other: dict[str, Any], exact: bool) -> bool:
    if exact:
        return bool(one["sha256"] == other["sha256"])
    if any(one[name] != other[name] for name in ("type", "shape", "finite")):
        return False
    scale = max(abs(one.get("min", 0.0)), abs(one.get("max", 0.0)))
    return all(abs(one[name] - other[name]) <= TOLERANCE * scale for name in ("min", "mean", "max") if name in one)


def _same_number(one: float, other: float, exact: bool) -> bool:
    if one == other or exact or isinstance(one, bool):
        return one == other or (one != one and other != other)
    return math.isclose(one, other, rel_tol=TOLERANCE, abs_tol=TOLERANCE)


def _brief(value: Any) -> str:
    if not isinstance(value, dict):
        return repr(value)
    extent = " ".join(f"{name} {value[name]!r}" for name in ("min", "mean", "max") if name in value)
    return f"{value['sha256']} {value['type']} {value['shape']} {extent}"


def recorded() -> dict[str, Any]:
    """Return the content of recorded.json."""
    return dict(json.loads(RECORDED.read_text(encoding="utf-8")))


# --- command ----------------------------------------------------------------------------


def main() -> int:
    """Record or compare; 1 if something differs."""
    from cases import CASES, NEEDS, RANDOM_WALKS

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--write", action="store_true", help="record instead of comparing")
    parser.add_argument("--exact", action="store_true", help="compare bits whatever the environment")
    parser.add_argument("--cache", metavar="FOLDER", help="cache of results to use instead of an empty one")
    chosen = parser.parse_args()
    unknown = sorted(set(chosen.cases) - CASES.keys())
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}; there are {', '.join(CASES)}")
    before = recorded() if RECORDED.exists() else {"environment": environment(), "cases": {}}
    other = differences_of_environment(before["environment"])
    if chosen.write and other and chosen.cases:
        parser.error(f"the other cases were recorded elsewhere ({'; '.join(other)}): record all")
    exact = chosen.exact or not other
    if not chosen.write:
        print("bits are compared" if exact else f"compared within {TOLERANCE:g}: {'; '.join(other)}")
    results, failed = {}, 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HCSS_CACHE_DIR"] = chosen.cache or str(Path(folder) / "cache")
        for name in chosen.cases or CASES:
            if name in NEEDS and find_spec(NEEDS[name]) is None:
                print(f"{name}: left out, it needs {NEEDS[name]}")
                continue
            start = time.perf_counter()
            results[name] = numbers_of(CASES[name], Path(folder) / name)
            seconds = time.perf_counter() - start
            if chosen.write:
                told = "recorded"
            elif not exact and name in RANDOM_WALKS:
                told = "not compared: no tolerance holds for it"
            else:
                found = compare(before["cases"].get(name, {}), results[name], exact)
                failed += bool(found)
                told = "\n  ".join(("DIFFERENT", *found)) if found else "same"
            print(f"{seconds:7.2f} s  {name}: {told}", flush=True)
    if chosen.write:
        cases = before["cases"] | results
        content = {"environment": environment(), "cases": {name: cases[name] for name in CASES if name in cases}}
        RECORDED.write_text(_text(content), encoding="utf-8")
    return 1 if failed else 0


def _text(content: dict[str, Any]) -> str:
    """One line per part of a case, so that a new record shows what changed."""
    lines = ["{", f' "environment": {json.dumps(content["environment"])},', ' "cases": {']
    for name, parts in content["cases"].items():
        inner = ",\n".join(f"   {json.dumps(part)}: {json.dumps(value)}" for part, value in parts.items())
        lines.append(f"  {json.dumps(name)}: {{\n{inner}\n  }},")
    lines[-1] = lines[-1].rstrip(",")
    return "\n".join([*lines, " }", "}", ""])


if __name__ == "__main__":
    sys.exit(main())
