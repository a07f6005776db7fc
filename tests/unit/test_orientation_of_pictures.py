"""North, sun and scale drawn in a picture are those of the ground, on maps and in a turned camera."""

import numpy as np
import pytest
import xarray as xr

from hcss_twin.reports.orientation import EARTH_RADIUS_M, Orientation, length_text

SUN = {"solar_zenith_angle": ("time", [30.0]), "solar_azimuth_angle": ("time", [90.0])}


def image_map(**more):
    axes = {axis: (axis, 20.0 * np.arange(40), {"units": "m"}) for axis in "yx"}
    view = {"sensor_zenith_angle": 20.0, "sensor_azimuth_angle": 180.0}
    return xr.Dataset(coords={**axes, "time": [0], **SUN, **view, **more})


def camera(turn_deg, pixel_m=50.0, latitude=60.0):
    """An image whose upward axis has this bearing."""
    y, x = (pixel_m * part for part in np.mgrid[0:10, 0:12])
    turn = np.radians(turn_deg)
    east, north = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    pixel_latitude = latitude + np.degrees(north / EARTH_RADIUS_M)
    pixel_longitude = 179.999 + np.degrees(east / EARTH_RADIUS_M / np.cos(np.radians(latitude)))
    pixel_longitude = (pixel_longitude + 180.0) % 360.0 - 180.0  # across the date line
    places = {"pixel_latitude": pixel_latitude, "pixel_longitude": pixel_longitude}
    view = {"pixel_view_zenith": np.full(y.shape, 50.0), "pixel_view_azimuth": np.full(y.shape, 0.0)}
    pixels = {name: (("time", "y", "x"), values[None]) for name, values in {**places, **view}.items()}
    axes = {"y": np.arange(10), "x": np.arange(12), "time": [0]}
    return xr.Dataset(coords={**axes, **SUN, **pixels})


def test_on_a_map_north_is_up_the_sun_in_the_east_and_the_scale_that_of_its_pixels():
    where = Orientation.of(image_map())
    arrows = dict(where.arrows())
    assert arrows["N"] == pytest.approx((0.0, 1.0))
    assert arrows["sun"] == pytest.approx((1.0, 0.0))
    assert arrows["sensor"] == pytest.approx((0.0, -1.0), abs=1e-12)
    assert where.bar_m(40) == 200.0
    assert length_text(where.bar_m(400)) == "2 km"


@pytest.mark.parametrize("turn", [0.0, 90.0, 200.0, 315.0])
def test_in_a_turned_camera_north_and_sun_turn_with_it(turn):
    where = Orientation.of(camera(turn))
    arrows = dict(where.arrows())
    for name, bearing in (("N", 0.0), ("sun", 90.0), ("sensor", 0.0)):
        angle = np.radians(bearing - turn)
        assert arrows[name] == pytest.approx((np.sin(angle), np.cos(angle)), abs=1e-3)
    assert where.column_m == pytest.approx(50.0, rel=1e-3)
    assert not where.is_map


def test_by_night_and_from_above_there_is_no_arrow_but_words():
    night = image_map(solar_zenith_angle=("time", [120.0]), sensor_zenith_angle=0.0)
    where = Orientation.of(night)
    assert [name for name, _ in where.arrows()] == ["N"]
    assert where.words() == {"sun": "sun below horizon", "sensor": "sensor overhead"}


def test_an_image_beside_the_earth_has_no_orientation():
    away = camera(0.0)
    away["pixel_latitude"][:] = np.nan
    assert Orientation.of(away) is None
