"""The table of variables, what a scenario may ask for, and the generated reference."""

from pathlib import Path

import pytest

from hcss_twin.cube.coordinates import COORDINATES
from hcss_twin.cube.requested_variables import expand, term_variable
from hcss_twin.cube.variables import VARIABLES

TERMS = {"sea_emission": "Emission of the sea.", "sun_glint": "Glint."}


def names(requested, layer_count=2, shadows=True):
    more = {"elements": [{}], "surfaces": ["sea"], "light": True}
    return [spec.name for spec in expand(requested, TERMS, layer_count, shadows, **more)]


def test_names_are_unique_over_variables_and_coordinates():
    every = [spec.name for spec in (*VARIABLES, *COORDINATES)]
    assert len(every) == len(set(every))


def test_all_is_the_table_then_the_terms():
    assert names(["all"]) == [spec.name for spec in VARIABLES] + ["radiance_sea_emission", "radiance_sun_glint"]


def test_groups_and_names_combine_in_the_order_of_the_table_without_repetition():
    expected = ["radiance", "radiance_between_columns", "radiance_sea_emission", "radiance_sun_glint"]
    assert names(["terms", "radiance", "terms"]) == expected
    assert names(["truth"]) == [spec.name for spec in VARIABLES if spec.kind == "truth"]
    assert names(["radiance_sun_glint", "cloud_mask"]) == ["cloud_mask", "radiance_sun_glint"]


@pytest.mark.parametrize("layer_count", [0, 1])
def test_variables_by_layer_are_in_groups_only_where_there_are_two(layer_count):
    for group in ("all", "truth"):
        assert set(names([group])) - set(names([group], layer_count)) == {"cloud_layer_thickness"}


def test_variables_by_layer_can_be_named_where_there_is_a_layer():
    assert names(["cloud_layer_thickness"], 1) == ["cloud_layer_thickness"]
    with pytest.raises(ValueError, match="no cloud layer"):
        names(["cloud_layer_thickness"], 0)


def test_an_unknown_name_is_refused_with_the_closest_one():
    with pytest.raises(ValueError, match=r"'radiance_sun_glitn'.*allowed: .*closest is 'radiance_sun_glint'"):
        names(["radiance_sun_glitn"])


def test_asking_for_nothing_is_refused():
    with pytest.raises(ValueError, match="no output variable"):
        names([])
    with pytest.raises(ValueError, match="no output variable"):
        expand(["terms"], {})


@pytest.mark.parametrize("name", ["", "Sun", "sun glint", "1st", "glint\n"])
def test_a_term_that_is_no_plain_name_is_refused(name):
    with pytest.raises(ValueError, match="radiance term"):
        term_variable(name, "text")


SHORT = {("time", "y", "x"): "image", ("time", "band", "y", "x"): "bands"}
"""Dimensions in the tables of the reference."""


def test_the_reference_names_every_variable_and_coordinate():
    text = (Path(__file__).parents[2] / "docs" / "reference" / "cube.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:3]] for line in text.splitlines() if line.startswith("| `")]
    dims = {name: shown for names, shown in rows for name in names.split(", ")}
    for spec in (*VARIABLES, *COORDINATES):
        assert dims[f"`{spec.name}`"] == SHORT.get(spec.dims, ", ".join(spec.dims) or "scalar")


def test_the_mask_of_shadows_is_there_where_clouds_cast_any():
    assert set(names(["all"])) - set(names(["all"], shadows=False)) == {"shadow_mask"}
    assert names(["shadow_mask"]) == ["shadow_mask"]
    with pytest.raises(ValueError, match=r"'shadow_mask'.*allowed: with slant\.shadows = .on."):
        names(["shadow_mask"], shadows=False)
