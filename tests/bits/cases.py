"""The cases whose results are recorded, by name: the functions of ``scenes.py`` and ``uses.py``.

A case uses only the public names of ``hcss_twin`` and the command ``hcss``: it stays as it is when modules move.
It returns, by name, datasets (paths of cubes or open datasets), arrays, and answers in JSON.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path

import scenes
import uses
from small_cubes import Results

CASES: dict[str, Callable[[Path], Results]] = {
    name.replace("_", "-"): function
    for module in (scenes, uses)
    for name, function in vars(module).items()
    if inspect.isfunction(function) and function.__module__ == module.__name__
}

QUICK = ("clear-sky", "night", "window", "layers-averaged-pixels", "plan")
"""Cases that take a second or less each with the kernels compiled: every run of the tests compares them."""

CAMPAIGN = (
    "fit-dimension",
    "fit-image",
    "match",
    "shipped-cirrus",
    "shipped-cumulus",
    "shipped-degraded-cirrus",
    "shipped-simulated",
    "shipped-stratus",
)
"""Cases whose parts others record: layers of shipped scenes (`shipped-cirrus-over-cumulus`; cirrus by day,
`wide-field-physical` and `moving-sun-physical`), blur and noise of a sensor (`sense-of-a-cube`, `run-with-a-sensor`),
and the fields and measures that searches compare."""

NEEDS = {
    "imagery-clouds": "iris_sample_data",
    "surrogate-clouds": "hcss_skies",
    "evaluate": "hcss_evaluate",
    "exports": "hcss_export",
    "fit-dimension": "hcss_evaluate",
    "fit-image": "hcss_evaluate",
    "match": "hcss_evaluate",
    "propagation": "hcss_uncertainty",
    "sweep-of-three-points": "hcss_sweep",
    "zarr-quantized": "zarr",
}
"""Packages that cases need beside this one, by case: without them they are left out."""

RANDOM_WALKS = ("fit-dimension", "fit-image", "match")
"""Cases in which rounding decides between branches, and each branch leads elsewhere: they have no tolerance."""
