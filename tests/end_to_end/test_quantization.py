"""Cubes with rounded numbers: the error is stated, bounded, certified, and verified."""

import json

import numpy as np
import pytest
from cheap import CHEAP, NARROW

from hcss_twin import Scenario, make_plan, open_cube, simulate
from hcss_twin.core.errors import CertificateWarning, ScenarioError
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan import output
from hcss_twin.plan.description import describe
from hcss_twin.reports.plan_text import plan_text

SMALL = CHEAP | {
    "bands": NARROW,
    "image.rows": 64,
    "image.columns": 80,
    "frames.count": 2,
    "output.variables": ["all"],
    "output.compression": 1,
}


def planned(quantization=0.0, **changes):
    overrides = {key.replace("__", "."): value for key, value in changes.items()}
    return make_plan(Scenario.load("stratus", SMALL | {"output.quantization": quantization} | overrides))


@pytest.fixture(scope="module")
def cubes(tmp_path_factory):
    """Paths of the same cube in full and rounded."""
    folder = tmp_path_factory.mktemp("cubes")
    return run(planned(), folder / "full.nc"), run(planned(3e-4), folder / "rounded.nc")


def test_every_number_is_within_the_error_that_its_variable_states_and_masks_are_the_same(cubes):
    with open_cube(cubes[0]) as full, open_cube(cubes[1]) as rounded:
        assert set(rounded.data_vars) == set(full.data_vars)
        for name, exact in full.data_vars.items():
            found = rounded[name]
            if exact.dtype != np.float32:
                assert "quantization" not in found.attrs
                np.testing.assert_array_equal(found, exact)
                continue
            bound = float(found.attrs["quantization_maximum_relative_error"])
            temperature = found.attrs["units"] == "K"
            assert bound <= 3e-4 / (16 if temperature else 1) < 2 * bound
            assert found.attrs["quantization_nsb"] == (15 if temperature else 11)
            a, b = (each.to_numpy().astype(np.float64) for each in (exact, found))
            np.testing.assert_array_equal(np.isnan(a), np.isnan(b))
            error = np.nanmax(np.abs(b - a) / np.where(a == 0, 1, a))
            assert error <= bound
            # A fraction of 0 or 1 needs no rounding; radiance does.
            assert name != "radiance" or error > 0.3 * bound
        info = rounded[rounded.radiance.attrs["quantization"]]
        assert info.attrs["algorithm"] == "bitround"
        assert info.attrs["implementation"].startswith("hcss_twin version ")


def test_rounded_numbers_compress_better(cubes):
    full, rounded = (path.stat().st_size for path in cubes)
    assert rounded < 0.75 * full


def test_a_rounded_and_compressed_cube_verifies_to_the_bit(cubes):
    found = verify_cube(cubes[1])
    assert found.verdict is Verdict.IDENTICAL


def test_the_certificate_is_about_the_rounded_numbers(cubes):
    with open_cube(cubes[0]) as full, open_cube(cubes[1]) as rounded:
        achieved = [json.loads(cube.attrs["hcss_accuracy_achieved"])["lwir"] for cube in (full, rounded)]
        assert all(cube.attrs["hcss_certificate"].startswith("computed as specified") for cube in (full, rounded))
    # Of 24 pixels some are rounded by more than half of the bound, and the tables err by less.
    assert achieved[0] < 1e-4 < 1.2e-4 < achieved[1]


def test_rounding_beyond_the_accuracy_would_fail_the_certificate(monkeypatch):
    monkeypatch.setattr(output, "LARGEST_SHARE", 20.0)
    with pytest.warns(CertificateWarning, match="NOT as specified"):
        simulate(planned(1e-2).scenario).close()


def test_rounding_by_more_than_its_share_of_the_accuracy_is_refused_with_the_closest_choice():
    with pytest.raises(ScenarioError, match=r"output.quantization: 0.0006 .*closest valid choice is 0.0003"):
        planned(6e-4)
    # The closest valid choice itself is one.
    assert planned(output.LARGEST_SHARE * 1e-3).variables[0].significant_bits == 11
    assert planned(3e-4).variables[0].significant_bits == 11
    assert planned(6e-4, accuracy=1e-2).variables[0].significant_bits == 10


def test_the_plan_tells_how_far_numbers_are_rounded_and_whether_that_saves_anything():
    text = plan_text(planned(3e-4))
    assert "numbers are rounded to 11 bits of the mantissa: relative error up to 0.00024\n" in text
    assert "temperatures are rounded to 15 bits of the mantissa: relative error up to 1.5e-05\n" in text
    told = describe(planned(3e-4))["quantization"]
    assert told["radiance"] == {"bits": 11, "relative_error": 2.0**-12}
    assert "cloud_mask" not in told
    plain = " ".join(plan_text(planned(3e-4, output__compression=0)).split())
    assert "saves nothing without output.compression" in plain
    assert "rounded" not in plan_text(planned())
    assert describe(planned())["quantization"] == {}


def test_more_digits_than_single_precision_has_round_nothing():
    assert all(spec.significant_bits is None for spec in planned(1e-9).variables)
