"""Laws of the radiometer: energy, counts, range, steps, and what random numbers depend on."""

import numpy as np
import pytest
from hcss_author import sample_sensor_inputs
from scipy.ndimage import convolve

from hcss_twin.core.errors import ProviderError
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.radiometer import Radiometer

COUNTING = {"noise": "photon", "aperture_diameter": 0.1, "pixel_angle": 4e-5, "integration_time": 1e-4, "smear": False}


def radiometer(seed=1, catalog=None, **parameters):
    changes = {} if catalog is None else {"catalog": catalog}
    inputs = sample_sensor_inputs(seed, **changes)
    return Radiometer(inputs, RadiometerParameters(**parameters))


def scene(low=0.5, high=2.0):
    """Radiance that single precision represents, as that of a cube."""
    return np.random.default_rng(3).uniform(low, high, (2, 48, 64)).astype(np.float32).astype(np.float64)


def flat(value):
    return np.full((2, 48, 64), float(value))


def electrons_per_radiance(provider):
    bands = provider.worked_out["bands"].values()
    return np.array([each["electrons_per_radiance"] for each in bands])[:, None, None]


@pytest.mark.long
@pytest.mark.parametrize(
    "parameters",
    [
        {"psf": "gaussian", "psf_sigma": 2.5},
        {"psf": "airy", "aperture_diameter": 0.05, "pixel_angle": 4e-5},
        {"integration_time": 20.0},
        {"psf": "gaussian", "psf_sigma": 0.7, "integration_time": 3.3},
    ],
)
def test_blur_keeps_the_energy(parameters):
    clean = scene(0.0, 5.0)
    clean[:, 0, :] = 100.0  # at the edge, where blur could lose it
    measured = radiometer(**parameters).measure(clean, 0, 0.0).radiance
    np.testing.assert_allclose(measured.sum(axis=(1, 2)), clean.sum(axis=(1, 2)), rtol=1e-6)
    assert measured.std() < clean.std()


def test_a_flat_scene_is_not_blurred():
    for parameters in ({"psf": "gaussian", "psf_sigma": 3.0}, {"integration_time": 1.0}):
        np.testing.assert_allclose(radiometer(**parameters).measure(flat(2.0), 0, 0.0).radiance, 2.0, rtol=3e-7)


def test_without_parameters_nothing_happens():
    np.testing.assert_array_equal(radiometer().measure(scene(), 0, 0.0).radiance, scene())


@pytest.fixture
def kernel(tmp_path):
    from hcss_twin.core.catalog import Catalog

    values = np.random.default_rng(4).random((5, 7))
    np.savetxt(tmp_path / "kernel.txt", values, header="measured")
    return Catalog(base=tmp_path), values / values.sum()


def test_a_point_becomes_the_kernel_in_its_own_orientation(kernel):
    catalog, values = kernel
    point = np.zeros((2, 48, 64))
    point[:, 20, 30] = 1.0
    measured = radiometer(catalog=catalog, psf="file", psf_file="kernel.txt").measure(point, 0, 0.0).radiance
    np.testing.assert_allclose(measured[0, 18:23, 27:34], values, atol=1e-8)
    assert measured[0].sum() == pytest.approx(1.0, abs=1e-6)


def test_a_kernel_is_the_sum_over_its_pixels_up_to_the_mirrored_edges(kernel):
    catalog, values = kernel
    provider = radiometer(catalog=catalog, psf="file", psf_file="kernel.txt")
    measured = provider.measure(scene(), 0, 0.0).radiance
    expected = [convolve(each, values, mode="reflect") for each in scene()]
    np.testing.assert_allclose(measured, expected, atol=1e-6)


def test_without_shot_noise_the_mean_is_read():
    provider = radiometer(**COUNTING, shot_noise=False)
    np.testing.assert_allclose(provider.measure(scene(), 0, 0.0).radiance, scene(), rtol=3e-7)


def test_what_undershoots_below_zero_stays_and_draws_nothing():
    clean = flat(0.0)
    clean[:, 24, 32] = 50.0  # a point, which optics sharper than the pixel surround with undershoots
    provider = radiometer(**{**COUNTING, "aperture_diameter": 1.0}, psf="airy", shot_noise=True)
    blurred = radiometer(psf="airy", aperture_diameter=1.0, pixel_angle=4e-5).measure(clean, 0, 0.0).radiance
    assert blurred.min() < -0.1
    measured = provider.measure(clean, 0, 0.0).radiance
    below = blurred < 0.0
    np.testing.assert_allclose(measured[below], blurred[below], rtol=3e-7, atol=1e-12)


def test_more_electrons_than_can_be_drawn_are_an_error():
    provider = radiometer(**{**COUNTING, "integration_time": 1e4})
    with pytest.raises(ProviderError, match="electrons are expected in a pixel; allowed: up to 1e"):
        provider.measure(flat(10.0), 0, 0.0)


def test_saturation_is_exact():
    provider = radiometer(saturation_radiance={"mid": 1.0, "long": 1.5})
    measured = provider.measure(scene(), 0, 0.0)
    ends = np.array([1.0, 1.5])[:, None, None]
    np.testing.assert_array_equal(measured.radiance, np.minimum(scene(), ends))
    np.testing.assert_array_equal(measured.saturated, scene() > ends)


def test_a_full_well_holds_what_it_holds():
    provider = radiometer(**COUNTING, shot_noise=False, well_depth=1e4)
    factor = electrons_per_radiance(provider)
    measured = provider.measure(flat(1.0) * 3e4 / factor, 0, 0.0)
    np.testing.assert_allclose(measured.radiance * factor, 1e4, rtol=3e-7)
    assert np.all(measured.saturated == 1)


def test_digital_numbers_are_exact():
    provider = radiometer(bits=8, radiance_per_number=0.01, number_offset=10)
    values = np.array([-0.2, -0.101, -0.1, 0.0, 0.004, 0.0051, 1.0, 2.45, 2.454, 2.46, 9.0])
    clean = flat(0.0)
    clean[:, 0, : values.size] = values
    measured = provider.measure(clean, 0, 0.0)
    numbers = measured.digital_number[0, 0, : values.size]
    np.testing.assert_array_equal(numbers, [0, 0, 0, 10, 10, 11, 110, 255, 255, 255, 255])
    np.testing.assert_array_equal(measured.saturated[0, 0, : values.size], [2, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1])
    np.testing.assert_allclose(measured.radiance[0, 0, : values.size], (numbers - 10) * 0.01, atol=1e-7)


def test_quantisation_is_off_by_half_a_step_at_most_and_evenly():
    provider = radiometer(bits=10, saturation_radiance=3.0)
    error = provider.measure(scene(), 0, 0.0).radiance - scene()
    step = 3.0 / 1023
    assert np.abs(error).max() <= 0.5 * step * (1 + 1e-9)
    assert error.std() == pytest.approx(step / np.sqrt(12.0), rel=0.02)


@pytest.mark.parametrize(("fixed_pattern", "axes"), [("pixel", ()), ("row", (1,))])
def test_a_fixed_pattern_is_fixed(fixed_pattern, axes):
    provider = radiometer(fixed_pattern=fixed_pattern, gain_deviation=0.02, offset_radiance=0.05)
    dark = provider.measure(flat(0.0), 0, 0.0).radiance
    bright = provider.measure(flat(2.0), 7, 7.0).radiance
    later = provider.measure(flat(2.0), 8, 8.0).radiance
    np.testing.assert_array_equal(bright, later)
    gain = (bright - dark)[0] / 2.0
    detectors = gain.size if fixed_pattern == "pixel" else gain.shape[0]
    for values, deviation in ((gain - 1.0, 0.02), (dark[0], 0.05)):
        assert values.std() == pytest.approx(deviation, rel=5.0 / np.sqrt(2.0 * detectors))
        for axis in axes:
            assert np.ptp(values, axis=axis).max() < 1e-12


NOISY = {**COUNTING, "read_noise": 5.0, "gain_deviation": 0.01, "offset_electrons": 3.0}


def test_noise_of_frames_bands_and_stages_has_nothing_in_common():
    provider = radiometer(noise="ner", ner=1.0, offset_radiance=1.0)
    one, other = (provider.measure(flat(0.0), frame, 0.0).radiance for frame in (0, 1))
    pattern = radiometer(offset_radiance=1.0).measure(flat(0.0), 0, 0.0).radiance
    series = [one[0] - pattern[0], one[1] - pattern[1], other[0] - pattern[0], pattern[0], pattern[1]]
    correlation = np.corrcoef([each.ravel() for each in series])
    assert np.abs(correlation - np.eye(5)).max() < 5.0 / np.sqrt(series[0].size)


def test_one_brighter_pixel_changes_no_other():
    bright = scene()
    bright[0, 10, 11] *= 3.0
    one, other = (radiometer(**NOISY).measure(each, 4, 0.0).radiance for each in (scene(), bright))
    changed = np.argwhere(one != other)
    np.testing.assert_array_equal(changed, [[0, 10, 11]])
