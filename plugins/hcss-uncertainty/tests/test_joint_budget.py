"""Errors of inputs and models in one table: sums by hand."""

import json

import numpy as np
import pytest
import xarray as xr
from hcss_uncertainty.joint_budget import MODEL_ERRORS, ErrorSize, joint_budget
from hcss_uncertainty.tables import PropagationContents, budget

DIMS = ("band", "class")
GAS = {"name": "gas", "relative": 0.12, "kelvin": 4.0, "statistic": "rms"}
SEA = {"name": "sea", "relative": None, "kelvin": None}
STATED = {"clear": {"lwir": {"contributions": [GAS, SEA]}}, "stratus": {"lwir": {"contributions": [GAS]}}}


def drawn(**attributes):
    """A band with spreads of 5 % and 3 K, of which 36 % and 64 % of the variance are due to the seed."""
    classes = ["all", "clear", "thin", "thick"]
    data = {"radiance_mean": 10.0, "radiance_standard_deviation": 0.5, "brightness_temperature_standard_deviation": 3.0}
    data = {name: (DIMS, np.array([[value] * 3 + [np.nan]])) for name, value in data.items()}
    for name, share in (("radiance", 0.36), ("brightness_temperature", 0.64)):
        data[f"{name}_total"] = (("source", *DIMS), np.array([[[share] * 3 + [np.nan]]]))
        data[f"{name}_total_error"] = (("source", *DIMS), np.array([[[0.04] * 3 + [np.nan]]]))
    return xr.Dataset(data, {"band": ["lwir"], "class": classes, "source": ["seed"]}, attributes)


def test_spread_is_divided_by_variance_and_models_are_added_by_squares():
    rows = {row.kind: row for row in joint_budget(drawn(), "lwir", STATED)}
    thin = rows["thin"]
    assert (thin.parameters.relative, thin.parameters.kelvin) == pytest.approx((0.05 * 0.8, 3.0 * 0.6))
    assert (thin.seed.relative, thin.seed.kelvin) == pytest.approx((0.05 * 0.6, 3.0 * 0.8))
    assert thin.models == {"gas": ErrorSize(0.12, 4.0)}
    assert (thin.total.relative, thin.total.kelvin) == pytest.approx((0.13, 5.0))
    assert (thin.is_least, rows["clear"].is_least) == (False, True)
    assert rows["clear"].total.kelvin == pytest.approx(5.0)
    assert np.isnan(rows["thick"].parameters.kelvin)


def test_nothing_is_the_sum_where_no_model_states_anything():
    for stated in ({}, STATED):
        first = joint_budget(drawn(), "lwir", stated)[0]
        assert (first.kind, first.models) == ("all", {})
        assert np.isnan(first.total.kelvin)
        assert first.seed.kelvin == pytest.approx(2.4)
    # with two layers, a class mixes columns
    two = STATED | {"cirrus": STATED["stratus"]}
    assert joint_budget(drawn(), "lwir", two)[2].models == {}


def test_the_table_says_what_is_not_stated_and_what_is_a_lower_limit():
    plain = budget(PropagationContents(drawn()), 0)
    assert plain.header[3:] == ["models", "together"]
    assert plain.rows[0][3:] == ["not stated", "not stated"]
    joined = budget(PropagationContents(drawn()), 0, STATED)
    assert joined.header[3:] == ["gas", "sea", "together"]
    assert joined.rows[1][1:] == ["1.8 K (4 %)", "2.4 K (3 %)", "4 K (12 %)", "not stated", "at least 5 K (13 %)"]
    assert joined.rows[2][3:] == ["4 K (12 %)", "not stated", "5 K (13 %)"]
    of_file = budget(PropagationContents(drawn(**{MODEL_ERRORS: json.dumps(STATED)})), 0)
    assert of_file == joined


def test_a_part_whose_estimated_variance_is_negative_is_told_with_its_error():
    data = drawn()
    for name in ("radiance", "brightness_temperature"):
        data[f"{name}_total"][:] = 1.1  # 1 - 1.1 = -0.1 +- 0.04 of the variance is left to the inputs
    row = budget(PropagationContents(data), 0).rows[0]
    # by hand: 3 K * 0.04 ** 0.5, 5 % * 0.04 ** 0.5
    assert row[1:3] == ["not told apart from 0 (± 0.6 K, 1 %)", "3 K (5 %)"]
    for name in ("radiance", "brightness_temperature"):
        data[f"{name}_total"][:], data[f"{name}_total_error"][:] = 0.0, 0.0  # no clouds: the seed has no effect
    assert budget(PropagationContents(data), 0).rows[0][1:3] == ["3 K (5 %)", "0 K (0 %)"]
