"""Fall streaks: the kit, windows, cover, the parabola, spectra, time."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import CloudGeneratorContract, assert_registered, sample_cloud_inputs
from hcss_skies.fall_streaks.generator import FallStreaks
from hcss_skies.fall_streaks.parameters import FallStreakParameters
from hcss_skies.fall_streaks.streaks import Fall, Lattices, ice_above, stencils, variances

from hcss_twin.providers import Grid, Motion


def make(pixel_m=100.0, size=128, *, coverage=0.5, seed=1, mode="frame", motion=None, **parameters):
    inputs = sample_cloud_inputs(coverage, seed)
    layer = replace(inputs.layer, base_m=7e3, top_m=11e3, thickness_min_m=50.0, coverage_mode=mode)
    motion = motion or Motion(0.0, (20.0, 8.0), 1800.0, 1.0)
    inputs = replace(inputs, layer=layer, grid=Grid(size, size, pixel_m), motion=motion)
    return FallStreaks(inputs, FallStreakParameters(**parameters))


class TestOfTheFrame(CloudGeneratorContract):
    def make_provider(self, inputs):
        return FallStreaks(inputs, FallStreakParameters())


class TestOfTheSky(CloudGeneratorContract):
    """Pixels of 30 km, so that a frame has many independent clouds."""

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = sample_cloud_inputs(coverage, seed)
        return replace(inputs, grid=Grid(48, 64, 30e3), layer=replace(inputs.layer, coverage_mode="field"))

    def make_provider(self, inputs):
        return FallStreaks(inputs, FallStreakParameters())


def test_it_is_registered():
    assert_registered("clouds", "fall-streaks", "hcss-skies")


@pytest.mark.parametrize("pixel_m", [20.0, 700.0, 40e3])
def test_windows_have_the_bits_of_the_frame(pixel_m):
    clouds = make(pixel_m, 600)
    whole = clouds.thickness_m(77.0, slice(0, 600), slice(0, 600))
    for rows, columns in ((slice(500, 600), slice(3, 90)), (slice(41, 42), slice(100, 599))):
        np.testing.assert_array_equal(clouds.thickness_m(77.0, rows, columns), whole[rows, columns])


@pytest.mark.parametrize("coverage", [0.2, 0.8])
def test_the_frame_has_the_coverage_at_its_start(coverage):
    found = make(20.0, 200, coverage=coverage).thickness_m(0.0, slice(0, 200), slice(0, 200))
    assert np.mean(found > 0.0) == pytest.approx(coverage, abs=1e-3)


def test_large_frames_of_small_pixels_have_the_coverage_of_the_sky():
    """The sky's threshold is measured with large pixels and corrected."""
    found = [
        np.mean(make(1500.0, 512, mode="field", seed=seed).thickness_m(0.0, slice(0, 512), slice(0, 512)) > 0.0)
        for seed in range(4)
    ]
    assert np.mean(found) == pytest.approx(0.5, abs=0.03)


def share_near_axes(found):
    """Share of gradients within 5 degrees of the axes of pixels, .111 of an isotropic sky."""
    count = near = 0
    for frame in found:
        along_y, along_x = frame[2:, 1:-1] - frame[:-2, 1:-1], frame[1:-1, 2:] - frame[1:-1, :-2]
        kept = (frame[1:-1, 1:-1] > 0.0) & (np.hypot(along_y, along_x) > 0.0)
        angle = np.degrees(np.arctan2(along_y[kept], along_x[kept])) % 90.0
        count, near = count + angle.size, near + np.count_nonzero(np.minimum(angle, 90.0 - angle) < 5.0)
    return near / count


@pytest.mark.parametrize(("pixel_m", "size"), [(100.0, 384), (1000.0, 128)])
def test_streaks_of_many_seeds_lie_along_no_axis_of_the_image_whatever_the_wind(pixel_m, size):
    wind = Motion(0.0, (20.0, 0.0), np.inf, 1.0)
    by_seed, along_rows = (
        share_near_axes(
            make(pixel_m, size, mode="field", seed=seed, motion=wind, **more).thickness_m(
                0.0, slice(0, size), slice(0, size)
            )
            for seed in range(24)
        )
        for more in ({}, {"shear_from": 270.0})
    )
    assert by_seed <= 0.13
    assert along_rows > by_seed + 0.01


def test_ice_is_displaced_along_a_parabola():
    depth = np.array([0.0, 1000.0, 2000.0])
    straight = Fall(4000.0, 5e-3, 0.5, 0.0, (0.6, 0.8)).displacement_m(depth)
    np.testing.assert_allclose(straight, np.outer([0.6, 0.8], 5e-3 * depth**2 / (2.0 * 0.5)))


def test_turning_shear_bends_streaks_as_the_integral_of_the_wind():
    fall = Fall(4000.0, 5e-3, 0.5, 1.0, (0.0, -1.0))
    depth = np.linspace(0.0, 4000.0, 20001)
    angle, step = depth / 4000.0, depth[1]
    velocity = np.cumsum(5e-3 * np.exp(1j * angle)) * step
    expected = (np.cumsum(velocity) * step)[-1] / 0.5
    across, along = fall.displacement_m(depth)[:, -1]
    assert -along == pytest.approx(expected.real, rel=1e-3)
    assert abs(across) == pytest.approx(expected.imag, rel=1e-3)


def test_a_cell_leaves_its_ice_along_the_parabola():
    """The centre of the ice of stencils is the mean displacement over the ice of the column, in closed form."""
    fall = Fall(4000.0, 5e-3, 0.6, 0.0, (0.0, -1.0))
    spacings = 12500.0 * 0.5 ** np.arange(8)
    found = sum(s * np.sum(of[:, 1] * of[:, 2]) for s, of in zip(spacings, stencils(fall, spacings), strict=True))
    mean_square = 1.5 * (1.0 / 3.0 - 1.0 / 5.0)  # of the share of the depth, weighted by 1 - share^2
    assert found == pytest.approx(5e-3 * 4000.0**2 / (2.0 * 0.6) * mean_square, rel=2e-3)


def test_all_ice_is_in_the_stencils_and_above_the_base():
    of = stencils(Fall(4000.0, 5e-3, 0.6, 0.9, (0.0, -1.0)), 12500.0 * 0.5 ** np.arange(8))
    assert sum(entries[:, 2].sum() for entries in of) == pytest.approx(1.0)
    assert ice_above(np.array([0.0, 1.0])).tolist() == [0.0, 1.0]


def spectrum_exponent(field, axis, low, high):
    """Exponent of the power spectrum along an axis between two wavenumbers, cycles per pixel."""
    size = field.shape[axis]
    window = np.hanning(size) if axis else np.hanning(size)[:, None]
    power = (abs(np.fft.rfft((field - field.mean()) * window, axis=axis)) ** 2).mean(axis=1 - axis)
    k = np.fft.rfftfreq(size)
    chosen = (k > low) & (k < high)
    return np.polyfit(np.log(k[chosen]), np.log(power[chosen]), 1)[0]


def logarithm(shear, seed):
    """Logarithm of ice water path (512, 512) at 400 m, wind along x, without generating cells and bends."""
    outer_m, count = 50e3, 9
    spacings = 8.0 * outer_m / 4.0 * 0.5 ** np.arange(count)
    fall = Fall(4000.0, shear, 0.6, 0.0, (0.0, -1.0))
    y, x = np.meshgrid(*[400.0 * np.arange(512.0)] * 2, indexing="ij")
    lattices = Lattices(spacings, stencils(fall, spacings), variances(outer_m, 0.0), seed)
    return np.log(lattices.integral(y, x, np.nan).astype(float))


def test_without_shear_the_spectrum_has_the_exponent_of_the_generating_level():
    found = [spectrum_exponent(logarithm(0.0, seed), axis, 0.016, 0.1) for seed in range(3) for axis in (0, 1)]
    assert np.mean(found) == pytest.approx(-5.0 / 3.0, abs=0.2)


def test_streaks_are_smooth_along_the_shear():
    field = logarithm(5e-3, 1)
    rough_x, rough_y = (np.mean(np.diff(field, axis=axis) ** 2) for axis in (1, 0))
    assert rough_x < 0.5 * rough_y


def test_frozen_clouds_move_and_do_not_change():
    clouds = make(100.0, motion=Motion(0.0, (20.0, 10.0), np.inf, 1.0))
    start, later = (clouds.thickness_m(t, slice(0, 128), slice(0, 128)) for t in (0.0, 100.0))
    np.testing.assert_allclose(later[10:, 20:], start[:-10, :-20], atol=0.5)


def test_small_streaks_live_shorter():
    """Minutes change the texture of an evolving sky more than its large parts."""
    clouds = make(100.0, 256, motion=Motion(0.0, (0.0, 0.0), 1800.0, 1.0), coverage=1.0)
    start, later = (np.log(clouds.thickness_m(t, slice(0, 256), slice(0, 256)).astype(float)) for t in (0.0, 240.0))

    def correlation(a, b):
        return np.corrcoef(a.ravel(), b.ravel())[0, 1]

    fine = correlation(np.diff(start, axis=0), np.diff(later, axis=0))
    assert fine < correlation(start, later) - 0.1
    assert correlation(start, later) > 0.8


def test_seeds_differ_and_the_layer_limits_thickness():
    one, other = (make(seed=seed).thickness_m(0.0, slice(0, 128), slice(0, 128)) for seed in (1, 2))
    assert not np.array_equal(one, other)
    assert one.max() == 4000.0
    assert one[one > 0.0].min() >= 50.0


def test_keys_may_be_text_with_a_unit():
    given = FallStreakParameters(fall_speed="2.16 km/h", outer_scale="30000 m", turning="100 mrad")
    assert (given.fall_speed, given.outer_scale) == (pytest.approx(0.6), 30.0)
    assert given.turning == pytest.approx(5.72958, rel=1e-5)
