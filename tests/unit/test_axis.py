"""Nodes of axes of radiance: as few as follow the change, where it has kinks, and with the error that is told."""

from itertools import pairwise

import numpy as np
import pytest

from hcss_twin.core.error_norm import error_of_columns
from hcss_twin.plan.axis import Axis, PlacedAxis, place

VIEWS = {"orders": (0, 1, 2, 4, 8, 16, 32), "cut": "never", "fewest": True}


def columns(function):
    """Columns whose two terms share a function of the place."""
    return lambda x: np.array([0.3, 0.7])[None, :, None] * function(x)[:, None, None]


@pytest.mark.parametrize(
    ("function", "order"),
    [
        (lambda x: 1.0 + 0.0 * x, 0),
        (lambda x: 1.0 + 0.1 * x, 1),
        (lambda x: 2.0 + x * x, 2),
        (lambda x: 3.0 + x**3, 3),
        (lambda x: 3.0 + x**5, 5),
        (lambda x: 3.0 + x**6, 6),
    ],
)
def test_as_few_nodes_are_taken_as_follow_the_change(function, order):
    placed = place(Axis(-1.0, 1.0), columns(function), 1e-9, **VIEWS)
    assert placed.nodes.size == order + 1
    assert placed.error < 1e-9


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("width", [0.4, 1.0, 3.0])
def test_the_error_told_is_that_of_the_polynomial(width, tolerance):
    """Of a glint of Gaussian width: measured on places that the choice does not know."""
    glint = columns(lambda x: 1.0 + np.exp(-(((x - 0.3) / width) ** 2)))
    placed = place(Axis(-1.0, 1.0), glint, tolerance, **VIEWS)
    places = np.random.default_rng(1).uniform(-1.0, 1.0, 400)
    assert placed.error <= tolerance
    assert error_of_columns(placed.interpolate(glint(placed.nodes), places), glint(places)) < 1.5 * placed.error


def test_what_no_order_follows_is_told():
    placed = place(Axis(-1.0, 1.0), columns(lambda x: 1.0 + (x > 0.1)), 1e-3, **VIEWS)
    assert placed.nodes.size == 33
    assert placed.error > 0.1
    assert placed.missed is not None


@pytest.mark.parametrize("cut", ["needed", "kinks"])
def test_segments_end_at_kinks_where_they_matter(cut):
    kinks = (0.2, 0.5, 0.7)
    bent = columns(lambda x: 1.0 + np.abs(x - 0.5))
    placed = place(Axis(0.0, 1.0, kinks), bent, 1e-9, orders=(1, 2), cut=cut, fewest=True)
    ends = [0.0, *(segment[-1] for segment in placed.segments)]
    assert ends == ([0.0, 0.5, 1.0] if cut == "needed" else [0.0, *kinks, 1.0])
    places = np.linspace(0.0, 1.0, 101)
    assert error_of_columns(placed.interpolate(bent(placed.nodes), places), bent(places)) < 1e-9
    of = placed.segment_of(places)
    for segment, (low, high) in enumerate(pairwise(ends)):
        assert np.all((places[of == segment] >= low) & (places[of == segment] <= high))


def test_nodes_are_among_given_values_and_end_when_these_are_all():
    given = np.unique(np.random.default_rng(3).uniform(0.0, 1.0, 30))
    given[[0, -1]] = 0.0, 1.0
    placed = place(Axis(0.0, 1.0), columns(np.exp), 1e-9, nearest=given)
    assert set(placed.nodes.tolist()) <= set(given.tolist())
    jump = place(Axis(0.0, 1.0), columns(lambda x: 1.0 + (x > 0.4)), 1e-9, nearest=given, cut="needed")
    assert jump.missed is None
    assert (
        error_of_columns(
            jump.interpolate(columns(lambda x: 1.0 + (x > 0.4))(jump.nodes), given),
            columns(lambda x: 1.0 + (x > 0.4))(given),
        )
        < 1e-9
    )


def test_each_band_has_a_coordinate_of_its_own():
    """Of temperature: radiance that is a straight line in each band's coordinate needs two nodes."""
    powers = np.array([4.0, 12.0])
    axis = Axis(280.0, 300.0, coordinate=lambda kelvin: kelvin[None] ** powers[:, None])
    black = lambda kelvin: (1.0 + 1e-9 * kelvin[:, None] ** powers)[:, None]  # noqa: E731
    placed = place(axis, black, 1e-10, orders=(1, 2, 4), cut="never", fewest=True)
    assert placed.nodes.tolist() == [280.0, 300.0]
    assert isinstance(placed, PlacedAxis)
