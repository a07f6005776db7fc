"""Every global attribute of a cube stands in its reference, with the type it has, and no other does."""

import json
from pathlib import Path

import pytest
from cheap import CHEAP, NARROW

from hcss_twin import Scenario, simulate
from hcss_twin.cube.metadata import ALWAYS, COMPUTED, DEFAULTS, PROVENANCE

SMALL = {**CHEAP, "image.rows": 16, "image.columns": 20, "frames.count": 1, "bands": NARROW[1:]}
OF_PLUGINS = ("hcss_light", "hcss_monte_carlo", "hcss_provider_laws")
SPECS = {spec.name: spec for spec in (*PROVENANCE, *COMPUTED) if spec.name not in OF_PLUGINS}
"""But those of plugins: ``test_probes.py``, and the tests of hcss-light."""
REPLACEABLE = {*DEFAULTS, "id", "history"}
TYPES = {"text": str, "JSON": str, "number": float, "integer": int}


@pytest.fixture(scope="module")
def all_that_is_told(tmp_path_factory):
    """Of a cube with all attributes: terms, accuracy in kelvin, a sea that knows its waves, a file of the user."""
    response = tmp_path_factory.mktemp("files") / "response.csv"
    response.write_text("wavelength_um,response\n10.4,0\n10.5,1\n11.0,1\n11.1,0\n")
    bands = [{"name": "mine", "response": str(response)}]
    asked = {"accuracy": "0.5 K", "output.variables": ["all"], "sea.model": "rough-sea", "bands": bands}
    return simulate(Scenario.load("stratus", {**SMALL, **asked})).attrs


@pytest.fixture(scope="module")
def least_that_is_told():
    return simulate(Scenario.load("stratus", {**SMALL, "output.variables": ["cloud_mask"]})).attrs


def test_every_attribute_that_a_cube_carries_is_documented_and_no_other(all_that_is_told):
    assert set(all_that_is_told) == set(SPECS) | REPLACEABLE


def test_what_every_cube_is_said_to_have_is_there_without_radiance_and_nothing_about_radiance(least_that_is_told):
    always = {name for name, spec in SPECS.items() if spec.when == ALWAYS} | REPLACEABLE
    assert set(least_that_is_told) - {"hcss_significant_wave_height_m"} == always


def test_attributes_have_the_types_that_are_documented(all_that_is_told):
    for name, spec in SPECS.items():
        value = all_that_is_told[name]
        assert isinstance(value.item() if hasattr(value, "item") else value, TYPES[spec.type]), name
        if spec.type == "JSON":
            json.loads(value)


def test_the_reference_has_a_row_for_each():
    text = (Path(__file__).parents[2] / "docs" / "reference" / "cube.md").read_text(encoding="utf-8")
    for name in (*SPECS, *DEFAULTS):
        assert f"`{name}`" in text, name
