from datetime import UTC, datetime

import numpy as np
import pytest

from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.plan.lines_of_sight import SunTrack

NOON = datetime(2024, 3, 20, 12, 0, tzinfo=UTC)


def test_the_sun_is_that_of_the_place_the_platform_has_reached():
    # On the equator 1 degree of longitude is 111.319 km of the ellipsoid.
    moving = SunTrack(NOON, 0.0, 0.0, platform_speed_m_s=111_319.49 / 60)
    still = SunTrack(NOON, 0.0, 1.0)
    for one, other in zip(moving.positions(np.array([60.0])), still.positions(np.array([60.0])), strict=True):
        assert one[0] == pytest.approx(other[0], abs=1e-4)


def test_a_platform_that_follows_the_sun_keeps_it():
    # The Earth turns 15 degrees an hour: a platform moving west as fast sees the sun stand still.
    west = SunTrack(NOON, 0.0, 0.0, platform_speed_m_s=-15 * 111_319.49 / 3600)
    zenith, _, _ = west.positions(np.array([0.0, 3600.0]))
    assert zenith[0] == pytest.approx(zenith[1], abs=0.03)


def test_the_hot_spot_scatters_straight_back():
    for zenith in np.linspace(0, 89, 90):
        mu = float(np.cos(np.radians(zenith)))
        assert scattering_cosine(mu, mu, 0.0) == pytest.approx(-1.0)
        assert scattering_cosine(mu, mu, 0.0) >= -1.0
