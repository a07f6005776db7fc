"""Errors of inputs and models in one table: sums by hand."""

import numpy as np
import pytest
import xarray as xr

from hcss_twin.sweeps.propagation.error_budget import ErrorSize, ModelError, error_budget

DIMS = ("band", "class")


def drawn():
    """A band with two classes: spreads of 5 % and 3 K, of which 36 % and 64 % of the variance are due to the seed."""
    values = {
        "radiance_mean": [[10.0, np.nan]],
        "radiance_standard_deviation": [[0.5, np.nan]],
        "brightness_temperature_standard_deviation": [[3.0, np.nan]],
    }
    data = {name: (DIMS, np.array(each)) for name, each in values.items()}
    for name, share in (("radiance", 0.36), ("brightness_temperature", 0.64)):
        data[f"{name}_total"] = (("source", *DIMS), np.array([[[share, np.nan]]]))
    return xr.Dataset(data, {"band": ["lwir"], "class": ["all", "thick"], "source": ["seed"]})


def test_spread_is_divided_by_variance_and_models_are_added_by_squares():
    gas = ModelError("gas", {("lwir", "all"): ErrorSize(0.12, 4.0)})
    first, _ = error_budget(drawn(), "lwir", [gas])
    assert (first.parameters.relative, first.parameters.kelvin) == pytest.approx((0.05 * 0.8, 3.0 * 0.6))
    assert (first.seed.relative, first.seed.kelvin) == pytest.approx((0.05 * 0.6, 3.0 * 0.8))
    assert first.models == (ErrorSize(0.12, 4.0),)
    assert (first.total.relative, first.total.kelvin) == pytest.approx((0.13, 5.0))


def test_nothing_is_the_sum_of_what_no_model_states():
    gas = ModelError("gas", {("lwir", "all"): ErrorSize(0.12, 4.0)})
    sea = ModelError("sea", {})
    for models in ((), (gas, sea)):
        first, _ = error_budget(drawn(), "lwir", models)
        assert np.isnan(first.total.kelvin)
        assert first.seed.kelvin == pytest.approx(2.4)
    _, empty = error_budget(drawn(), "lwir", [gas])
    assert np.isnan(empty.parameters.kelvin)
