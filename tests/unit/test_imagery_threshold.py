"""Thresholds against brute force and against images whose clouds are known."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin.models.clouds.imagery.cloudiness import coverage_threshold, local_mean, local_threshold, otsu_threshold


def _within_class_scatter(grey: np.ndarray, split: int) -> float:
    """Sum of squares about the class means: what Otsu's method minimises, in its other form."""
    below, above = grey[grey <= split], grey[grey > split]
    return float(((below - below.mean()) ** 2).sum() + ((above - above.mean()) ** 2).sum())


@pytest.mark.parametrize("seed", range(5))
def test_otsu_minimises_the_scatter_within_classes(seed):
    random = np.random.default_rng(seed)
    sea = random.normal(60, 15, 3000)
    cloud = random.normal(150 + 10 * seed, 30, 1000 + 400 * seed)
    grey = np.clip(np.rint(np.concatenate([sea, cloud])), 0, 255)
    grey[:2] = 0.0, 255.0
    scatter = {split: _within_class_scatter(grey, split) for split in range(255)}
    best = min(scatter, key=scatter.__getitem__)
    # 256 bins over 0 to 255 hold one integer each, so that the split is the same one.
    assert np.array_equal(grey > otsu_threshold(grey), grey > best)


def test_otsu_lies_midway_between_two_separate_levels():
    level = np.array([[1.0, 1.0, 1.0], [1.0, 3.0, 3.0]])
    assert otsu_threshold(level) == pytest.approx(2.0, abs=2 / 256)


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0.0), (1e6, -3e6), (1.0, -300.0), (1e-9, 300.0)])
def test_otsu_follows_scale_and_offset(scale, offset):
    level = np.random.default_rng(0).gamma(2.0, 1.0, (50, 50))
    moved = scale * level + offset
    assert np.mean((moved > otsu_threshold(moved)) != (level > otsu_threshold(level))) < 2e-3


def test_otsu_ignores_missing_pixels():
    level = np.random.default_rng(1).gamma(2.0, 1.0, (40, 40))
    holes = np.concatenate([level, np.full((7, 40), np.nan)])
    assert otsu_threshold(holes) == otsu_threshold(level)


@pytest.mark.parametrize("level", [[np.nan, np.nan], [2.0, 2.0], [np.nan, 1.0]])
def test_otsu_refuses_levels_without_contrast(level):
    with pytest.raises(ValueError, match="two different values"):
        otsu_threshold(np.array(level))


@pytest.mark.parametrize("window", [3, 4, 7])
def test_local_mean_is_the_mean_of_what_is_there(window):
    level = np.random.default_rng(2).normal(280, 5, (12, 9))
    level[3:5, 2:6] = np.nan
    mean = local_mean(level, window)
    before = window // 2
    for row, column in np.ndindex(*level.shape):
        part = level[max(0, row - before) : row - before + window, max(0, column - before) : column - before + window]
        finite = part[np.isfinite(part)]
        if finite.size:
            assert mean[row, column] == pytest.approx(finite.mean(), abs=1e-9)
        else:
            assert np.isnan(mean[row, column])


def test_local_mean_of_missing_surroundings_is_missing():
    level = np.full((9, 9), np.nan)
    level[0, 0] = 1.0
    assert np.isnan(local_mean(level, 3)[5, 5])
    assert np.isnan(local_mean(np.full((3, 3), np.nan), 3)).all()


def _sea_with_deck_and_thin_clouds() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    level = random.normal(0.05, 0.005, (200, 200))
    deck = np.zeros((200, 200), dtype=bool)
    deck[:80, :] = True
    thin = np.zeros_like(deck)
    for row, column in [(110, 30), (130, 100), (160, 50), (180, 160), (120, 170)]:
        thin[row : row + 6, column : column + 6] = True
    level[deck] = random.normal(0.7, 0.02, deck.sum())
    level[thin] = random.normal(0.2, 0.005, thin.sum())
    return level, deck, thin


def test_local_finds_thin_clouds_that_otsu_misses_and_keeps_the_open_sea_clear():
    level, deck, thin = _sea_with_deck_and_thin_clouds()
    otsu = level > otsu_threshold(level)
    local = level > local_threshold(level, 25)
    assert np.array_equal(otsu, deck)
    assert local[deck].all()
    assert local[thin].all()
    assert local[~deck & ~thin].mean() < 0.003  # one-sided 3 sigma of a normal sea: 0.00135


def test_local_is_never_below_otsu_coverage():
    level = np.random.default_rng(4).gamma(1.5, 0.1, (80, 80))
    assert np.all(local_threshold(level, 9) <= otsu_threshold(level))


@pytest.mark.parametrize("coverage", [0.0, 0.001, 0.1, 1 / 3, 0.5, 0.9999, 1.0])
def test_coverage_is_met_to_half_a_pixel(coverage):
    level = np.random.default_rng(5).normal(size=(37, 53))
    cloudy = level > coverage_threshold(level, coverage)
    assert abs(np.count_nonzero(cloudy) - coverage * level.size) <= 0.5


def test_coverage_is_of_the_visible_pixels():
    level = np.arange(100.0).reshape(10, 10)
    level[0] = np.nan
    assert np.count_nonzero(level > coverage_threshold(level, 0.5)) == 45
    assert np.count_nonzero(level > coverage_threshold(level, 1.0)) == 90
    with pytest.raises(ValueError, match=r"allowed 0 to 1; closest is 1"):
        coverage_threshold(level, 1.05)


@pytest.mark.parametrize(("coverage", "count"), [(0.1, 0), (0.3, 4), (0.5, 4), (0.7, 9), (0.96, 10)])
def test_equal_levels_stay_together(coverage, count):
    level = np.array([3.0] * 4 + [2.0] * 5 + [1.0])
    assert np.count_nonzero(level > coverage_threshold(level, coverage)) == count
