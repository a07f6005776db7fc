"""What JSON has no number for is null; all else stays what it is."""

import json
import math

import numpy as np
import pytest

from hcss_twin.core.json_numbers import json_number, json_value

NOT_FINITE = (math.nan, math.inf, -math.inf, np.float64("nan"))


@pytest.mark.parametrize("value", [*NOT_FINITE, None])
def test_what_is_no_finite_number_is_null(value):
    assert json_number(value) is None
    assert json_value({"a": [value, (value, {"b": value})]}) == {"a": [None, [None, {"b": None}]]}


@pytest.mark.parametrize("value", [0.0, -1.5, 1e308, 5e-324, np.float64(0.1), np.float32(0.5), 3])
def test_finite_numbers_stay_to_the_bit(value):
    assert json.loads(json.dumps(json_number(value), allow_nan=False)) == value


@pytest.mark.parametrize("value", ["nan", True, 7, 10**400, None, {"a": [1, "b", False]}, []])
def test_what_is_no_float_stays_what_it_is(value):
    assert json_value(value) == value
    assert type(json_value(value)) is type(value)


def test_a_list_has_its_numbers_and_its_gaps():
    assert json_value(np.array([1.0, np.nan, np.inf, 2.0], dtype=np.float32)) == [1.0, None, None, 2.0]
