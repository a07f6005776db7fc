"""Clutter measures against samples, fields and motions of known law."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from hcss_dataset import DatasetError
from hcss_dataset.clutter import Tail, gradient_rms, measure_clutter, spectral_slope
from hcss_dataset.make import make_dataset
from hcss_dataset.score_command import score_command
from scipy import ndimage, stats
from sets import keys


@pytest.mark.parametrize("law", [stats.norm(), stats.expon()], ids=["normal", "exponential"])
def test_tails_of_known_laws_are_continued_to_one_in_a_hundred_million(law):
    random, shares = np.random.default_rng(2), np.array([1e-5, 1e-6, 1e-7, 1e-8])
    samples = (law.rvs(size=1_000_000, random_state=random) for _ in range(10))
    found = np.array([[tail.threshold(share) for share in shares] for tail in map(Tail.of, samples)])
    error = found / law.isf(shares) - 1.0
    assert np.abs(error.mean(axis=0)).max() < 0.05
    # a sample of a million: 1 % at 1e-5, 4 (normal) to 7 % (exponential) at 1e-8
    assert error.std(axis=0)[0] < 0.02
    assert error.std(axis=0)[-1] < 0.1


def test_the_fit_tells_a_long_tail_from_a_short_one():
    random = np.random.default_rng(4)
    long, short = (Tail.of(law.rvs(size=500_000, random_state=random)) for law in (stats.t(4), stats.uniform()))
    assert long.shape == pytest.approx(1 / 4, abs=0.12)
    assert short.shape == pytest.approx(-1.0, abs=0.12)


@pytest.mark.parametrize("values", [np.arange(500.0), np.zeros(5000)], ids=["few", "constant"])
def test_samples_without_a_tail_are_refused(values):
    with pytest.raises(DatasetError):
        Tail.of(values)


def waves(slope, size=256, seed=0):
    """A field (y, x) of the given slope, cut from one four times as large, and the transform it is made of."""
    random, whole = np.random.default_rng(seed), 2 * size
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(whole), np.fft.fftfreq(whole)))
    k[0, 0] = math.inf
    transform = np.fft.fft2(random.normal(size=(whole, whole))) * k ** (0.5 * slope)
    return np.fft.ifft2(transform).real[:size, :size], transform


@pytest.mark.parametrize("slope", [-3.5, -2.8, -2.0])
def test_slopes_of_fields_are_found(slope):
    found = [spectral_slope(waves(slope, seed=seed)[0]) for seed in range(12)]
    assert np.mean(found) == pytest.approx(slope, abs=0.1)
    assert np.std(found) < 0.25


@pytest.mark.parametrize("jitter", [0.05, 0.2])
def test_jitter_clutter_is_gradient_times_jitter(jitter):
    """Images are moved exactly, by phases of their waves; the point spread leaves none that pixels miss."""
    size, random = 128, np.random.default_rng(6)
    for slope in (-3.0, -2.0):
        _, transform = waves(slope, size)
        k = np.fft.fftfreq(2 * size)
        transform = transform * np.exp(-2.0 * (np.pi * 0.7) ** 2 * (k[:, None] ** 2 + k**2))
        still = np.fft.ifft2(transform).real[:size, :size]
        squares = []
        for _ in range(200):
            down, across = random.normal(0.0, jitter, 2)
            moved = np.fft.ifft2(transform * np.exp(-2j * np.pi * (k[:, None] * down + k * across))).real
            squares.append(np.mean((moved[:size, :size] - still)[6:-6, 6:-6] ** 2))
        spread = jitter * gradient_rms(still)
        assert math.sqrt(np.mean(squares)) == pytest.approx(spread, rel=0.05)
        # differences of neighbours, the usual gradient, miss it
        assert math.hypot(*(np.gradient(still, axis=axis).std() for axis in (0, 1))) < 0.95 * gradient_rms(still)


def frames_of_noise(count, size=128, peak=None):
    random, y = np.random.default_rng(9), np.arange(size) + 0.5
    for _ in range(count):
        image, targets = random.normal(2000.0, 20.0, (1, size, size)), []
        if peak is not None:
            spot = np.exp(-0.5 * ((y - 40.5) ** 2)[:, None] / 0.64 - 0.5 * (y - 70.5) ** 2 / 0.64)
            image = image + 20.0 * peak * spot
            targets = [{"place": [40.5, 70.5], "centroid": [40.5, 70.5], "snr": [peak], "scr": [peak], "peak": [1.0]}]
        labels = {"targets": targets, "noise": [0.02]}
        smooth = ndimage.gaussian_filter(random.normal(size=(1, size, size)), (0, 2, 2))
        yield SimpleNamespace(labels=labels, image=image, clean=smooth, radiance=lambda numbers: numbers)


def test_rates_of_a_matched_filter_in_white_noise_are_those_of_its_normal_output():
    measured = measure_clutter(frames_of_noise(40, peak=6.5))
    for point in measured.points:
        # the output of the filter is |z| of a normal z; covariances of blocks and their mean cost some per cent
        expected = stats.norm.isf(0.5 * point["false_alarms_per_pixel"])
        assert point["threshold"] == pytest.approx(expected, rel=0.08)
        assert point["threshold_deviation"] < 0.1 * expected
    rates = [point["detection_rate"] for point in measured.points]
    assert rates[0] == 1.0
    assert rates == sorted(rates, reverse=True)
    targets_excluded = 40 * (128**2 - 25**2)
    assert measured.pixels == targets_excluded


def test_the_command_states_clutter(tmp_path):
    given = keys({"image.rows": 64, "image.columns": 64, "frames.count": 1})
    given["targets"]["strength"] = {"scr": 40.0}
    make_dataset(given, tmp_path / "set", 8)
    answer = CliRunner().invoke(score_command, ["--clutter", str(tmp_path / "set"), "--jitter", "0.2", "--json"])
    assert answer.exit_code == 0, answer.output
    about = json.loads(answer.output.splitlines()[-1])
    assert about["jitter_clutter"] > 0.0
    assert about["spectral_slope"]["median"] < -1.0
    text = CliRunner().invoke(score_command, ["--clutter", "--baseline", "log", str(tmp_path / "set")]).output
    assert "log: tail of" in text
    for refused in (["--jitter", "1", "--baseline", "log"], ["--clutter", "--curve", str(tmp_path / "c.csv")]):
        assert "allowed:" in CliRunner().invoke(score_command, [*refused, str(tmp_path / "set")]).output
