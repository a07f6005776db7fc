"""The committed predictive coverage is that of its page; what it measures and counts."""

from pathlib import Path

import numpy as np
import predictive
import pytest
from hcss_evaluate.matching.structure import CloudImage


def test_the_page_has_the_table_of_the_results():
    page = Path(__file__).parents[2] / "docs" / "development" / "uncertainty.md"
    assert predictive.table(predictive.read()) in page.read_text(encoding="utf-8")


def test_the_factor_is_that_of_normal_intervals_that_are_too_narrow():
    rng = np.random.default_rng(0)
    numbers, z = len(predictive.NAMES), 1.6448536
    for width in (0.5, 1.0, 2.0):
        rows = [{"image": str(i), "measured": rng.standard_normal(numbers).tolist()} for i in range(2000)]
        ends = {name: [side * width * z] * numbers for name, side in (("low", -1.0), ("median", 0.0), ("high", 1.0))}
        found = predictive.summarise({"rows": rows, "predicted": ends})["histogram"]
        assert found["factor"] == pytest.approx(1.0 / width, rel=0.05)
        assert found["inside"] == pytest.approx({0.5: 0.589, 1.0: 0.9, 2.0: 0.99900}[width], abs=0.01)


def test_a_wave_has_its_power_in_its_octave_and_grey_levels_their_histogram():
    size = 128
    x = np.arange(size)
    # 25 cycles per image: wavenumber .195, in the octave from .125 to .25
    wave = 128.0 + 100.0 * np.cos(2.0 * np.pi * 25.0 * (x + 0.5) / size)  # without slope
    image = CloudImage(np.tile(wave, (size, 1)).astype(np.float32), 1000.0)
    found = dict(zip(predictive.NAMES, predictive.measured(image), strict=True))
    assert found["cover"] == 1.0
    powers = [found[f"spectrum {k}"] for k in range(predictive.SPECTRAL)]
    assert np.argmax(powers) == 1
    assert max(powers[:1] + powers[2:]) < powers[1] - 2.0
    # a wave is arcsine-distributed between its ends
    edges = np.arcsin(np.linspace(-1.0, 1.0, predictive.BINS + 1)) / np.pi
    histogram = [found[f"histogram {k}"] for k in range(predictive.BINS)]
    np.testing.assert_allclose(histogram, np.diff(edges), atol=0.02)
    assert sum(histogram) == pytest.approx(1.0)
