"""Noise of the radiometer against closed forms: the generator, normal numbers, electrons, digital numbers."""

import dataclasses

import numpy as np
import pytest
from hcss_author import sample_sensor_inputs
from scipy import ndimage, stats
from scipy.fft import dctn, idctn

from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.philox import BLOCK, LANE, fill_normals, philox
from hcss_twin.models.sensor.point_spread import mirrored_transfer, separated
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.providers import Grid

COUNTING = {"noise": "photon", "aperture_diameter": 0.1, "pixel_angle": 4e-5, "integration_time": 1e-4, "smear": False}
ROWS, COLUMNS = 500, 640


def radiometer(rows=ROWS, columns=COLUMNS, seed=1, **parameters):
    inputs = sample_sensor_inputs(seed)
    inputs = dataclasses.replace(inputs, bands=inputs.bands[:1], grid=Grid(rows, columns, inputs.grid.pixel_size_m))
    return Radiometer(inputs, RadiometerParameters(**{**COUNTING, **parameters}))


def electrons(mean, frame=0, **parameters):
    """Measured electrons of a flat scene (Y, X)."""
    provider = radiometer(**parameters)
    (factor,) = (each["electrons_per_radiance"] for each in provider.worked_out["bands"].values())
    flat = np.full((1, ROWS, COLUMNS), mean / factor)
    return provider.measure(flat, frame, 0.0).radiance[0].astype(np.float64) * factor


@pytest.mark.parametrize(
    ("given", "drawn"),  # the known answers that its authors distribute with Random123, 7 rounds
    [
        ("00000000 " * 6, "5f6fb709 0d893f64 4f121f81 4f730a48"),
        ("ffffffff " * 6, "5207ddc2 45165e59 4d8ee751 8c52f662"),
        ("243f6a88 85a308d3 13198a2e 03707344 a4093822 299f31d0", "4dfccaba 190a87f0 c47362ba b6b5242a"),
    ],
)
def test_the_generator_gives_the_answers_of_its_authors(given, drawn):
    found = philox(*(np.uint64(int(each, 16)) for each in given.split()))
    assert [f"{int(each):08x}" for each in found] == drawn.split()


def test_normal_numbers_are_those_of_box_and_muller():
    row, block, key = -3, -2, 0x1234567890ABCDEF
    numbers = np.empty(1000 * BLOCK, np.float32)
    fill_normals(numbers, row, block, np.uint64(key))
    for index in (0, 1, 2, 5, 999):
        for lane in (0, 7, LANE - 1):
            counter = ((block + index) * LANE + lane) % 2**32, row % 2**32, 0, 0
            words = philox(*map(np.uint64, (*counter, key % 2**32, key >> 32)))
            for first in (0, 2):
                u = (int(words[first] >> 1) + 0.5) / 2**31
                angle = np.pi * np.int64(words[first + 1]).astype(np.int32) / 2**31
                expected = np.sqrt(-2.0 * np.log(u)) * np.array([np.sin(angle), np.cos(angle)])
                own = numbers[index * BLOCK :][[first * LANE + lane, (first + 1) * LANE + lane]]
                np.testing.assert_allclose(own, expected, atol=1e-5)
    assert stats.kstest(numbers, "norm").pvalue > 1e-3


@pytest.mark.parametrize("mean", [0.4, 9.9, 10.0, 30.0, 99.0, 101.0, 400.0, 3e4])
def test_counted_electrons_have_the_distribution_of_poisson(mean):
    drawn = np.round(electrons(mean, frame=3)).ravel().astype(int)
    low, high = stats.poisson.ppf([1e-4, 1 - 1e-4], mean).astype(int)
    expected = stats.poisson.pmf(np.arange(low, high + 1), mean) * drawn.size
    found = np.bincount(drawn, minlength=high + 1)[low : high + 1]
    usual = expected > 10
    chi_squared = np.sum((found - expected)[usual] ** 2 / expected[usual])
    assert stats.chi2.sf(chi_squared, np.count_nonzero(usual)) > 1e-3


@pytest.mark.parametrize(("mean", "dark", "read"), [(20.0, 0.0, 4.0), (150.0, 0.0, 9.0), (300.0, 200.0, 0.0)])
def test_mean_variance_and_skewness_are_those_of_electrons_and_reading(mean, dark, read):
    # cumulants of independent numbers add: all of Poisson are its mean, normal numbers have two
    parameters = {"dark_current": dark / COUNTING["integration_time"], "read_noise": read}
    drawn = np.stack([electrons(mean, frame, **parameters) for frame in range(8)]).ravel()
    variance, count = mean + dark + read**2, drawn.size
    assert drawn.mean() == pytest.approx(mean, abs=4.0 * np.sqrt(variance / count))
    assert drawn.var() == pytest.approx(variance, rel=4.0 * np.sqrt(2.0 / count) + 1e-4)
    assert stats.skew(drawn) == pytest.approx((mean + dark) / variance**1.5, abs=4.0 * np.sqrt(6.0 / count))


def test_noise_of_pixels_frames_and_seeds_is_not_correlated():
    first = electrons(1000.0, read_noise=5.0)
    others = [electrons(1000.0, frame=1, read_noise=5.0), electrons(1000.0, seed=2, read_noise=5.0)]
    for lag in ((0, 1), (1, 0), (1, 1), (0, LANE), (0, 2 * LANE), (0, BLOCK), (7, 3)):
        others.append(np.roll(first, lag, axis=(0, 1)))
    scaled = [(each - each.mean()) / each.std() for each in (first, *others)]
    for one in scaled[1:]:
        assert abs(np.mean(scaled[0] * one)) < 5.0 / np.sqrt(one.size)
        # nor are their sizes
        assert abs(np.mean((scaled[0] ** 2 - 1.0) * (one**2 - 1.0)) / 2.0) < 5.0 / np.sqrt(one.size)


def test_radiance_from_digital_numbers_closes_within_the_noise():
    parameters = {"dark_current": 1e6, "read_noise": 20.0, "bits": 14, "well_depth": 2e5, "number_offset": 50}
    provider = radiometer(**parameters)
    (band,) = provider.worked_out["bands"].values()
    true = np.linspace(0.2, 0.8, COLUMNS) * 1e5 / band["electrons_per_radiance"]
    measured = provider.measure(np.broadcast_to(true, (1, ROWS, COLUMNS)), 0, 0.0)
    signal = (measured.digital_number[0] - 50.0) * band["signal_per_number"] - 1e6 * COUNTING["integration_time"]
    radiance = signal / band["electrons_per_radiance"]
    np.testing.assert_allclose(measured.radiance[0], radiance, rtol=1e-6, atol=1e-6 * true[0])
    counted = true * band["electrons_per_radiance"] + 100.0
    variance = (counted + 20.0**2 + band["signal_per_number"] ** 2 / 12.0) / band["electrons_per_radiance"] ** 2
    off = (radiance - true) / np.sqrt(variance)
    assert abs(off.mean()) < 4.0 / np.sqrt(off.size)
    assert off.var() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / off.size))
    assert not measured.saturated.any()


def test_kernels_in_turn_are_the_sum_of_their_separated_terms():
    random = np.random.default_rng(1)
    plane, line = random.random((5, 7)), random.random((1, 3))
    down, across = separated([plane / plane.sum(), line / line.sum()], 100)
    found = sum(np.outer(one, other) for one, other in zip(down, across, strict=True))
    expected = np.stack([np.convolve(row, line[0]) for row in plane]) / plane.sum() / line.sum()
    assert np.abs(found - expected).sum() < 1e-6
    assert separated([plane], 30) is None


def test_factors_of_the_cosine_transform_are_the_convolution_of_the_mirror_image():
    random = np.random.default_rng(5)
    image, half, line = random.random((23, 17)), random.random((31, 4)), random.random(3)
    plane = np.concatenate((half[:, :0:-1], half), axis=1)
    plane = plane + plane[::-1]  # larger than the image
    kernels = [plane, np.concatenate((line[:0:-1], line))[None, :]]
    found = idctn(dctn(image) * mirrored_transfer(kernels, image.shape))
    expected = ndimage.convolve(ndimage.convolve(image, kernels[0], mode="reflect"), kernels[1], mode="reflect")
    np.testing.assert_allclose(found, expected, rtol=1e-12)
