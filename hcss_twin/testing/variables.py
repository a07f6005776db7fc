"""Contract tests of variable providers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hcss_twin.providers import VariableInputs, VariableProvider
from hcss_twin.providers.variables import GEOMETRY, check_output_variables
from hcss_twin.testing.contract import ProviderContract
from hcss_twin.testing.units import units_problem
from hcss_twin.testing.variable_samples import sample_fields, sample_variable_inputs

Values = Mapping[str, NDArray[Any]]


class VariableContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls.
    known_tolerance : float
        Allowed difference from ``known``, relative to its largest value.
    """

    times_s: tuple[float, ...] = (0.0, 7.5)
    known_tolerance: float = 1e-5

    def make_provider(self, inputs: VariableInputs) -> VariableProvider:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

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

    def test_declaration_is_sound(self, provider: VariableProvider) -> None:
        """Variables and inputs that the engine understands."""
        super().test_declaration_is_sound(provider)
        check_output_variables(provider.variables, provider.needs)

    def test_units_are_those_of_udunits(self, provider: VariableProvider) -> None:
        """Units are products of powers of units of the UDUNITS database, as CF requires."""
        problems = {name: units_problem(about.units) for name, about in provider.variables.items()}
        assert not any(problems.values()), problems

    def test_shapes_types_and_limits_are_those_declared(
        self, provider: VariableProvider, inputs: VariableInputs, fields: Values
    ) -> None:
        """Each declared variable: its shape, a type that its own can hold, its limits, NaN only if declared."""
        for time in self.times_s:
            values = _of(provider, fields, time)
            assert set(values) == set(provider.variables)
            for name, about in provider.variables.items():
                array = values[name]
                bands = (len(inputs.bands),) if about.per_band else ()
                assert array.shape == (*bands, inputs.grid.rows, inputs.grid.columns), name
                assert array.dtype.kind in ("fiu" if about.dtype.startswith("float") else "iub"), name
                assert about.may_be_missing or np.all(np.isfinite(array)), f"{name}: not finite where inputs are"
                there = array[~np.isnan(array)] if array.dtype.kind == "f" else array
                assert np.all((there >= about.limits[0]) & (there <= about.limits[1])), name

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
            changed = any(not np.array_equal(mixed[each], whole[each], equal_nan=True) for each in whole)
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
        pytest.fail(f"needs {lacking}: no variable of the engine; geometry: {', '.join(GEOMETRY)}")
    needed = {name: fields[name].view() for name in provider.needs}
    for values in needed.values():
        values.flags.writeable = False
    return provider.values(needed, time_s)
