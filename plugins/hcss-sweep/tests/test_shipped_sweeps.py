"""Sweeps that ship, and those of the documentation, are valid; the page says what the code does."""

import re
from pathlib import Path

import pytest
from hcss_sweep.design import Design
from hcss_sweep.points import points_of, require_one_layout

import hcss_twin
from hcss_twin.core.catalog import catalog_root

SHIPPED = sorted(path.stem for path in (catalog_root() / "sweeps").glob("*.toml"))
PAGE = (Path(hcss_twin.__file__).parents[1] / "docs" / "how-to" / "sweeps.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_sweeps_are_valid_and_named_in_the_documentation(name):
    design = Design.load(name)
    require_one_layout(design, points_of(design))
    assert design.title
    assert f"`hcss sweep {name}`" in PAGE


def test_the_first_example_has_as_many_points_as_it_says(tmp_path):
    (tmp_path / "mine.toml").write_text(re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0])
    design = Design.load(tmp_path / "mine.toml")
    points = points_of(design)
    assert f"3 x 5 x 4 = {len(points)} cubes" in PAGE
    assert design.shape == (3, 5, 4)
    require_one_layout(design, points)


def test_forms_of_values_in_the_documentation_are_read():
    scenario = {"time": "2024-04-20T12:30:00Z", "place": {"latitude": 35, "longitude": 150}, "clouds": {}}
    table = PAGE.split("## Values")[1].split("Quantities may")[0]
    found = re.findall(r"`([a-z.]+ = .*?)`[,;| ]", table)
    assert len(found) >= 6
    import tomllib

    for text in found:
        if "..." not in text and not text.startswith(("scale", "mean", "combine")):
            # values drawn from a list repeat, which the page allows with zip alone
            combined = {"combine": "zip"} if "choice" in text else {}
            points_of(Design.load({**scenario, "sweep": tomllib.loads(text) | combined}))
