"""Lines of sight from any place, under any view, from any altitude that a scenario allows."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hcss_twin.physics.geodesy import altitude_m
from hcss_twin.physics.viewing import LinesOfSight, off_nadir_deg, view_zenith_deg


def numbers(low, high):
    return st.floats(low, high, allow_nan=False)


@settings(deadline=None, max_examples=60)
@given(
    st.one_of(numbers(-90, 90), st.sampled_from([-90.0, 90.0, 0.0])),
    numbers(-180, 360),
    st.one_of(numbers(0, 85), st.just(0.0)),
    numbers(0, 360),
    numbers(100e3, 42_000e3),
    numbers(0, 1000e3),
)
def test_every_line_of_sight_leads_to_the_sensor(latitude, longitude, zenith, azimuth, altitude, side):
    lines = LinesOfSight(latitude, longitude, zenith, azimuth, altitude)
    assert abs(altitude_m(lines.sensor_m) - altitude) < 1e-3
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-side, side, 5), np.linspace(-side, side, 5)))
    seen = lines.from_points(x, y)
    assert all(np.all(np.isfinite(each)) for each in vars(seen).values())
    assert np.all(np.abs(seen.latitude_deg) <= 90.0)
    # The sum of both is rounded.
    assert np.all(np.abs(seen.longitude_deg - longitude) <= 180.0 + 1e-12)
    assert np.all((seen.azimuth_deg >= 0.0) & (seen.azimuth_deg <= 360.0))
    assert np.all(seen.range_m >= altitude * (1.0 - 1e-9))
    assert abs(seen.zenith_deg[12] - zenith) < 1e-6
    assert abs(view_zenith_deg(off_nadir_deg(zenith, altitude), altitude) - zenith) < 1e-4
