"""The spectrum of jitter."""

import numpy as np
import pytest
from hcss_payload import Jitter, JitterLine, PayloadError
from scipy.integrate import trapezoid


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_every_octave_has_the_power_of_the_spectrum_within_a_tenth(exponent):
    jitter = Jitter((1e-5, 2e-5, 5e-6), 0.5, 64.0, exponent, seed=3)
    rate, count = 256.0, 2**15
    turns = jitter.at(np.arange(count) / rate)
    window = np.hanning(count)
    power = np.abs(np.fft.rfft(turns * window[:, None], axis=0)) ** 2 * 2.0 / np.sum(window**2) / rate
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    f = np.geomspace(0.5, 64.0, 100_001)
    step = frequency[1]
    for low in 0.5 * 2.0 ** np.arange(7):
        octave = (frequency >= low) & (frequency < 2.0 * low)
        inside = (f >= low) & (f <= 2.0 * low)
        share = trapezoid(f[inside] ** -exponent, f[inside]) / trapezoid(f**-exponent, f)
        assert np.sum(power[octave], axis=0) * step == pytest.approx(np.array(jitter.rms_rad) ** 2 * share, rel=0.1)
    assert np.sqrt(np.mean(turns**2, axis=0)) == pytest.approx(jitter.rms_rad, rel=0.02)


def test_jitter_is_a_function_of_time_alone():
    jitter = Jitter((1e-5, 1e-5, 1e-5), lines=(JitterLine(17.0, (1e-6, 0.0, 0.0)),))
    times = np.array([3.0, 0.1, 1e4])
    together = jitter.at(times)
    assert np.allclose(together, [jitter.at(float(time)) for time in times], rtol=0, atol=1e-18)
    assert not np.allclose(jitter.at(3.0), Jitter(jitter.rms_rad, lines=jitter.lines, seed=1).at(3.0))


def test_line_has_its_frequency_amplitude_and_phase():
    jitter = Jitter(lines=(JitterLine(4.0, (0.0, 2e-6, 0.0), np.pi / 2),))
    assert jitter.at(np.array([0.0, 0.125, 0.0625])) == pytest.approx(
        np.array([[0, 2e-6, 0], [0, -2e-6, 0], [0, 0, 0]]), abs=1e-18
    )


def test_empty_spectrum_is_refused():
    with pytest.raises(PayloadError, match=r"highest_hz: 1 Hz with lowest_hz 1 Hz; allowed: from 1\.1 Hz"):
        Jitter(lowest_hz=1.0, highest_hz=1.0)
