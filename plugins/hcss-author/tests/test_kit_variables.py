"""The kit accepts a variable in closed form and refuses variable providers that break a law."""

import numpy as np
import pytest
from hcss_author import VariableContract, sample_fields, sample_variable_inputs

from hcss_twin.providers import Declaration, HcssError, OutputVariable

REFUSED = (AssertionError, HcssError)
"""What laws raise, and the checks that a run makes of each result."""


class Path:
    """Length of the line of sight in cloud."""

    declares = Declaration()
    needs = ("cloud_thickness", "view_zenith")
    units, missing, dtype = "m", True, "float32"

    @property
    def variables(self):
        text = {"long_name": "path in cloud", "description": "Missing where clear."}
        return {"path": OutputVariable(self.units, **text, may_be_missing=self.missing, dtype=self.dtype, lowest=0.0)}

    def values(self, fields, time_s):
        path = fields["cloud_thickness"] / np.cos(np.radians(fields["view_zenith"]))
        return {"path": np.where(path > 0.0, path, np.nan)}


class TestPath(VariableContract):
    def make_provider(self, inputs):
        return Path()


class Relative(Path):
    def values(self, fields, time_s):
        path = super().values(fields, time_s)["path"]
        return {"path": path / np.nanmax(path)}


class Counting(Path):
    calls = 0

    def values(self, fields, time_s):
        self.calls += 1
        return {"path": self.calls * super().values(fields, time_s)["path"]}


class Writing(Path):
    def values(self, fields, time_s):
        fields["cloud_thickness"][:] += 1.0
        return super().values(fields, time_s)


def changed(change, **attributes):
    methods = {
        "values": lambda self, fields, time_s: {"path": change(fields, Path.values(self, fields, time_s)["path"])}
    }
    return type("Changed", (Path,), methods | attributes)


def same(fields, path):
    return path


@pytest.mark.parametrize(
    ("law", "provider"),
    [
        ("units_are_those_of_udunits", changed(same, units="W m-2 str-1")),
        ("shapes_types_and_limits_are_those_declared", changed(lambda fields, path: path.T)),
        ("shapes_types_and_limits_are_those_declared", changed(lambda fields, path: path[None])),
        ("shapes_types_and_limits_are_those_declared", changed(lambda fields, path: -path)),
        ("shapes_types_and_limits_are_those_declared", changed(lambda fields, path: path / 0.0)),
        ("shapes_types_and_limits_are_those_declared", changed(same, missing=False)),
        ("shapes_types_and_limits_are_those_declared", changed(same, missing=False, dtype="int32")),
        ("something_is_there_where_inputs_are", changed(lambda fields, path: np.nan * path)),
        ("something_is_there_where_inputs_are", changed(lambda fields, path: np.ones_like(path))),
        ("a_pixel_depends_on_itself_alone", Relative),
        ("a_pixel_depends_on_itself_alone", changed(lambda fields, path: np.roll(path, 1, axis=1))),
        ("only_declared_inputs_matter", changed(lambda fields, path: fields["cloud_thickness"])),
        ("only_declared_inputs_matter", changed(same, needs=("cloud_thickness", "view_zenith", "cloud_mask"))),
        ("calls_may_come_in_any_order", Counting),
    ],
)
def test_what_breaks_a_law_is_refused(law, provider):
    with np.errstate(all="ignore"), pytest.raises(REFUSED):
        held_to(law, provider)


@pytest.mark.parametrize(
    ("provider", "said"),
    [
        (Writing, "read-only"),
        (changed(same, needs=("cloud_thickness",)), "KeyError"),
        (changed(same, needs=("cloud_thickness", "zenith")), "no variable of the engine"),
    ],
)
def test_undeclared_inputs_and_writing_fail_at_once(provider, said):
    with pytest.raises((HcssError, pytest.fail.Exception), match=said):
        held_to("shapes_types_and_limits_are_those_declared", provider)


def held_to(law, provider):
    contract, inputs = TestPath(), sample_variable_inputs()
    contract.make_provider = lambda inputs: provider()
    given = {"provider": provider(), "inputs": inputs, "fields": sample_fields(inputs)}
    test = getattr(contract, f"test_{law}")
    test(**{name: given[name] for name in test.__code__.co_varnames[: test.__code__.co_argcount] if name in given})
