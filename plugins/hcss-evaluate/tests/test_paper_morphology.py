"""Measures of the simulated cloud type next to those printed in Tables VIII and IX of the HCSS paper.

The printed images are 800 x 800 pixels of 20 m with 256 grey levels. EV is left out: the printed values are about
half of what eq 21 gives for clouds with the printed coverage, DP and Den (docs/how-to/evaluate.md).
"""

import functools
import math

import numpy as np
import pytest
from hcss_evaluate.measures.morphology import morphology
from printed_tables import PAPER

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.clouds.coverage import cloud_fraction_value, cloudy_pixels
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

ROWS = PAPER["table_9"]["rows"]
SEEDS = 4


@functools.cache
def measured(cloud_type, coverage, seed):
    catalog = Catalog(root=catalog_root())
    shape = catalog.toml(catalog.find(cloud_type, "cloud_types", ".toml"))["fractal"]
    particles = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
    layer = CloudLayer(cloud_type, 333.0, 6000.0, "base", 10.0, coverage, None, particles)
    inputs = CloudInputs(layer, Grid(800, 800, 20.0), Motion(0.0, (0.0, 0.0), math.inf, 1.0), seed, catalog, shape)
    field = FractalClouds(inputs, FractalParameters()).field(0.0, slice(0, 800), slice(0, 800))
    return morphology(cloud_fraction_value(field), cloudy_pixels(field, coverage))


def mean(name, coverage):
    return np.mean([getattr(measured("paper-simulated", coverage, seed), name) for seed in range(SEEDS)])


@pytest.mark.parametrize("row", ROWS)
def test_the_body_count_at_the_printed_coverage_is_the_printed_fd_within_the_scatter_of_clouds(row):
    # One standard deviation over clouds of this type is .025 to .035; the printed images are single ones.
    coverage = ROWS[row][0] / 100.0
    assert mean("fractal_dimension", coverage) == pytest.approx(ROWS[row][4], abs=0.06)


def test_the_simulated_image_of_table_viii_is_met_in_den_dp_and_fd_at_one_coverage():
    # Its coverage is not printed: the one that gives the printed DP.
    _, density, peak, dimension = PAPER["table_8"]["sim"]
    coverage = 0.204
    assert mean("diagonal_peak", coverage) == pytest.approx(peak, rel=0.01)
    assert mean("density", coverage) == pytest.approx(density / 10.0, rel=0.025)
    assert mean("fractal_dimension", coverage) == pytest.approx(dimension, abs=0.06)


def test_dp_at_the_printed_coverage_is_the_printed_one_within_some_percent():
    for row in ROWS.values():
        assert mean("diagonal_peak", row[0] / 100.0) == pytest.approx(row[3], rel=0.03)


def test_a_surface_estimator_does_not_give_the_printed_fd():
    # The reason for counting the body: the tops are far smoother than 2.5 to 2.65, at every coverage.
    for row in ROWS.values():
        assert mean("surface_dimension", row[0] / 100.0) < 2.3


@pytest.mark.parametrize(
    ("cloud_type", "cells"), [("paper-simulated", (3, 7)), ("cirrus", (50, 10)), ("stratus", (10, 10))]
)
def test_the_aspect_of_fractal_clouds_is_the_ratio_of_their_cells(cloud_type, cells):
    found = [measured(cloud_type, 0.3, seed).aspect for seed in range(SEEDS)]
    # Cells are 16 km / L long. Few of the largest fit into the image.
    assert np.exp(np.mean(np.log(found))) == pytest.approx(cells[1] / cells[0], rel=0.15)
