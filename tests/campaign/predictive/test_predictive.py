"""The committed predictive coverage: its counts, what it measures, and numbers that real images show again."""

import json
import os
from pathlib import Path

import numpy as np
import predictive
import pytest
from hcss_evaluate.matching.structure import CloudImage

FOUND = json.loads(predictive.RESULTS.read_text(encoding="utf-8"))


@pytest.mark.parametrize("kind", [kind for kind in predictive.KINDS_OF_IMAGES if kind in FOUND])
def test_fractions_are_counts_of_the_committed_rows_and_no_image_is_fitted_and_predicted(kind):
    found = FOUND[kind]
    assert predictive.summarise(found) == found["summary"]
    inside = [
        low <= value <= high
        for row in found["rows"]
        for value, low, high in zip(row["measured"], found["predicted"]["low"], found["predicted"]["high"], strict=True)
    ]
    total = sum(found["summary"][name]["inside"] * len(found["rows"]) for name in predictive.NAMES)
    assert sum(inside) == pytest.approx(total, abs=0.01 * len(predictive.NAMES))
    fitted = {predictive.whole(name) for name in found["fitted"]}
    assert len(fitted) == len(found["fitted"]) == predictive.FITTED
    assert not fitted & {predictive.whole(row["image"]) for row in found["rows"]}


@pytest.mark.parametrize("kind", ["seviri", "goes"])
def test_real_images_show_the_numbers_of_the_results(kind):
    folder = Path(os.environ.get("HCSS_SAMPLE_DATA", ""))
    if not (folder / {"seviri": "seviri", "goes": "images"}[kind]).is_dir() or folder == Path():
        pytest.skip("HCSS_SAMPLE_DATA names no folder with these images")
    images = predictive.KINDS_OF_IMAGES[kind](folder)
    if kind not in FOUND:
        pytest.skip("not in the results")
    rows = FOUND[kind]["rows"]
    assert predictive.split(list(images)) == (FOUND[kind]["fitted"], [row["image"] for row in rows])
    for row in rows[:: max(1, len(rows) // 8)]:
        np.testing.assert_allclose(predictive.measured(images[row["image"]]), row["measured"], atol=2e-6)


def test_the_page_has_the_table_of_the_results():
    page = Path(__file__).parents[3] / "docs" / "development" / "uncertainty.md"
    assert predictive.table(FOUND) in page.read_text(encoding="utf-8")


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
