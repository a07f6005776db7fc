"""Stages of detectors: the kit, moments and closed forms."""

import numpy as np
import pytest
from hcss_author import SensorContract, assert_registered
from hcss_payload.stages import bad_pixels, detector_drift, integration, non_linearity, stray_light

from hcss_twin import ScenarioError
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Grid, Points, SensorBand, SensorInputs

BAND = SensorBand("lwir", np.array([8.0, 12.0]), np.array([1.0, 1.0]))


def inputs(rows=64, columns=80, corner=(0, 0), speed=0.0, scene=None, bands=(BAND,)):
    more = {} if scene is None else {"scene_at": scene}
    return SensorInputs(bands, Grid(rows, columns, 10.0), speed, 1.0, 7, Catalog(), corner, **more)


def flat(value, rows=64, columns=80):
    return np.full((1, rows, columns), value)


class TestBadPixels(SensorContract):
    def make_provider(self, inputs):
        return bad_pixels.BadPixels(
            inputs, bad_pixels.Parameters(dead=0.05, hot=0.05, blinking=0.05, offset_radiance=1)
        )


class TestDetectorDrift(SensorContract):
    def make_provider(self, inputs):
        return detector_drift.DetectorDrift(inputs, detector_drift.Parameters(rms_radiance=0.1, drift_radiance=0.1))


class TestNonLinearity(SensorContract):
    def make_provider(self, inputs):
        return non_linearity.NonLinearity(inputs, non_linearity.Parameters(full_radiance=50.0))


class TestStrayLight(SensorContract):
    def make_provider(self, inputs):
        return stray_light.StrayLight(inputs, stray_light.Parameters(ghost=0.01))


class TestIntegration(SensorContract):
    def make_provider(self, inputs):
        return integration.Integration(inputs, integration.Parameters(stages=2, line_time=0.01))


@pytest.mark.parametrize("name", ["bad-pixels", "detector-drift", "integration", "non-linearity", "stray-light"])
def test_is_found_when_installed(name):
    assert_registered("sensors", name, distribution="hcss-payload")


def test_shares_of_bad_pixels_and_of_their_time_are_those_given():
    parameters = bad_pixels.Parameters(dead=0.02, hot=0.03, blinking=0.1, offset_radiance=2.0, dwell_time=4.0)
    sensor = bad_pixels.BadPixels(inputs(300, 400), parameters)
    scene, times = flat(10.0, 300, 400), np.arange(0.0, 60.0, 0.5)
    frames = np.array([sensor.measure(scene, 0, float(time)).radiance[0] for time in times])
    always = np.all(frames == frames[0], axis=0)
    assert np.mean(always & (frames[0] == 0.0)) == pytest.approx(0.02, rel=0.1)
    assert np.mean(always & (frames[0] == 12.0)) == pytest.approx(0.03, rel=0.1)
    assert np.mean(always & (frames[0] == 10.0)) == pytest.approx(0.85, rel=0.01)
    blinking = frames[:, ~always]
    assert blinking.shape[1] / always.size == pytest.approx(0.1, rel=0.05)
    assert np.mean(blinking == 12.0) == pytest.approx(0.5, abs=0.01)
    # One change in a dwell time of 8 steps, on average.
    assert np.mean(np.diff(blinking, axis=0) != 0.0) == pytest.approx(1.0 / 8.0, rel=0.03)


def test_the_power_of_noise_falls_with_frequency_as_given():
    parameters = detector_drift.Parameters(rms_radiance=0.3, lowest=0.05, highest=3.2, exponent=1.0)
    sensor = detector_drift.DetectorDrift(inputs(12, 12), parameters)
    step, count = 0.1, 2**12
    series = np.array([sensor.offset("lwir", step * number) for number in range(count)]).reshape(count, -1)
    assert np.mean(series**2) == pytest.approx(0.09, rel=0.02)
    assert abs(np.mean(series)) < 0.005
    window = np.hanning(count)[:, None]
    power = 2.0 * np.mean(np.abs(np.fft.rfft(series * window, axis=0)) ** 2, axis=1) / np.sum(window**2) / count
    frequency = np.fft.rfftfreq(count, step)
    # Six octaves with equal shares for 1/f.
    for octave in range(1, 5):
        inside = (frequency >= 0.05 * 2.0**octave) & (frequency < 0.1 * 2.0**octave)
        assert power[inside].sum() == pytest.approx(0.09 / 6.0, rel=0.1)
    apart = np.corrcoef(series[:, 0], series[:, 1])[0, 1]
    assert abs(apart) < 0.5


def test_drift_grows_with_time_and_columns_share_it():
    parameters = detector_drift.Parameters(rms_radiance=0.0, drift_radiance=0.2, detectors="column")
    sensor = detector_drift.DetectorDrift(inputs(4, 4000), parameters)
    first, later = (sensor.measure(flat(0.0, 4, 4000), 0, time).radiance[0] for time in (3600.0, 7200.0))
    assert np.ptp(first, axis=0).max() == 0.0
    assert first[0].std() == pytest.approx(0.2, rel=0.05)
    assert later == pytest.approx(2.0 * first)


def test_non_linearity_is_largest_in_the_middle_and_zero_at_both_ends():
    sensor = non_linearity.NonLinearity(inputs(), non_linearity.Parameters(full_radiance=40.0, quadratic=0.02))
    radiance = np.linspace(-4.0, 44.0, 4801).reshape(1, 1, -1)
    apparent = sensor.measure(radiance, 0, 0.0).radiance
    departure = (apparent - radiance).ravel()
    at = np.interp([0.0, 20.0, 40.0], radiance.ravel(), departure)
    assert at == pytest.approx([0.0, 0.02 * 40.0, 0.0], abs=1e-9)
    inside = (radiance.ravel() >= 0.0) & (radiance.ravel() <= 40.0)
    assert np.abs(departure[inside]).max() == pytest.approx(0.8)
    assert np.all(np.diff(apparent.ravel()) > 0.0)


def test_stray_light_keeps_the_mean_and_gives_the_glare_index():
    sensor = stray_light.StrayLight(inputs(101, 101), stray_light.Parameters(veil=0.03, ghost=0.02))
    scene = np.random.default_rng(1).random((1, 101, 101))
    assert sensor.measure(scene, 0, 0.0).radiance.mean() == pytest.approx(scene.mean())
    assert sensor.measure(flat(3.0, 101, 101), 0, 0.0).radiance == pytest.approx(3.0)
    white = flat(1.0, 101, 101)
    white[:, 49:52, 49:52] = 0.0
    assert sensor.measure(white, 0, 0.0).radiance[0, 50, 50] == pytest.approx(0.03, rel=2e-3)
    spot = flat(0.0, 101, 101)
    spot[0, 10, 20] = 1.0
    assert sensor.measure(spot, 0, 0.0).radiance[0, 90, 80] == pytest.approx(0.02, rel=0.01)


WAVE_PX = 8.0


def moving_wave(speed_px_s):
    """A wave along x below a platform that moves over it."""

    def scene(time_s, rows, columns):
        column = np.arange(columns.start, columns.stop) + speed_px_s * time_s
        values = np.cos(2.0 * np.pi * column / WAVE_PX)
        return np.broadcast_to(values, (1, rows.stop - rows.start, values.size))

    return scene


@pytest.mark.parametrize("smear", [0.5, 2.0, 3.3])
def test_smear_weakens_a_wave_by_the_sinc_of_the_integration_time(smear):
    scene = moving_wave(10.0)
    sensor = integration.Integration(
        inputs(speed=100.0, scene=scene), integration.Parameters(integration_time=smear / 10.0)
    )
    still = scene(4.0, slice(0, 64), slice(0, 80))
    measured = sensor.measure(still, 0, 4.0).radiance
    # The mean of n instants in the middles of equal parts, which tends to the sinc.
    half = np.pi * smear / WAVE_PX
    count = sensor.worked_out["exposures"]
    assert count == np.ceil(2.0 * smear)
    assert measured == pytest.approx(still * np.sin(half) / (count * np.sin(half / count)), abs=1e-12)
    assert np.sin(half) / (count * np.sin(half / count)) == pytest.approx(np.sinc(smear / WAVE_PX), rel=0.01)


def test_charges_that_move_with_the_scene_do_not_smear_and_others_do():
    scene = moving_wave(10.0)
    still, inner = scene(4.0, slice(0, 64), slice(0, 80)), slice(8, 72)
    parameters = integration.Parameters(integration_time=1e-6, exposures=1, stages=5)
    matched = integration.Integration(inputs(speed=100.0, scene=scene), parameters).measure(still, 0, 4.0).radiance
    assert matched[..., inner] == pytest.approx(still[..., inner], abs=1e-5)
    slow = parameters.model_copy(update={"line_time": 0.12})
    smeared = integration.Integration(inputs(speed=100.0, scene=scene), slow).measure(still, 0, 4.0).radiance
    half = np.pi * 0.2 / WAVE_PX  # each stage is 0.2 pixels further from where its charges are
    expected = np.sin(5.0 * half) / (5.0 * np.sin(half))
    assert smeared[..., inner] == pytest.approx(expected * still[..., inner], abs=1e-5)


def test_targets_smear_by_their_own_motion_and_not_by_that_of_their_charges():
    parameters = integration.Parameters(integration_time=0.06, stages=5)
    sensor = integration.Integration(inputs(speed=100.0), parameters)
    rest, moving = np.array([20.0, 30.0]), np.array([0.0, 100.0])
    # The first stays on the ground, which moves by 10 columns a second; the other also moves over it, along the rows.
    found = sensor.points_after(Points(rest, rest, moving, np.full(2, -10.0), np.array([[6.0, 3.0]])))
    assert found.radiance.sum() == pytest.approx(9.0)
    for number, light in ((0, 6.0), (1, 3.0)):
        row, column, weight = (values[number::2] for values in (found.row, found.column, found.radiance[0] / light))
        assert weight @ column == pytest.approx(rest[number])
        # 0.6 columns within each stage; between stages charges follow the ground.
        assert weight @ (column - rest[number]) ** 2 == pytest.approx(0.6**2 / 12.0, rel=1e-3)
        lines = 10.0 * np.arange(-2, 3)  # 0.1 s between stages
        expected = (6.0**2 / 12.0 + np.mean(lines**2)) * (number == 1)
        assert weight @ (row - rest[number]) ** 2 == pytest.approx(expected, rel=1e-3, abs=1e-12)
        assert not np.any(found.row_rate)


def test_what_does_not_fit_is_refused_by_its_key():
    with pytest.raises(ScenarioError, match=r"sensor.parameters.highest: 1 Hz with lowest = 2 Hz; allowed: 2.2 Hz"):
        detector_drift.DetectorDrift(inputs(), detector_drift.Parameters(rms_radiance=1.0, lowest=2.0, highest=1.0))
    with pytest.raises(ScenarioError, match=r"sensor.parameters.full_radiance: gives no number for band 'lwir'"):
        non_linearity.NonLinearity(inputs(), non_linearity.Parameters(full_radiance={"mwir": 1.0}))
    with pytest.raises(ScenarioError, match=r"sensor.parameters.dead: 0.6 of the pixels together"):
        bad_pixels.BadPixels(inputs(), bad_pixels.Parameters(dead=0.3, hot=0.3))
    with pytest.raises(ScenarioError, match=r"sensor.parameters.line_time: 0 s with a platform at rest"):
        integration.Integration(inputs(), integration.Parameters(stages=2))
