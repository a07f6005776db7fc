"""An image of the generator's own is matched with the parameters it was made with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hcss_evaluate.matching.dimension_range import empty_frame, match_dimension
from hcss_evaluate.matching.match import FRESH_SEEDS, SEARCH_SEEDS, Match, match
from hcss_evaluate.matching.search import brightness_exponent, fit_variogram, frame_cells, reference_cells, refine
from hcss_evaluate.matching.structure import (
    CloudImage,
    image_structure,
    octave_lags,
    simulate_image,
    underlying_structure,
)
from hcss_evaluate.matching.target import Target
from hcss_evaluate.measures.morphology import morphology_errors

from hcss_twin.core.errors import ImageError
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

FRAME = empty_frame(160, 160, 100.0)
COVERAGE = 0.45


def made(hurst, cells, exponent=1.0, seed=77, like=FRAME, coverage=COVERAGE):
    """Simulate an image with ``cells`` of the first octave across the frame along x and y."""
    parameters = FractalParameters(
        gamma=2.0, H=hurst, L=reference_cells(np.array(cells), like), k=(0, 5), brightness_exponent=exponent
    )
    return parameters, simulate_image(parameters, coverage, like, seed)


def started(image):
    lags = octave_lags(image.level.shape)
    structure = image_structure(image.level, lags)
    return structure, fit_variogram(underlying_structure(image.level, structure), image)


@pytest.mark.parametrize("hurst", [0.3, 0.7])
def test_analytic_start_finds_hurst_exponent_and_cells(hurst):
    found = []
    for seed in range(2):
        _, image = made(hurst, (10.0, 10.0), seed=seed)
        start = started(image)[1].parameters
        found.append([start.H, *np.log(frame_cells(start.L, image) / 10.0)])
    mean = np.mean(found, axis=0)
    assert mean[0] == pytest.approx(hurst, abs=0.12)
    assert np.all(np.abs(mean[1:]) < math.log(1.7))


def test_analytic_start_finds_along_which_axis_clouds_are_long():
    ratios = []
    for seed in range(2):
        _, image = made(0.6, (8.0, 16.0), seed=seed)
        x, y = started(image)[1].parameters.L
        ratios.append(math.log(y / x))
    assert math.exp(np.mean(ratios)) == pytest.approx(2.0, rel=0.2)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_brightness_exponent_is_estimated_without_simulation(exponent):
    # p is uniform only over the whole sky: within a frame the estimate starts a search, no more.
    _, image = made(0.6, (12.0, 12.0), exponent)
    assert brightness_exponent(image) == pytest.approx(exponent, rel=0.3)


def test_exponent_of_uniform_grey_levels_is_recovered():
    uniform = (np.arange(128 * 128) + 0.5) / 128**2
    level = (1.0 + 254.0 * uniform**1.7).astype(np.float32).reshape(128, 128)
    # The thinnest pixels are half a level too thick, lest the logarithm be infinite.
    assert brightness_exponent(CloudImage(level, 1.0)) == pytest.approx(1.7, rel=0.06)


def test_match_recovers_the_parameters_of_a_simulated_image():
    truth, image = made(0.6, (10.0, 10.0), 1.5)
    found = match(Target(image, "simulated", ()), budget=120)
    assert abs(found.parameters.H - truth.H) < 0.15
    ratio = np.array(found.parameters.L) / np.array(truth.L)
    assert np.all(ratio > 0.5)
    assert np.all(ratio < 2.0)
    assert found.parameters.brightness_exponent == pytest.approx(1.5, rel=0.3)
    # Two images with the very same parameters differ by about as much.
    assert found.mean_rmse < 0.05
    assert len(found.rmse) == FRESH_SEEDS
    assert found.simulations <= 120


def test_coverage_of_every_simulation_is_that_of_the_image():
    _, image = made(0.4, (6.0, 6.0))
    found = match(Target(image, "simulated", ()), budget=0)
    for seed in found.seeds[:3]:
        simulated = found.simulate(seed)
        assert np.count_nonzero(simulated.level) == np.count_nonzero(image.level)
    coverage = next(quantity for quantity in found.quantities if quantity.name == "coverage")
    assert coverage.error == 0.0


def test_search_lowers_what_it_makes_small_and_the_same_seed_gives_the_same_match():
    _, image = made(0.5, (6.0, 9.0), 0.7)
    structure, start = started(image)
    seeds = tuple(range(SEARCH_SEEDS))
    first = refine(image, structure, start.parameters, seeds, 1)
    told = []
    finish = refine(image, structure, start.parameters, seeds, 42, told.append)
    assert finish.objective < first.objective
    assert sum(told) == finish.simulations <= 42
    again = refine(image, structure, start.parameters, seeds, 42)
    assert again == finish


def test_judgement_uses_seeds_that_the_search_has_not_seen():
    _, image = made(0.5, (6.0, 6.0))
    found = match(Target(image, "simulated", ()), seed=4, budget=6)
    assert len(set(found.seeds)) == FRESH_SEEDS
    assert not set(found.seeds) & set(range(4, 4 + SEARCH_SEEDS))
    for seed, rmse in zip(found.seeds, found.rmse, strict=True):
        assert morphology_errors(image.morphology(), found.simulate(seed).morphology()).rmse == rmse


@pytest.mark.parametrize(
    ("rmse", "typical"), [((0.5, 0.1, 0.3), 12), ((0.1, 0.2, 0.3, 0.4), 11), ((0.4, 0.1, 0.2, 0.3), 12), ((0.7,), 10)]
)
def test_the_typical_seed_has_the_median_error_and_of_two_the_lower(rmse, typical):
    seeds = tuple(range(10, 10 + len(rmse)))
    found = Match(None, None, (), rmse, seeds, None, None, (), 0, None, ())
    assert found.typical_seed == typical


def test_stretched_diagonally_is_reported_as_not_matched():
    # Rows shifted by their number: stretched along the diagonal, which no lattice of eq 2 is.
    _, image = made(0.7, (48.0, 4.0), like=empty_frame(128, 384, 100.0))
    level = np.stack([image.level[row, row : row + 128] for row in range(128)])
    found = match(Target(CloudImage(level, 100.0), "sheared", ()), budget=0)
    assert any(line.startswith("oblique") for line in found.unmatched)


def test_cloud_that_fills_one_corner_is_reported_as_uneven():
    _, image = made(0.5, (16.0, 16.0))
    level = image.level.copy()
    level[80:] = 0.0
    level[:, 80:] = 0.0
    found = match(Target(CloudImage(level, 100.0), "corner", ()), budget=0)
    assert any(line.startswith("uneven") for line in found.unmatched)


@pytest.mark.parametrize("dimension", ["fractal", "surface"])
def test_dimension_lies_in_the_wanted_range_on_fresh_seeds(dimension):
    start, image = made(0.6, (8.0, 8.0))
    other = made(0.3, (8.0, 8.0))[1].morphology()
    aim = getattr(other, f"{dimension}_dimension")
    found = match_dimension((aim - 0.04, aim + 0.04), start, COVERAGE, image, dimension)
    assert aim - 0.04 <= np.mean(found.dimensions) <= aim + 0.04
    assert found.inside >= 0.5
    assert "H from 0.6" in found.changed


def test_unreachable_dimension_says_what_is_reached():
    start, image = made(0.6, (8.0, 8.0))
    with pytest.raises(ImageError, match=r"mean of 2 to 2\.05 not reached .* closest is 2\.\d+"):
        match_dimension((2.0, 2.05), start, COVERAGE, empty_frame(64, 64, 100.0))
    for wrong in ((2.5, 2.4), (1.9, 2.5), (2.5, 3.1)):
        with pytest.raises(ImageError, match="allowed: 2 <= low < high <= 3"):
            match_dimension(wrong, start, COVERAGE, image)
