"""Cubes with changed names, types, dimensions, values and attributes: read, or refused by an error of the package."""

import shutil
from contextlib import suppress

import numpy as np
import pytest
from cube_changes import bad, good, read_all, write_all
from hang import limited
from hcss_evaluate import evaluate
from hcss_export import export_cube
from input_files import small_stratus

from hcss_twin import CubeError, HcssError, brightness_temperature, open_cube
from hcss_twin.engine.simulate import run
from hcss_twin.plan.make_plan import make_plan


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    only = {"image.rows": 32, "image.columns": 32, "frames.count": 1, "output.certificate": 0}
    return run(make_plan(small_stratus(**only)), tmp_path_factory.mktemp("original") / "original.nc")


@pytest.fixture
def cube(original, tmp_path):
    return original, shutil.copy(original, tmp_path / "c.nc")


def use(original, path):
    export_cube(path, "png", path.parent, variable="radiance", replace=True)
    brightness_temperature(path)
    evaluate(original, path)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seeds", [range(3), pytest.param(range(3, 500), marks=pytest.mark.campaign)])
def test_only_errors_of_the_package_escape(cube, seeds):
    original, path = cube
    for seed in seeds:
        shutil.copy(original, path)
        bad(path, seed)
        for reader in (lambda: use(original, path), lambda: evaluate(path, original)):
            with limited(), suppress(HcssError):
                reader()


@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(2, 500), marks=pytest.mark.campaign)])
def test_cubes_that_have_more_or_less_than_needed_are_read(cube, seeds):
    original, path = cube
    with open_cube(original) as made:
        radiance = made.radiance.values
    for seed in seeds:
        shutil.copy(original, path)
        good(path, seed)
        with open_cube(path) as changed:
            np.testing.assert_array_equal(changed.radiance.values, radiance)
        brightness_temperature(path)


def _texts(dimensions, variables):
    variables["y"][0], variables["y"][2], variables["y"][3] = str, np.full(32, "a", dtype=object), {}


def _one_column(dimensions, variables):
    dimensions["bound"] = 1
    variables["wavelength_bounds"][2] = variables["wavelength_bounds"][2][:, :1]


def _turned(dimensions, variables):
    variables["wavelength_bounds"][1] = variables["wavelength_bounds"][1][::-1]
    variables["wavelength_bounds"][2] = variables["wavelength_bounds"][2].T


def _empty(dimensions, variables):
    dimensions["time"] = 0
    for each in variables.values():
        if "time" in each[1]:
            each[2] = each[2][:0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_texts, r"y has the type .*; allowed: float64"),
        (_one_column, r"dimension bound has the size 1; allowed: 2"),
        (_turned, r"wavelength_bounds has the dimensions \(bound, band\); allowed: \(band, bound\)"),
        (_empty, r"dimension time has the size 0; allowed: 1 or more"),
    ],
)
def test_the_variable_that_no_cube_has_is_named(cube, change, message):
    original, path = cube
    dimensions, variables, attributes = read_all(path)
    change(dimensions, variables)
    write_all(path, dimensions, variables, attributes)
    for reader in (open_cube, brightness_temperature, lambda each: evaluate(original, each)):
        with pytest.raises(CubeError, match=rf"c\.nc: {message}"):
            reader(path)
