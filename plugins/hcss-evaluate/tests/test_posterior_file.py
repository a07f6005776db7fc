"""The file of a posterior."""

import json
from dataclasses import asdict

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.mixing import Mixing, mixing
from hcss_evaluate.posterior.posterior_file import Diagnostic, VariogramCheck, read_posterior, write_posterior

RNG = np.random.default_rng(0)
H = RNG.uniform(0.3, 0.5, (4, 8))
TOLD = Diagnostic("Hurst exponent", "uniform:0:1", 30.0)


def write(path, **changes):
    values = {
        "title": "clouds",
        "inputs": [("image.nc", "ab" * 32)],
        "chains": {"H": H},
        "log_probability": -H,
        "diagnostics": {"H": TOLD},
        "fixed": {"gamma": 2.0},
        "priors": {"H": "uniform:0:1"},
        "seed": 7,
    }
    write_posterior(path, **(values | changes))


def test_what_is_written_is_read(tmp_path):
    path = tmp_path / "posterior.nc"
    last = np.arange(32).reshape(4, 8)
    doubt = {"image": "image.nc", "parameters": ["H"], "reason": "edge"}
    write(path, last_octave=last, attributes={"doubts": json.dumps([doubt])})
    found = read_posterior(path)
    assert set(found.chains) == {"H"}
    np.testing.assert_array_equal(found.last_octave, last)
    assert found.doubts == [doubt]
    np.testing.assert_array_equal(found.chains["H"], H)
    np.testing.assert_array_equal(found.samples["H"], H.ravel())
    assert found.fixed == {"gamma": 2.0}
    assert json.loads(found.attributes["priors"]) == {"H": "uniform:0:1"}
    assert found.attributes["seed"] == 7


def test_xarray_reads_dimensions_and_diagnostics(tmp_path):
    path = tmp_path / "posterior.nc"
    variogram = VariogramCheck(
        np.array([1, 2]), np.ones((2, 2)), np.full((2, 2), 0.1), np.array([0.05, 0.5, 0.95]), np.ones((3, 2, 2))
    )
    write(path, trace=(("H",), np.zeros((1, 4, 9))), variogram=variogram)
    with xr.open_dataset(path) as file:
        assert file.H.dims == ("chain", "draw")
        assert file.H.attrs == {
            "long_name": "Hurst exponent",
            "units": "1",
            "prior": "uniform:0:1",
            "autocorrelation_time_steps": 30.0,
            **asdict(mixing(H)),
        }
        assert file.log_probability.dims == ("chain", "draw")
        assert file.trace.dims == ("parameter", "chain", "step")
        assert file.trace.dtype == np.float32
        assert file.parameter.astype(str).values.tolist() == ["H"]
        assert file.variogram_observed.dims == ("lag", "axis")
        assert file.variogram_predicted.dims == ("quantile", "lag", "axis")
        assert file.variogram_predicted.sel(quantile=0.5, lag=2).shape == (2,)
        assert file.axis.astype(str).values.tolist() == ["x", "y"]
        assert file.attrs["converged"] == "true"
        assert file.attrs["fixed_gamma"] == 2.0
        assert file.attrs["hcss_posterior_version"] == 2


def test_several_images_have_an_axis_of_their_own(tmp_path):
    path = tmp_path / "posterior.nc"
    draws = RNG.uniform(0, 1, (4, 8, 3))
    write(path, chains={"mean_H": H, "H": draws}, diagnostics={"mean_H": TOLD, "H": TOLD})
    samples = read_posterior(path).samples
    assert samples["mean_H"].shape == (32,)
    np.testing.assert_array_equal(samples["H"], draws.reshape(32, 3))


def test_the_same_posterior_has_the_same_bytes(tmp_path):
    for name in ("a.nc", "b.nc"):
        write(tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def damage(path, attribute, value):
    with netCDF4.Dataset(path, "a") as file:
        if value is None:
            file.delncattr(attribute)
        else:
            file.setncattr(attribute, value)


@pytest.mark.parametrize(
    ("attribute", "value", "message"),
    [
        ("hcss_posterior_version", None, "not a posterior"),
        ("hcss_posterior_version", np.int32(3), "3, allowed: 1 or 2"),
        ("converged", "false", "not converged"),
    ],
)
def test_a_file_of_another_kind_is_refused(tmp_path, attribute, value, message):
    path = tmp_path / "posterior.nc"
    write(path)
    damage(path, attribute, value)
    with pytest.raises(PosteriorError, match=message):
        read_posterior(path)


def test_a_file_of_version_1_has_the_diagnostics_of_its_draws(tmp_path):
    path = tmp_path / "posterior.nc"
    write(path)
    expected = read_posterior(path)
    with netCDF4.Dataset(path, "a") as file:
        file.hcss_posterior_version = np.int32(1)
        for name in Mixing.__dataclass_fields__:
            file["H"].delncattr(name)
        file["H"].setncatts({"effective_sample_size": 1e6, "split_r_hat": 1.0})
    found = read_posterior(path)
    assert found.diagnostics == expected.diagnostics
    np.testing.assert_array_equal(found.chains["H"], H)


def test_p_values_carry_the_names_of_their_images(tmp_path):
    path = tmp_path / "posterior.nc"
    write(path)
    assert read_posterior(path).predictive_p_values == []
    write(path, attributes={"predictive_p_value": [0.25]})
    assert read_posterior(path).predictive_p_values == [("image.nc", 0.25)]
    write(path, inputs=[("a.nc", "ab"), ("b.nc", "cd")], attributes={"predictive_p_value": [0.25, 0.0]})
    assert read_posterior(path).predictive_p_values == [("a.nc", 0.25), ("b.nc", 0.0)]


def test_a_missing_or_broken_file_is_named(tmp_path):
    with pytest.raises(PosteriorError, match="no such file"):
        read_posterior(tmp_path / "none.nc")
    broken = tmp_path / "broken.nc"
    broken.write_bytes(b"no NetCDF")
    with pytest.raises(PosteriorError, match=r"broken\.nc: not a NetCDF"):
        read_posterior(broken)


def test_draws_that_are_no_numbers_are_refused(tmp_path):
    path = tmp_path / "posterior.nc"
    write(path, chains={"H": np.full((4, 8), np.nan)})
    with pytest.raises(PosteriorError, match="not finite"):
        read_posterior(path)


def test_nothing_is_left_where_the_file_cannot_be_written(tmp_path):
    with pytest.raises(PosteriorError, match="cannot write"):
        write(tmp_path / "none" / "posterior.nc")
    assert list(tmp_path.iterdir()) == []
