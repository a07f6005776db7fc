"""The errors that ``hcss match`` tells are those of the simulation, relative to the measured image."""

import math

import numpy as np
import pytest
from hcss_evaluate.matching.quantities import MatchedQuantity, describe_unmatched
from hcss_evaluate.matching.structure import Structure


def quantity(image, simulated, **more):
    return MatchedQuantity("level", "mean grey level of cloud", image, simulated, 1.0, 0.1, **more)


def test_a_simulation_a_quarter_brighter_than_the_image_has_an_error_of_a_quarter():
    assert quantity(100.0, 125.0).error == pytest.approx(0.25)
    assert quantity(100.0, 75.0).error == pytest.approx(-0.25)
    assert quantity(2.5, 2.6, is_ratio=False).error == pytest.approx(0.1)


def test_what_the_image_has_none_of_is_infinitely_far():
    assert quantity(0.0, 3.0).error == math.inf
    assert quantity(0.0, 0.0).is_matched


def test_an_image_with_less_than_the_simulations_is_one_of_theirs():
    assert quantity(1.0, 1.5, is_ratio=False, is_one_sided=True).is_matched
    assert not quantity(1.5, 1.0, is_ratio=False, is_one_sided=True).is_matched


def test_semivariances_are_told_relative_to_the_image():
    lags = np.array([1, 2])
    flat = np.array([10.0, 10.0])
    image = Structure(lags, flat, flat)
    simulated = Structure(lags, np.array([10.0, 5.0]), flat)
    assert describe_unmatched((), image, simulated) == (
        "semivariance along x: 2 px -50% in the simulations, relative to the image",
    )
