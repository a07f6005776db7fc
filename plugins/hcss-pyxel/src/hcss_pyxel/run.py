"""Run Pyxel and write the result to one file."""

from __future__ import annotations

import importlib.metadata
import inspect
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from hcss_pyxel.files import complete_or_absent
from hcss_pyxel.loader import load_cube
from hcss_twin import open_cube
from hcss_twin.providers import HcssError, choose_from

LOADER = "hcss_pyxel.load_cube"


def run_pipeline(pipeline: Path, output: Path) -> dict[str, float]:
    """Run a pipeline and write the detector data after each step as NetCDF.

    Parameters
    ----------
    pipeline : Path
        YAML file of Pyxel in exposure or observation mode.
    output : Path

    Returns
    -------
    dict
        Mean of each variable.

    Raises
    ------
    CubeError
        If the file cannot be written.
    HcssError
        If an argument of the loader does not exist, or it refuses what it is given.
    """
    import pyxel

    configuration = pyxel.load(pipeline)
    calls = list(_loader_calls(configuration))
    _require_arguments(calls)
    try:
        # once: what Pyxel returns of an observation is computed, noise too, each time it is looked at
        held = pyxel.run_mode(configuration)["bucket"].to_dataset().load()
    except (HcssError, ValueError) as error:
        # the bar of progress has no line end
        print(file=sys.stderr)
        raise HcssError(str(error)) from error
    held.attrs.update(_provenance(pipeline, calls))
    with complete_or_absent(output) as draft:
        held.to_netcdf(draft, engine="netcdf4")
    return {f"{name} ({data.attrs.get('units', '')})": float(data.mean()) for name, data in held.data_vars.items()}


def _loader_calls(configuration: Any) -> Iterator[dict[str, Any]]:
    """Yield the arguments of each enabled loader."""
    for model in configuration.pipeline.photon_collection or ():
        if model.enabled and model.dump()["func"] == LOADER:
            yield dict(model.arguments)


def _require_arguments(calls: Iterable[dict[str, Any]]) -> None:
    known = [name for name in inspect.signature(load_cube).parameters if name != "detector"]
    for arguments in calls:
        for name in arguments:
            if name not in known:
                raise HcssError(f"load_cube: there is no argument '{name}'; {choose_from(name, known)}")


def _provenance(pipeline: Path, calls: Iterable[dict[str, Any]]) -> dict[str, str]:
    """Return the provenance of a result, for its global attributes."""
    versions = {name: importlib.metadata.version(name) for name in ("hcss-pyxel", "hcss-twin", "pyxel-sim")}
    cubes = [os.fspath(arguments["cube"]) for arguments in calls if "cube" in arguments]
    found = {
        "title": "What a detector held after each step of a Pyxel pipeline",
        "source": ", ".join(f"{name} {version}" for name, version in versions.items()),
        "pyxel_pipeline": pipeline.read_text(encoding="utf-8"),
    }
    if cubes:
        found["cube"] = ", ".join(cubes)
        with open_cube(cubes[0]) as dataset:
            found |= {f"cube_{name}": str(dataset.attrs[name]) for name in ("id", "title") if name in dataset.attrs}
    return found
