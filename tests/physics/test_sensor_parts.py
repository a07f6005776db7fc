"""Laws of a sensor that measures part of an image: blur reaches so far and no farther, random numbers go by place."""

import numpy as np
import pytest
from hcss_author.samples import sample_sensor_inputs
from scipy import special

from hcss_twin.models.sensor.blur import smear_mtf
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.point_spread import airy_mtf, gaussian_mtf, line_kernel, plane_kernel
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.providers import Grid

ROWS, COLUMNS = 110, 130
CORNER = (-7, 3)
COUNTING = {
    "noise": "photon",
    "aperture_diameter": 0.1,
    "pixel_angle": 4e-5,
    "integration_time": 1e-4,
    "read_noise": 5.0,
    "dark_current": 1e5,
    "gain_deviation": 0.01,
    "offset_electrons": 3.0,
    "well_depth": 1e5,
    "bits": 12,
}


def radiometer(rows, columns, corner, **parameters):
    size_m = sample_sensor_inputs().grid.pixel_size_m
    inputs = sample_sensor_inputs(grid=Grid(rows, columns, size_m), corner=corner)
    return Radiometer(inputs, RadiometerParameters(**parameters))


def scene():
    return np.random.default_rng(3).uniform(0.5, 2.0, (2, ROWS, COLUMNS))


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"psf": "gaussian", "psf_sigma": 2.5},
        {"smear": False, "psf": "gaussian", "psf_sigma": 1.5},
        {"fixed_pattern": "row"},
    ],
)
def test_a_part_is_measured_as_in_the_whole_where_its_neighbours_are_known(parameters):
    parameters = {**COUNTING, **parameters}
    whole = radiometer(ROWS, COLUMNS, CORNER, **parameters).measure(scene(), 4, 0.0)
    first = 8, 21
    part = radiometer(80, 90, (CORNER[0] + first[0], CORNER[1] + first[1]), **parameters)
    reach = part.declares.reach_pixels
    assert 0 <= reach < 40
    inside = slice(first[0], first[0] + 80), slice(first[1], first[1] + 90)
    known = tuple(slice(reach, size - reach) for size in (80, 90))
    found = part.measure(scene()[:, *inside], 4, 0.0)
    for name in ("radiance", "digital_number", "saturated"):
        np.testing.assert_array_equal(getattr(found, name)[:, *known], getattr(whole, name)[:, *inside][:, *known])
    np.testing.assert_allclose(found.photon_rate[:, *known], whole.photon_rate[:, *inside][:, *known], rtol=1e-12)


def test_random_numbers_of_places_have_nothing_in_common():
    parts = [
        radiometer(40, 50, corner, noise="ner", ner=1.0).measure(np.zeros((2, 40, 50)), 0, 0.0).radiance[0]
        for corner in ((0, 0), (1, 0), (0, 1), (-1, -1), (4000, 0), (0, 4000))
    ]
    correlation = np.corrcoef([part.ravel() for part in parts])
    assert np.abs(correlation - np.eye(len(parts))).max() < 5.0 / np.sqrt(parts[0].size)


TRANSFERS = {
    "gaussian": lambda f: gaussian_mtf(f, 1.3),
    "sharp": lambda f: gaussian_mtf(f, 0.4),
    "wide": lambda f: gaussian_mtf(f, 40.0),
    "smear": lambda f: smear_mtf(f, 3.7),
    "none": lambda f: smear_mtf(f, 0.0),
}


@pytest.mark.parametrize("name", sorted(TRANSFERS))
def test_a_kernel_that_is_cut_has_the_transfer_it_was_made_for(name):
    kernel, cut = line_kernel(TRANSFERS[name])
    assert kernel.sum() == pytest.approx(1.0, abs=1e-12)
    assert 0.0 <= cut <= 1e-2
    assert kernel.size == 1 if name == "none" else kernel.size % 2 == 1
    frequency = np.linspace(0.0, 0.5, 41)
    place = np.arange(kernel.size) - kernel.size // 2
    found = np.cos(2.0 * np.pi * frequency[:, None] * place) @ kernel
    expected, low = TRANSFERS[name](frequency), frequency <= 0.4
    np.testing.assert_allclose(found, expected, atol=2.0 * cut + 1e-12)
    np.testing.assert_allclose(found[low], expected[low], atol=2e-3)


@pytest.mark.parametrize("name", sorted(TRANSFERS))
def test_an_edge_is_blurred_as_by_the_kernel_that_is_not_cut(name):
    kernel, _ = line_kernel(TRANSFERS[name])
    reach = max(kernel.size // 2, 300)
    # The midpoint rule of the inverse transform, whose tails fold back at 8000 pixels.
    share = (np.arange(4000) + 0.5) / 4000
    places = np.arange(-reach, reach + 1)
    whole = np.cos(np.pi * places[:, None] * share) @ TRANSFERS[name](0.5 * share) / share.size
    cut = np.pad(kernel, reach - kernel.size // 2)
    np.testing.assert_allclose(np.cumsum(cut), np.cumsum(whole), atol=4e-4)


def test_the_kernel_of_a_round_aperture_is_its_diffraction_pattern():
    # (2 J1(v) / v)^2 with v = pi r f_c, for optics that pass nothing beyond half a cycle per pixel
    cutoff = 0.4
    kernel, cut = plane_kernel(lambda y, x: airy_mtf(np.hypot(y, x), cutoff))
    assert cut <= 2e-3
    middle = kernel.shape[0] // 2
    radius = np.hypot(*np.indices((25, 25)))
    v = np.pi * radius * cutoff
    pattern = np.ones_like(v)
    pattern[v > 0] = (2.0 * special.j1(v[v > 0]) / v[v > 0]) ** 2
    pattern *= np.pi * cutoff**2 / 4.0  # its sum over the plane is 1
    found = kernel[middle : middle + 25, middle : middle + 25]
    np.testing.assert_allclose(found, pattern, atol=2.5e-3 * pattern.max())
