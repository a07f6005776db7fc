"""Arrows between packages run one way."""

import ast
from pathlib import Path

import pytest

import hcss_twin

PACKAGE = Path(hcss_twin.__file__).parent

# What each room may import of ours, besides itself.
GROUND = {"errors"}
STAND_ON = {"physics", "providers", "catalog", "refractive_index"} | GROUND
ALLOWED = {
    "physics": set(),
    "errors": set(),
    "version": set(),
    "json_numbers": set(),
    "netcdf_format": GROUND,
    "drafts": GROUND,
    "shelf": set(),
    "catalog": {"shelf"} | GROUND,
    "refractive_index": {"catalog"} | GROUND,
    "providers": {"catalog", "physics"},
    "evaluation": GROUND,
    "clouds": STAND_ON | {"evaluation", "netcdf_format", "drafts", "version"},
    "matching": STAND_ON | {"evaluation", "clouds", "drafts"},
    "uncertainty": STAND_ON | {"matching", "evaluation", "clouds", "drafts", "version"},
    "sea": STAND_ON,
    "cache": {"drafts"} | GROUND,
    "optics": STAND_ON | {"netcdf_format", "drafts", "cache"},
    "atmosphere": STAND_ON | {"netcdf_format", "version"},
    "climatology": {"catalog"} | GROUND,
    "multiple_scattering": {"physics", "providers"} | GROUND,
    "radiance": STAND_ON | {"atmosphere", "multiple_scattering"},
    "viewing": {"physics"} | GROUND,
    "cube": {"physics", "version", "drafts", "viewing"} | GROUND,
    "export": {"cube", "drafts", "json_numbers", "version"} | GROUND,
    "sensor": STAND_ON,
    "comparison": {
        "catalog",
        "clouds",
        "cube",
        "evaluation",
        "export",
        "json_numbers",
        "radiance",
        "scenario",
        "scene",
    }
    | GROUND,
    "sweeps": {"scenario", "scene", "cube", "drafts", "versions", "shelf"} | GROUND,
    "propagation": {
        "compilation_notice",
        "drafts",
        "evaluation",
        "registry",
        "scenario",
        "scene",
        "shelf",
        "sweeps",
        "uncertainty",
        "versions",
    }
    | GROUND,
    "registry": {"catalog", "providers", "physics", "version"} | GROUND,
}


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("hcss_twin."):
            yield node.module.split(".")[1]
        elif isinstance(node, ast.Import):
            yield from (name.name.split(".")[1] for name in node.names if name.name.startswith("hcss_twin."))


@pytest.mark.parametrize("room", sorted(ALLOWED))
def test_a_room_imports_only_what_it_stands_on(room):
    files = sorted((PACKAGE / room).rglob("*.py")) or [PACKAGE / f"{room}.py"]
    found = {name for path in files for name in imports(path)} - {room}
    assert found <= ALLOWED[room]
