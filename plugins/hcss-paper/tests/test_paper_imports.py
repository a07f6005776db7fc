"""The package imports of hcss_twin what its README names, and nothing else."""

import ast
import re
from pathlib import Path

import hcss_paper

PUBLIC = {"hcss_twin", "hcss_twin.providers", "hcss_twin.physics.paths", "hcss_twin.physics.planck"}


MODULES_BY_NAME = {"pierson_moskowitz", "atmosphere_plot"}
"""Imported from their package, as ``from hcss_twin.reports import atmosphere_plot``."""


def imported():
    for path in Path(hcss_paper.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                yield from (each.name for each in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = {each.name for each in node.names}
                yield from (f"{node.module}.{name}" for name in names & MODULES_BY_NAME)
                if names - MODULES_BY_NAME:
                    yield node.module


def test_only_named_modules_are_imported():
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    section = readme.partition("## What it uses of hcss_twin")[2]
    named = {
        f"hcss_twin.{name}"
        for row in section.splitlines()
        if row.startswith("| `")
        for name in re.findall(r"`([\w.]+)`", row.split("|")[1])
    }
    used = {name for name in imported() if name.partition(".")[0] == "hcss_twin"}
    assert used - PUBLIC == named
