"""Laws of surrogates with the structure "bands": smooth and rough parts as in the image, and nothing else lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import power_law
from hcss_skies.surrogate.bands import BandAmplitudes
from hcss_skies.surrogate.generator import SurrogateClouds
from hcss_skies.surrogate.parameters import SurrogateParameters
from scipy.ndimage import gaussian_filter
from scipy.stats import kurtosis

from hcss_twin.core.catalog import Catalog
from hcss_twin.laws.samples import sample_layer
from hcss_twin.providers import CloudInputs, Grid, Motion

ALL = slice(None)


def intermittent(size=128):
    """Field that is smooth in some parts and rough in others."""
    return power_law((size, size), 3.5, 1) + power_law((size, size), 1.5, 2) * np.exp(
        0.5 * power_law((size, size), 4.0, 3)
    )


def make(folder, image, structure="bands", evolution=1000.0, coverage=1.0, **parameters):
    np.save(folder / "image.npy", image)
    motion = Motion(0.0, (0.0, 0.0), evolution, 1.0)
    inputs = CloudInputs(sample_layer(coverage), Grid(*image.shape, 100.0), motion, 4, Catalog(base=folder))
    given = {"image": "image.npy", "method": "coverage", "structure": structure, **parameters}
    return SurrogateClouds(inputs, SurrogateParameters.model_validate(given))


def frame(clouds, time_s=0.0):
    return clouds.thickness_m(time_s, ALL, ALL).astype(np.float64)


def of_increments(field):
    """Kurtosis of increments at 1, 2, 4 and 8 pixels, along both axes: 3 if normal."""
    both = [[(field[lag:] - field[:-lag]).ravel(), (field[:, lag:] - field[:, :-lag]).ravel()] for lag in (1, 2, 4, 8)]
    return np.array([kurtosis(np.concatenate(increments), fisher=False) for increments in both])


def test_an_image_and_its_mirror_images_are_a_fixed_point():
    image = intermittent(64)[:40, :52]
    plane = np.pad(image, ((0, 40), (0, 52)), mode="symmetric")
    found = BandAmplitudes(image, plane.shape).impose(np.fft.rfft2(plane))
    np.testing.assert_allclose(np.fft.irfft2(found, s=plane.shape), plane, atol=2e-5 * np.ptp(plane))


def test_change_is_rarer_than_with_random_phases_as_in_the_image(tmp_path):
    image = intermittent()
    clouds = [make(tmp_path, image, structure) for structure in ("bands", "spectrum")]
    wanted = of_increments(clouds[0].template.thickness_m.astype(np.float64))
    found = [np.mean([of_increments(frame(cloud, t)) for t in 2e3 * np.arange(4)], axis=0) for cloud in clouds]
    assert wanted.min() > 6.0
    bands, spectrum = np.log(wanted / found)
    assert np.all(bands > 0.0)
    assert np.all(bands < spectrum)
    assert np.all(bands[:2] < 0.85 * spectrum[:2])


def test_imposed_amplitudes_are_those_of_the_image_in_each_octave():
    """Repeated, on a field of other amplitudes; measured in bands by Gaussians, which are not the filters."""
    image, other = intermittent(), power_law((128, 128), 2.5, 8)
    amplitudes = BandAmplitudes(image, image.shape)
    coefficients = np.fft.rfft2(other)
    for _ in range(6):
        coefficients = amplitudes.impose(coefficients)
    fields = image, other, np.fft.irfft2(coefficients, s=image.shape)
    for width in (0.7, 1.4, 2.8):
        narrow, wide = ([gaussian_filter(field, size, mode="wrap") for field in fields] for size in (width, 2 * width))
        bands = [fine - coarse for fine, coarse in zip(narrow, wide, strict=True)]
        wanted, start, found = (kurtosis(band, axis=None) for band in bands)
        assert abs(wanted - found) < 0.5 * (wanted - start)
        assert bands[2].std() == pytest.approx(bands[0].std(), rel=0.05)


def test_a_normal_field_stays_normal(tmp_path):
    clouds = make(tmp_path, power_law((128, 128), 2.0, 5))
    np.testing.assert_allclose(of_increments(frame(clouds)), 3.0, atol=0.2)


@pytest.mark.parametrize("evolution", [1000.0, np.inf])
def test_every_frame_has_exactly_the_amplitudes_of_the_image(tmp_path, evolution):
    clouds = make(tmp_path, intermittent(64), evolution=evolution, coverage=0.4)
    expected = np.sort(clouds.template.thickness_m, axis=None)
    for time_s in (0.0, 17.3, 1e9):
        np.testing.assert_array_equal(np.sort(frame(clouds, time_s), axis=None), expected)


def test_frames_follow_each_other_without_jumps(tmp_path):
    clouds = make(tmp_path, intermittent(64), coverage=0.5, evolution_exponent=0.0)
    change = [np.mean((b - a) ** 2) / (2 * a.var()) for a, b in pairwise(frame(clouds, 5.0 * n) for n in range(60))]
    assert max(change) < 0.1  # 1: independent fields


@pytest.mark.parametrize("shape", [(16, 16), (17, 40)])
def test_one_bright_pixel_and_tiny_images_give_finite_clouds(tmp_path, shape):
    image = np.zeros(shape)
    image[5, 7] = 1.0
    clouds = make(tmp_path, image, coverage=1.0 / image.size, crop_rows=shape[0], crop_columns=shape[1])
    assert np.count_nonzero(frame(clouds)) == 1
    rough = make(tmp_path, np.random.default_rng(6).normal(size=shape), crop_rows=shape[0], crop_columns=shape[1])
    assert np.all(np.isfinite(frame(rough)))
    flat = BandAmplitudes(np.full(shape, 3.0), shape).impose(np.fft.rfft2(image))
    assert np.all(np.isfinite(flat))
