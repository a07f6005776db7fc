"""Nodes of the thickness axis: where radiance has kinks, and where it has none to speak of."""

import re
from itertools import pairwise

import numpy as np
import pytest

from hcss_twin.core.error_norm import error_of_columns
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.thickness_axis import Source, axis_of, place_thickness
from hcss_twin.providers import CloudLayer, Microphysics

PARTICLES = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
LEVELS = np.array([0.0, 1000.0, 2000.0, 3500.0, 7000.0])
SOURCE = Source("radiance model 'mine' of hcss-mine 1.0", ("sea", "cloud", "air"))
KELVIN = np.array([300.0, 288.0, 289.0, 270.0, 240.0])


def layer(anchor, base=400.0, top=4000.0, least=10.0):
    return CloudLayer("x", base, top, anchor, least, 0.5, None, PARTICLES)


@pytest.mark.parametrize(("anchor", "inner"), [("base", [600.0, 1600.0, 3100.0]), ("top", [500.0, 2000.0, 3000.0])])
def test_an_axis_breaks_where_the_face_that_moves_crosses_a_level(anchor, inner):
    assert axis_of(layer(anchor), LEVELS).ends.tolist() == [10.0, *inner, 3600.0]


@pytest.mark.parametrize("anchor", ["base", "top"])
def test_radiance_with_a_kink_at_each_level_needs_few_columns(anchor):
    """Emission of the air's temperature at the face that moves: smooth between levels only."""
    made = layer(anchor)
    asked = []

    def columns(thickness_m):
        asked.append(thickness_m.size)
        face = made.base_m + thickness_m if anchor == "base" else made.top_m - thickness_m
        return (np.interp(face, LEVELS, KELVIN) ** 4)[:, None, None]

    axis = place_thickness(columns, made, LEVELS, 1e-6, SOURCE)
    assert sum(asked) < 400
    places = np.geomspace(10.0, 3600.0, 3001)
    dense = axis.interpolate(columns(axis.exact_m))[:, 0, 0]
    exact = columns(places)[:, 0, 0]
    assert np.abs(np.interp(places, axis.dense_m, dense) / exact - 1.0).max() <= 1e-6
    assert all(high > low for low, high in pairwise(axis.dense_m))


@pytest.mark.parametrize(("kelvin", "most"), [(300.0 - 6.5e-3 * LEVELS, 15), (KELVIN, 60)], ids=["straight", "kinks"])
def test_a_loose_tolerance_is_met_across_levels(kelvin, most):
    """A segment for each of the four ranges between levels would ask for 33 columns."""
    made, tolerance, asked = layer("base"), 2e-3, []

    def columns(thickness_m):
        asked.append(thickness_m.size)
        return (np.interp(made.base_m + thickness_m, LEVELS, kelvin) ** 4)[:, None, None]

    axis = place_thickness(columns, made, LEVELS, tolerance, SOURCE)
    assert sum(asked) <= most
    places = np.geomspace(10.0, 3600.0, 3001)
    dense = axis.interpolate(columns(axis.exact_m))[:, 0, 0]
    assert np.abs(np.interp(places, axis.dense_m, dense) / columns(places)[:, 0, 0] - 1.0).max() <= tolerance


@pytest.mark.parametrize("value", [1e-30, 1.0, 1e12])
def test_radiance_that_does_not_depend_on_thickness_takes_the_first_columns(value):
    axis = place_thickness(lambda m: np.full((m.size, 2, 3), value), layer("base"), LEVELS, 1e-9, SOURCE)
    assert axis.exact_m.size == 4 * 8 + 1
    np.testing.assert_allclose(axis.interpolate(np.full((axis.exact_m.size, 2, 3), value)), value, rtol=1e-14)


def test_terms_meet_the_accuracy_where_their_sum_does_not_change():
    """Cloud as bright as the sea that it hides: the sum is flat, its terms are exponentials."""
    tolerance = 1e-4

    def columns(thickness_m):
        seen = np.exp(-thickness_m / 100.0)
        return np.stack([seen, 1.0 - seen], axis=1)[:, :, None]

    axis = place_thickness(columns, layer("base"), LEVELS, tolerance, SOURCE)
    places = np.geomspace(10.0, 3600.0, 3001)
    dense, exact = axis.interpolate(columns(axis.exact_m))[:, :, 0], columns(places)[:, :, 0]
    for own, expected in zip(dense.T, exact.T, strict=True):
        assert np.abs(np.interp(places, axis.dense_m, own) - expected).max() <= 10.0 * tolerance


def terms(jumping, height_m=0.01):
    """Sea, cloud and air; the cloud shines brighter by a share where ``jumping``."""
    cloud = 1.0 + height_m * jumping
    return np.stack([np.ones_like(cloud), cloud, 0.5 * np.ones_like(cloud)], axis=1)[:, :, None]


@pytest.mark.parametrize(
    ("anchor", "between", "face", "face_m"),
    [("base", "600 and 1600", "top", 1177.7), ("top", "500 and 2000", "base", 3222.3)],
)
def test_an_axis_that_does_not_converge_says_who_jumps_and_where(anchor, between, face, face_m):
    with pytest.raises(ProviderError, match=f"between {between} m does not converge") as error:
        place_thickness(lambda m: terms(m > 777.7), layer(anchor), LEVELS, 1e-6, SOURCE)
    said = re.search(
        "term 'cloud' of radiance model 'mine' of hcss-mine 1.0 seems to jump near ([0-9.]+) m "
        rf"\({face} of layer 'x' at ([0-9.]+) m\)",
        str(error.value),
    )
    assert float(said[1]) == pytest.approx(777.7, abs=0.5)
    assert float(said[2]) == pytest.approx(face_m, abs=0.5)


def test_columns_beside_another_layer_that_do_not_converge_say_so():
    """Radiance jumps below thick clouds of another layer only: columns have a dimension of lines."""

    def columns(thickness_m):
        return np.stack((terms(0.0 * thickness_m), terms(thickness_m > 777.7)), axis=1)

    with pytest.raises(ProviderError, match=r"term 'cloud' of radiance model 'mine' .* near 777.* of layer 'x'"):
        place_thickness(columns, layer("base"), LEVELS, 1e-3, SOURCE, fewest=True)


def test_the_error_of_columns_is_that_of_their_total_or_a_tenth_of_a_terms():
    exact = np.ones((3, 2, 1))
    guess = exact.copy()
    guess[0, 0], guess[1, 1] = 1.1, 0.6
    assert error_of_columns(guess, exact) == pytest.approx(0.2)
    # Errors of terms that cancel in the total count a tenth.
    guess[2] = [[9.0], [-7.0]]
    assert error_of_columns(guess, exact) == pytest.approx(0.4)
