"""What the recorded cases share: small scenes, their cubes, an image of clouds, and the command."""

from __future__ import annotations

import contextlib
import importlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, simulate

Results = dict[str, Any]

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
"""The models of the HCSS paper, which compile quickly."""

SMALL = {
    "image.rows": 32,
    "image.columns": 48,
    "frames.count": 2,
    "accuracy": 1e-2,
    "output.certificate": 8,
    "output.variables": ["all"],
}
IR = {"bands": ["mwir-3.7", "lwir-10.8"]}

SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
    "sea": {"temperature": 291.4, "wind_speed": 8.0},
    "seed": 3,
}
LAYERS = [
    {"type": "stratus", "generator": "fractal", "coverage": 0.4, "coverage_mode": "field"},
    {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field", "edge_taper": 0.2},
]


def hcss(*words: object) -> str:
    """Run the command, and return what it prints for programs."""
    from click.testing import CliRunner

    command = importlib.import_module("hcss_twin.cli").cli
    done = CliRunner().invoke(command, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return str(done.stdout)


def cube(folder: Path, source: str | dict[str, Any], name: str = "cube.nc", **overrides: Any) -> Path:
    """Write the cube of a shipped scenario, or of keys, made small."""
    values = {**SMALL, **overrides}
    load = Scenario.load if isinstance(source, str) else Scenario.from_dict
    simulate(load(source, values), folder / name).close()
    return folder / name


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Run in a folder, so that no path of the machine is in a scenario."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def fragment(folder: Path, name: str, text: str) -> Path:
    """Write a scenario file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def cloud_image(rows: int = 96, columns: int = 112) -> np.ndarray:
    """Blurred noise between 0 and 1, by exact binary steps of addition: the same on any machine."""
    values = np.random.default_rng(7).integers(0, 2**20, (rows, columns)).astype(np.float64)
    for _ in range(6):
        for axis in (0, 1):
            values = values + np.roll(values, 1, axis)
    return (values - values.min()) / np.ptp(values)
