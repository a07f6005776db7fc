"""What legs have adds up along composite paths, and is computed once for each leg."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.paths import SPACE, Leg, LegSums, Path, to_space
from hcss_twin.physics.profile import EARTH_RADIUS_M, airmass_of_legs

LEGS = (Leg(0.0, 700.0, 10.0), Leg(700.0, SPACE, 10.0), Leg(0.0, SPACE, 60.0))
PROFILE = load_profile("us-standard-1976", Catalog())


def spans(asked=None):
    """Sums of (height crossed below 1 km, zenith angle); legs that are computed are appended to ``asked``."""

    def compute(legs, known):
        for leg in legs:
            if asked is not None:
                asked.append(leg)
            known[leg] = np.array([min(leg.upper_m, 1000.0) - min(leg.lower_m, 1000.0), leg.zenith_deg])

    return LegSums(2, compute)


def test_paths_have_the_sums_of_their_legs():
    paths = [Path(), Path(LEGS[:1]), Path(LEGS), Path(LEGS[1:] + LEGS[1:])]
    expected = [[0.0, 0.0], [700.0, 10.0], [2000.0, 80.0], [2600.0, 140.0]]
    np.testing.assert_array_equal(spans().of(paths), expected)
    np.testing.assert_array_equal(spans().of(paths[::-1]), expected[::-1])


def test_no_paths_and_paths_without_legs_have_nothing():
    assert spans().of([]).shape == (0, 2)
    np.testing.assert_array_equal(spans().of([Path(), Path()]), np.zeros((2, 2)))


def test_each_leg_is_computed_once():
    asked = []
    sums = spans(asked)
    sums.of([Path(LEGS), Path(LEGS[:2])])
    sums.of([Path(LEGS[::-1])])
    assert sorted(asked, key=LEGS.index) == list(LEGS)


def test_what_is_returned_can_be_changed_without_changing_what_is_kept():
    sums = spans()
    sums.of([Path(LEGS[:1])])[...] = -1.0
    np.testing.assert_array_equal(sums.of([Path(LEGS[:1])]), [[700.0, 10.0]])


@pytest.mark.parametrize("zenith", [0.0, 50.0, 85.0])
def test_air_masses_of_layers_are_those_of_rays_in_spherical_shells(zenith):
    """Of whole layers: sqrt(r^2 - s^2) at the top minus at the bottom, over the thickness, s being the impact."""
    (found,) = airmass_of_legs(PROFILE, [Leg(0.0, SPACE, zenith)])
    radius = EARTH_RADIUS_M + PROFILE.altitude_m
    along = np.sqrt(radius**2 - (EARTH_RADIUS_M * np.sin(np.radians(zenith))) ** 2)
    np.testing.assert_allclose(found, np.diff(along) / np.diff(radius), rtol=1e-6)


def test_air_masses_of_layers_crossed_in_part_count_by_pressure():
    ends = [(1200.0, 1900.0), (0.0, 1200.0), (1900.0, SPACE), (5000.0, 5000.0)]
    inside, below, above, nothing = airmass_of_legs(PROFILE, [Leg(*end, 0.0) for end in ends])
    np.testing.assert_allclose(inside + below + above, 1.0, rtol=1e-12)
    np.testing.assert_array_equal(nothing, 0.0)
    pressure = PROFILE.pressure_at(np.array([1000.0, 1200.0, 1900.0, 2000.0]))
    assert inside[1] == pytest.approx((pressure[1] - pressure[2]) / (pressure[0] - pressure[3]), rel=1e-12)
    np.testing.assert_array_equal(np.flatnonzero(inside), [1])


def test_air_mass_of_a_path_is_that_of_its_legs():
    path = to_space(300.0, 40.0) + Path((Leg(300.0, 2500.0, 75.0),))
    np.testing.assert_array_equal(PROFILE.airmass(path), sum(airmass_of_legs(PROFILE, [leg])[0] for leg in path.legs))
    np.testing.assert_array_equal(PROFILE.airmass(Path()), np.zeros(PROFILE.altitude_m.size - 1))
