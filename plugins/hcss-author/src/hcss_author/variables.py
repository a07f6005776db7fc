"""Contract tests of variable providers, their sample inputs, and the part of UDUNITS that their units can have."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hcss_author.contract import NoMaker, ProviderContract, holds
from hcss_author.samples import sample_element_inputs
from hcss_twin.laws import questions_of
from hcss_twin.providers import Kind, VariableInputs, VariableProvider

_COLDEST_K, _WARMEST_K = 220.0, 305.0

_TERMS = (
    *("cloud_emission", "cloud_reflected_sun", "sea_emission", "sea_reflected_sun", "path_emission"),
    *("reflected_air_emission", "path_scattered_sun"),
)

_PIXELS: Mapping[str, tuple[float, float, str]] = {
    "cloud_mask": (0, 2, "uint8"),
    "shadow_mask": (0, 2, "uint8"),
    "cloud_fraction": (0.01, 1, "float32"),
    "cloud_thickness": (50, 800, "float32"),
    "cloud_top_altitude": (1050, 1800, "float32"),
    "cloud_top_temperature": (276, 281, "float32"),
    "sea_slope_x": (-0.2, 0.2, "float32"),
    "sea_slope_y": (-0.2, 0.2, "float32"),
    "sea_temperature": (285, 300, "float32"),
    "water_vapour_factor": (0.8, 1.2, "float32"),
    "surface_class": (0, 2, "uint8"),
    "surface_temperature": (270, 310, "float32"),
    "element": (0, 3, "uint8"),
    "element_share": (0, 1, "float32"),
    "element_source": (1, 5, "float32"),
    "element_altitude": (0, 9000, "float32"),
    "element_row": (0, 8, "float32"),
    "element_column": (0, 8, "float32"),
    "element_row_rate": (-5, 5, "float32"),
    "element_column_rate": (-5, 5, "float32"),
    "latitude": (34, 36, "float64"),
    "longitude": (149, 151, "float64"),
    "view_zenith": (10, 50, "float64"),
    "view_azimuth": (80, 100, "float64"),
    "sun_zenith": (20, 70, "float64"),
    "sun_azimuth": (0, 360, "float64"),
}
"""Range and type of variables with one value per pixel; whole numbers exclude the upper end."""

_CLOUDY = ("cloud_fraction", "cloud_thickness", "cloud_optical_thickness", "cloud_layer_thickness")
_TOPS = ("cloud_top_altitude", "cloud_top_temperature")


def sample_variable_inputs(bands: int = 2) -> VariableInputs:
    """Return inputs of a variable provider over :func:`sample_grid`."""
    element = sample_element_inputs(bands)
    return VariableInputs(element.bands, element.grid, element.view, element.catalog)


def sample_fields(inputs: VariableInputs, seed: int = 1) -> dict[str, NDArray[Any]]:
    """Return every variable of the engine, and its geometry, with random values of usual size, by name.

    Radiance and brightness temperature are those of bodies of 220 to 305 K; clear pixels, a third of all, have no cloud
    top. Terms and variables of elements have the names of this package's providers.
    """
    random, count = np.random.default_rng(seed), len(inputs.bands)
    shape = inputs.grid.rows, inputs.grid.columns
    fields = {name: random.uniform(low, high, shape).astype(dtype) for name, (low, high, dtype) in _PIXELS.items()}
    black_body = sample_element_inputs(count).black_body
    cold, warm = (black_body(kelvin)[:, None, None] for kelvin in (_COLDEST_K, _WARMEST_K))
    added = ("element_radiance", "element_point_radiance", "radiance_between_columns")
    for name in ("radiance", *added, *(f"radiance_{term}" for term in _TERMS)):
        share = random.random((count, *shape))
        fields[name] = (cold + (warm - cold) * share).astype(np.float32)
    of_bands = {
        "brightness_temperature": (_COLDEST_K, _WARMEST_K),
        "cloud_optical_thickness": (0.5, 30.0),
        "element_transmittance": (0.0, 1.0),
    }
    fields |= {name: random.uniform(*ends, (count, *shape)).astype(np.float32) for name, ends in of_bands.items()}
    fields["cloud_layer_thickness"] = fields["cloud_thickness"][None].copy()
    clear = random.random(shape) < 1.0 / 3.0
    fields["cloud_mask"] = (~clear).astype(np.uint8)
    none = fields["element"] == 0
    missing = [name for name in fields if name.startswith("element_") and not name.endswith(("share", "radiance"))]
    for name in missing:
        fields[name][..., none] = np.nan
    for names, value in ((_CLOUDY, 0.0), (_TOPS, np.nan)):
        for name in names:
            fields[name][..., clear] = value
    return fields


_SYMBOLS = frozenset((
    "1", "m", "g", "s", "K", "A", "mol", "cd", "rad", "sr", "Hz", "N", "Pa", "J", "W", "C", "V", "ohm", "T", "bar",
    "h", "min", "d", "L", "l", "eV", "arc_degree", "degC", "Celsius", "um", "%", "percent", "ppm"
))  # fmt: skip
_WORDS = frozenset((
    "meter", "metre", "gram", "second", "kelvin", "mole", "radian", "steradian", "hertz", "newton", "pascal",
    "joule", "watt", "coulomb", "volt", "hour", "minute", "day", "degree", "micron", "liter", "litre",
    "degree_north", "degrees_north", "degree_east", "degrees_east", "degree_C", "count"
))  # fmt: skip
_PREFIXES = re.compile("(?:da|[YZEPTGMkhdcmunpfazy])(?=.)")
_LONG_PREFIXES = re.compile("(?:giga|mega|kilo|hecto|deci|centi|milli|micro|nano|pico)(?=.)")
_FACTOR = re.compile(r"(?P<name>%|1|[A-Za-z_]+)(?:(?:\^|\*\*)?(?P<power>[+-]?\d+))?")
_SCALE = re.compile(r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)? (?=\S)")


def units_problem(text: str) -> str:
    """Return what is wrong with units, such as ``W m-2 sr-1``; empty if nothing is.

    A product of powers, divided by "/", of the usual units with decimal prefixes; "1" for a number without dimension.
    """
    rest = _SCALE.sub("", text, count=1)
    for factor in re.split(r"\s*/\s*|\s*\.\s*|(?<!\*)\*(?!\*)|\s+", rest):
        found = _FACTOR.fullmatch(factor)
        if found is None:
            return f"'{text}': '{factor}' is no power of a unit, such as m-2"
        if not _is_known(found["name"]):
            return f"'{text}': '{found['name']}' is no unit of UDUNITS that this kit knows"
    return ""


def _is_known(name: str) -> bool:
    singular = name[:-1] if name.endswith("s") else name
    return (
        name in _SYMBOLS
        or _PREFIXES.sub("", name, count=1) in _SYMBOLS - {"1", "%"}
        or bool({name, singular} & _WORDS)
        or bool({_LONG_PREFIXES.sub("", form, count=1) for form in (name, singular)} & _WORDS)
    )


Values = Mapping[str, NDArray[Any]]


@holds(Kind.VARIABLES)
class VariableContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls.
    known_tolerance : float
        Allowed difference from ``known``, relative to its largest value.
    """

    _kind = Kind.VARIABLES
    times_s: tuple[float, ...] = (0.0, 7.5)
    known_tolerance: float = 1e-5

    def make_provider(self, inputs: VariableInputs) -> VariableProvider:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    def known(self, inputs: VariableInputs, fields: Values, time_s: float) -> Values | None:
        """Return what a closed form says of some or all variables; override to have values checked."""
        return None

    @pytest.fixture
    def inputs(self) -> VariableInputs:
        """Inputs; override to choose others."""
        return sample_variable_inputs()

    @pytest.fixture
    def fields(self, inputs: VariableInputs) -> dict[str, NDArray[Any]]:
        """Every variable of the engine and its geometry; override where values of the sample do not fit."""
        return sample_fields(inputs)

    @pytest.fixture
    def questions(self, provider: VariableProvider, inputs: VariableInputs, fields: Values) -> tuple[Any, ...]:
        """Fields, and others."""
        others = sample_fields(inputs, seed=2)
        one, other = ({name: given[name] for name in provider.needs} for given in (fields, others))
        return questions_of(Kind.VARIABLES, None, None, two=(one, other))

    def test_units_are_those_of_udunits(self, provider: VariableProvider) -> None:
        """Units are products of powers of units of the UDUNITS database, as CF requires."""
        problems = {name: units_problem(about.units) for name, about in provider.variables.items()}
        assert not any(problems.values()), problems

    def test_shapes_types_and_limits_are_those_declared(
        self, provider: VariableProvider, inputs: VariableInputs, fields: Values
    ) -> None:
        """Each declared variable: its shape, a type that its own can hold, its limits, NaN only if declared."""
        for time in self.times_s:
            _of(self._guarded(provider, inputs), fields, time)

    def test_something_is_there_where_inputs_are(self, provider: VariableProvider, fields: Values) -> None:
        """Values are not missing in every pixel, and not the same in every pixel."""
        for name, array in _of(provider, fields, self.times_s[0]).items():
            there = array[~np.isnan(array)] if array.dtype.kind == "f" else array
            assert there.size, f"{name} is missing in every pixel"
            assert there.min() < there.max(), f"{name} is {there.flat[0]} in every pixel"

    def test_values_are_those_of_a_closed_form(
        self, provider: VariableProvider, inputs: VariableInputs, fields: Values
    ) -> None:
        """Values are what ``known`` says, and missing where it says so."""
        if self.known(inputs, fields, self.times_s[0]) is None:
            pytest.skip("define known(self, inputs, fields, time_s) to have values checked: no other law can know them")
        for time in self.times_s:
            values = _of(provider, fields, time)
            for name, expected in (self.known(inputs, fields, time) or {}).items():
                largest = float(np.nanmax(np.abs(expected)))
                np.testing.assert_allclose(
                    values[name], expected, rtol=0.0, atol=self.known_tolerance * largest, err_msg=name
                )

    def test_a_pixel_depends_on_itself_alone(
        self, provider: VariableProvider, inputs: VariableInputs, fields: Values
    ) -> None:
        """Windows change no bit of a pixel."""
        rows, columns = inputs.grid.rows, inputs.grid.columns
        whole = _of(provider, fields, self.times_s[0])
        for window in np.s_[..., 3:17, 5:6], np.s_[..., rows - 1 :, :], np.s_[..., :, columns // 2 :]:
            part = _of(provider, {name: values[window] for name, values in fields.items()}, self.times_s[0])
            for name, array in whole.items():
                np.testing.assert_array_equal(part[name], array[window], name)

    def test_only_declared_inputs_matter(
        self, provider: VariableProvider, inputs: VariableInputs, fields: Values
    ) -> None:
        """Each input in ``needs`` changes a result; nothing is asked for that is not in ``needs``."""
        whole = _of(provider, fields, self.times_s[0])
        other = sample_fields(inputs, seed=2)
        for name in provider.needs:
            mixed = _of(provider, {**fields, name: other[name]}, self.times_s[0])
            changed = any(not np.array_equal(mixed[name], whole[name], equal_nan=True) for name in whole)
            assert changed, f"'{name}' in needs changes nothing"

    def test_calls_may_come_in_any_order(self, provider: VariableProvider, inputs: VariableInputs) -> None:
        """Results depend on inputs and time alone, not on earlier calls."""
        calls = [(sample_fields(inputs, seed), time) for seed in (1, 2) for time in self.times_s]
        forward = [_of(provider, *call) for call in calls]
        another = self.make_provider(inputs)
        backward = [_of(another, *call) for call in reversed(calls)]
        for one, two in zip(forward, reversed(backward), strict=True):
            for name in one:
                np.testing.assert_array_equal(one[name], two[name], name)


def _of(provider: VariableProvider, fields: Values, time_s: float) -> Values:
    """Return the values for the declared inputs alone, which cannot be written to."""
    lacking = [name for name in provider.needs if name not in fields]
    if lacking:
        pytest.fail(f"needs {lacking}: no variable of the engine or its geometry; known: {', '.join(sorted(fields))}")
    needed = {name: fields[name].view() for name in provider.needs}
    for values in needed.values():
        values.flags.writeable = False
    return provider.values(needed, time_s)
