"""Rounding of the mantissa: bounded, minimal, repeatable, and what the netCDF library does on its way to the disk."""

import netCDF4
import numpy as np
import pytest

from hcss_twin.cube.writer import MANTISSA_BITS, bits_for, largest_error, round_bits

BITS = (1, 2, 7, 12, MANTISSA_BITS - 1, MANTISSA_BITS)


def numbers():
    """Every mantissa of one octave would be 8 million; these are of all octaves and both signs."""
    random = np.random.default_rng(0)
    values = np.exp(random.uniform(-80.0, 80.0, 100_000)) * random.choice([-1.0, 1.0], 100_000)
    steps = np.ldexp(1.0 + np.arange(2**12) / 2**12, random.integers(-60, 60, 2**12))
    return np.concatenate((values, steps)).astype(np.float32)


@pytest.mark.parametrize("bits", BITS)
def test_the_error_stays_within_the_bound_and_comes_near_it(bits):
    rounded = numbers()
    round_bits(rounded, bits)
    exact = numbers().astype(np.float64)
    error = np.max(np.abs(rounded - exact) / np.abs(exact))
    assert error <= largest_error(bits)
    assert bits == MANTISSA_BITS or error > 0.75 * largest_error(bits)


@pytest.mark.parametrize("bits", BITS)
def test_rounding_twice_is_rounding_once(bits):
    once = numbers()
    round_bits(once, bits)
    twice = once.copy()
    round_bits(twice, bits)
    np.testing.assert_array_equal(once, twice)


@pytest.mark.parametrize("bits", [1, 8, 22])
def test_zero_infinity_and_any_nan_stay(bits):
    special = np.array([0, 0x80000000, 0x7F800000, 0xFF800000, 0x7FC00000, 0x7FFFFFFF, 0xFFFFFFFF, 0x7F800001])
    values = special.astype(np.uint32).view(np.float32)
    round_bits(values, bits)
    np.testing.assert_array_equal(values.view(np.uint32), special)


@pytest.mark.parametrize("error", [0.05, 0.03, 1e-3, 5e-4, 4.8828125e-4, 1e-4, 1e-6, 2.0**-20, 1e-7])
def test_bits_are_the_fewest_that_keep_the_error(error):
    bits = bits_for(error)
    assert largest_error(bits) <= error
    assert bits == 1 or largest_error(bits - 1) > error


def test_all_bits_are_kept_where_single_precision_is_no_better():
    assert bits_for(1e-9) == MANTISSA_BITS
    assert largest_error(MANTISSA_BITS) == 0.0


@pytest.mark.skipif(not netCDF4.__has_quantization_support__, reason="this netCDF library cannot quantize")
@pytest.mark.parametrize("bits", [1, 7, 12, 22])
def test_the_netcdf_library_rounds_to_the_same_bits(tmp_path, bits):
    values = numbers()
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        file.createDimension("x", values.size)
        variable = file.createVariable(
            "a", "f4", ("x",), fill_value=False, significant_digits=bits, quantize_mode="BitRound"
        )
        variable[:] = values
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        file.set_auto_mask(False)
        theirs = file["a"][:]
    round_bits(values, bits)
    np.testing.assert_array_equal(values, theirs)
