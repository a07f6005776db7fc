"""What a variable provider declares and returns is checked before the engine uses it."""

from types import SimpleNamespace

import numpy as np
import pytest
from hcss_author import sample_fields, sample_variable_inputs
from hcss_author.variables import units_problem

from hcss_twin.core.errors import ProviderError
from hcss_twin.cube.variables import ELEMENT_RADIANCE, VARIABLES
from hcss_twin.providers import Declaration, OutputVariable
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.providers.variables import check_output_variables

TEXTS = {"units": "1", "long_name": "x", "description": "y"}
VARIABLES_GIVEN = {
    "share": OutputVariable(**TEXTS, per_band=True, lowest=0.0, highest=1.0),
    "height": OutputVariable(**TEXTS, may_be_missing=True, dtype="float64"),
    "kind": OutputVariable(**TEXTS, dtype="uint8", flag_meanings=("sea", "cloud")),
}
GOOD = {
    "share": np.full((2, 3, 4), 0.5, dtype=np.float32),
    "height": np.where(np.eye(3, 4) > 0, np.nan, 7.0),
    "kind": np.eye(3, 4) > 0,
}


def asked(answer):
    provider = SimpleNamespace(
        declares=Declaration(), variables=VARIABLES_GIVEN, needs=("radiance",), values=lambda *arguments: answer
    )
    entry = SimpleNamespace(kind=Kind.VARIABLES, name="x", label="variable provider 'x'", distribution="hcss-x")
    fields = {"radiance": np.ones((2, 3, 4), dtype=np.float32)}
    return guard(entry, provider, sample_variable_inputs()).values(fields, 0.0)


def test_sound_values_pass_in_their_types():
    values = asked(GOOD)
    for name, array in GOOD.items():
        np.testing.assert_array_equal(values[name], array)
        assert values[name].dtype == VARIABLES_GIVEN[name].dtype


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"share": np.ones((3, 4))}, r"'share' of values\(\) broke its contract: expected shape \(2, 3, 4\)"),
        ({"share": GOOD["share"] + 1.0}, r"'share' of values\(\) .*expected values in .0, 1., got 1.5 to 1.5"),
        ({"share": np.full((2, 3, 4), np.nan)}, "'share' .*finite values, got 24 of 24 not finite"),
        ({"height": np.full((3, 4), np.inf)}, "'height' .*finite values"),
        ({"height": np.ma.masked_less(GOOD["height"], 8.0)}, "'height' .*a masked array"),
        ({"kind": np.eye(3, 4)}, "'kind' .*whole numbers"),
        ({"kind": np.full((3, 4), 2)}, "'kind' .*values in .0, 1., got 2 to 2"),
        ({"more": np.ones((3, 4))}, "a mapping with the variables share, height, kind, got share, height, kind, more"),
    ],
)
def test_anything_else_is_refused_by_name(changes, message):
    with pytest.raises(
        ProviderError, match=f"variable provider 'x': .*{message}.*; arguments: fields with radiance of"
    ):
        asked(GOOD | changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"units": " "}, "units is ' '; expected a line of text"),
        ({"description": "two\nlines"}, "description"),
        ({"standard_name": "Cloud Top"}, "standard_name is 'Cloud Top'"),
        ({"dtype": "float16"}, "dtype is 'float16'; .*float32"),
        ({"dtype": "int32", "may_be_missing": True}, "may_be_missing is True for int32; allowed: float32 or float64"),
        ({"flag_meanings": ("a",)}, "flag_meanings .*integer type"),
        ({"lowest": 2.0, "highest": 1.0}, "lowest is 2.0, highest 1.0"),
    ],
)
def test_a_malformed_description_names_its_field(changes, message):
    with pytest.raises(ValueError, match=message):
        OutputVariable(**TEXTS | changes)


@pytest.mark.parametrize(
    ("variables", "needs"),
    [({}, ("radiance",)), ({"Share": VARIABLES_GIVEN["share"]}, ("radiance",)), ({"share": ("1", "x")}, ("radiance",)),
     (VARIABLES_GIVEN, ()), (VARIABLES_GIVEN, ["radiance"]), (VARIABLES_GIVEN, ("radiance", "radiance"))],
)  # fmt: skip
def test_variables_and_needs_are_of_their_form(variables, needs):
    with pytest.raises(ValueError, match=r"expected a (mapping of names|tuple of distinct names)"):
        check_output_variables(variables, needs)


@pytest.mark.parametrize(
    "text",
    ["1", "K", "m", "km", "um", "W m-2 sr-1", "W m-2 sr-1 um-1", "g m-2", "W/m2", "kg m**-3", "m.s-1", "hPa", "degree",
     "degrees_north", "%", "percent", "1e-3 kg", "mW cm-2", "K2", "m^2", "kelvin", "watts", "micron", "dam", "min",
     "ppm", "degC", "counts",
     "", "watt per bicycle", "W m-2 str-1", "W m - 2", "photons", "Kelvins m-2 x", "W m-2 sr-", "radiance", "W;m"],
)  # fmt: skip
def test_units_of_the_kit_are_those_of_udunits(text):
    cf_units = pytest.importorskip("cf_units")
    try:
        known = bool(text) and not cf_units.Unit(text).is_unknown()
    except ValueError:
        known = False
    assert (units_problem(text) == "") == known


def test_the_sample_has_every_variable_of_the_engine_in_its_shape():
    inputs = sample_variable_inputs()
    fields = sample_fields(inputs)
    sizes = {"band": 2, "layer": 1, "y": inputs.grid.rows, "x": inputs.grid.columns}
    for spec in VARIABLES:
        array = fields[spec.name]
        assert array.shape == tuple(sizes[dim] for dim in spec.dims if dim != "time"), spec.name
        assert array.dtype == spec.dtype, spec.name
        there = array[~np.isnan(array)] if array.dtype.kind == "f" else array
        assert spec.lowest is None or there.min() >= spec.lowest, spec.name
        assert spec.highest is None or there.max() <= spec.highest, spec.name
        assert spec.may_be_missing == bool(there.size < array.size), spec.name
    assert ELEMENT_RADIANCE in fields
