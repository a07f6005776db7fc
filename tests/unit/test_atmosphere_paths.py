import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.profile import EARTH_RADIUS_M, Profile, local_zenith_deg, slant_length_m


@pytest.fixture(scope="module")
def profile():
    return load_profile("us-standard-1976", Catalog())


def test_vertical_path_crosses_every_layer_once(profile):
    np.testing.assert_allclose(profile.airmass(to_space(0.0, 0.0)), 1.0, rtol=1e-9)


def test_legs_are_summed(profile):
    view, sun = to_space(0.0, 40.0), to_space(0.0, 60.0)
    np.testing.assert_allclose(profile.airmass(view + sun), profile.airmass(view) + profile.airmass(sun))


@given(zenith=st.floats(0, 89.9), split=st.floats(1.0, 99_000.0))
def test_a_leg_cut_in_two_is_the_same_leg(zenith, split):
    profile = load_profile("us-standard-1976", Catalog())
    whole = profile.airmass(to_space(0.0, zenith))
    parts = profile.airmass(Path((Leg(0.0, split, zenith), Leg(split, SPACE, zenith))))
    crossed = (profile.altitude_m[:-1] < split) & (profile.altitude_m[1:] > split)
    np.testing.assert_allclose(parts[~crossed], whole[~crossed], rtol=1e-9)
    # In the layer that is cut, air mass is shared out by pressure, slant by length.
    np.testing.assert_allclose(parts[crossed], whole[crossed], rtol=0.05)


@given(zenith=st.floats(0, 89.9), low=st.floats(0, 50_000), height=st.floats(1, 50_000))
def test_slant_length_solves_the_triangle(zenith, low, height):
    length = float(slant_length_m(np.array(low), np.array(low + height), zenith))
    local = np.radians(local_zenith_deg(zenith, low))
    radius = EARTH_RADIUS_M + low
    # Cosine rule between the centre of the Earth and the ends of the ray.
    top = np.sqrt(radius**2 + length**2 + 2 * radius * length * np.cos(local))
    assert top - radius == pytest.approx(height, rel=1e-6, abs=1e-3)


def test_mean_airmass_is_secant_while_the_earth_is_flat_and_less_beyond(profile):
    airmass = profile.mean_airmass(0.0, np.array([0.0, 60.0, 85.0]))
    assert airmass[0] == pytest.approx(1.0)
    assert airmass[1] == pytest.approx(2.0, rel=5e-3)
    # Kasten and Young (1989): 10.3 at 85 deg apparent zenith.
    assert airmass[2] == pytest.approx(10.31, rel=0.02)


@pytest.mark.parametrize("arguments", [(-1.0, SPACE, 0.0), (5.0, 1.0, 0.0), (0.0, SPACE, 90.0), (0.0, SPACE, -1.0)])
def test_impossible_legs_are_refused(arguments):
    with pytest.raises(ValueError, match=r"allowed|needs"):
        Leg(*arguments)


def test_temperature_outside_the_profile_is_refused(profile):
    with pytest.raises(ValueError, match="allowed"):
        profile.temperature_at(200_000.0)


def test_profile_is_immutable(profile):
    with pytest.raises(AttributeError):
        profile.name = "other"
    assert isinstance(profile, Profile)
