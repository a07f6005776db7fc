"""Full disks whose places have suns, air and sea of their own."""

from datetime import UTC, datetime

import numpy as np
import pytest
from camera_scenes import scenario
from hcss_payload.climate import ZonalClimate
from hcss_payload.directions import Hemisphere
from hcss_payload.disk import Disk, with_glint
from hcss_payload.scene_plane import toward_camera
from hcss_payload.trajectory import Geostationary
from hcss_payload.zonal_disk import ZonalDisk, zonal_disk
from test_cube import DISK

import hcss_twin
from hcss_twin import ScenarioError
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.certificate.many_points import solve_many
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.sun import sun_position
from hcss_twin.plan import views

NOON = datetime(2024, 4, 20, 2, 30, tzinfo=UTC)
CAMERA_M = Geostationary(140.7).at(0.0)


def disk(edge=1.7):
    return Disk(edge, (0.0, 140.7), tuple(CAMERA_M.tolist()), NOON, (0.0,))


def test_a_direction_to_the_camera_tells_the_place():
    line = np.linspace(-1.0, 1.0, 7)
    places = [(x, y) for x in line for y in line]
    for any_disk in (disk(), with_glint(disk())):
        views = any_disk.at(places)
        ground = Ellipsoid.to_earth_centred(
            *(np.array([getattr(v, n) for v in views]) for n in ("latitude_deg", "longitude_deg"))
        )
        found = np.stack(any_disk.places(toward_camera(ground, CAMERA_M, any_disk.centre), ground), axis=-1)
        assert found == pytest.approx(np.array(places), abs=1e-8)
        again = any_disk.views_of(ground)
        assert [v.zenith_deg for v in again] == pytest.approx([v.zenith_deg for v in views], abs=1e-9)
    assert max(view.zenith_deg for view in views) > 81.0


def test_latitude_and_slant_path_tell_the_view_of_places_in_the_west():
    flat = disk()
    west = flat.at(np.random.default_rng(4).uniform((0.01, -0.7), (0.7, 0.7), (60, 2)))  # the camera is to the east
    ground = Ellipsoid.to_earth_centred(
        *(np.array([getattr(v, n) for v in west]) for n in ("latitude_deg", "longitude_deg"))
    )
    zonal = zonal_disk(flat, toward_camera(ground, CAMERA_M, flat.centre), np.array([-70.0, 70.0]), 75.0)
    x, y = zonal.places(toward_camera(ground, CAMERA_M, flat.centre), ground)
    assert max(np.abs(x).max(), np.abs(y).max()) < 1.0
    for view, true in zip(zonal.at(zip(x, y, strict=True)), west, strict=True):
        assert (view.zenith_deg, view.latitude_deg) == pytest.approx((true.zenith_deg, true.latitude_deg), abs=1e-6)
        # On a sphere; near the point below the camera bearings change fast.
        turned = np.sin(np.radians(view.zenith_deg)) * (view.azimuth_deg - true.azimuth_deg)
        assert turned == pytest.approx(0.0, abs=1.0)


def test_places_are_densest_around_the_mirror_image_of_the_sun():
    glinting = with_glint(disk())
    assert glinting.glint is not None
    (view,) = disk().at([glinting.glint])
    (sun,) = glinting.suns(view)
    # Within the step of the search, 5 degrees near the middle of the disk.
    assert view.zenith_deg == pytest.approx(sun.zenith_deg, abs=5.0)
    assert abs((view.azimuth_deg - sun.azimuth_deg) % 360.0 - 180.0) < 25.0
    line = np.linspace(-1.0, 1.0, 101)
    toward = np.stack([np.sin(line), 0.0 * line, np.cos(line)], axis=-1)
    x = glinting.places(toward, toward)[0]
    assert np.argmax(np.diff(x)) == pytest.approx(50, abs=3)


def test_suns_are_those_of_the_places():
    whole_disk = disk()
    views = whole_disk.at([(-0.9, 0.0), (0.5, -0.5), (0.0, 0.9)])
    for view in views:
        (sun,) = whole_disk.suns(view)
        zenith, azimuth, _ = sun_position([NOON], np.array([view.latitude_deg]), np.array([view.longitude_deg]))
        assert (sun.zenith_deg, sun.azimuth_deg) == pytest.approx((zenith[0], azimuth[0]))


def test_zonal_air_is_that_of_its_model_atmospheres_and_mirrors_the_seasons():
    spring = ZonalClimate(Catalog(), NOON)
    assert spring.profile(0.0).temperature_K[0] == pytest.approx(299.7)  # tropical, AFGL-TR-86-0110
    january, july = (ZonalClimate(Catalog(), datetime(2024, month, 15, tzinfo=UTC)) for month in (1, 7))
    assert july.profile(45.0).temperature_K[0] == pytest.approx(294.2, abs=0.1)
    assert january.profile(60.0).temperature_K[0] == pytest.approx(257.2, abs=0.1)
    assert january.profile(-45.0).temperature_K == pytest.approx(july.profile(45.0).temperature_K, abs=0.1)
    sea = np.array([spring.sea_temperature_K(latitude) for latitude in np.arange(-80.0, 81.0, 5.0).tolist()])
    # Zonal means of the climatology: 301 K at the equator, at its freezing point toward the poles.
    assert sea.max() == pytest.approx(301.5, abs=1.5)
    assert sea.min() >= 271.35
    assert np.argmax(sea) == pytest.approx(16, abs=1)
    assert np.all(np.diff(spring.profile(30.0).pressure_Pa) < 0.0)


def test_a_disk_by_day_has_suns_of_its_places():
    day = {"time": "2024-04-20T02:30:00Z", "accuracy": 0.1, "output": {"certificate": 3}}
    cube = hcss_twin.simulate(scenario(DISK, day))
    assert cube.attrs["hcss_certificate"].startswith("computed as specified: 3 random pixels")
    assert isinstance(hcss_twin.make_plan(scenario(DISK)).rays.directions, Hemisphere)  # midnight


def test_a_disk_by_night_has_the_air_of_its_latitudes():
    night = {"camera": {"climate": "latitude"}, "sea": {"temperature": None}, "output": {"certificate": 3}}
    planned = scenario(DISK, night, {"accuracy": 0.03})
    assert isinstance(hcss_twin.make_plan(planned).rays.directions, ZonalDisk)
    assert hcss_twin.simulate(planned).attrs["hcss_certificate"].startswith("computed as specified: 3 random pixels")
    beside = hcss_twin.make_plan(scenario(DISK, night, {"accuracy": 0.1, "sea": {"wind_from": 271.0}}))
    assert isinstance(beside.rays.directions, Disk)  # the wind differs between east and west


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"camera": {"climate": "latitude"}}, r"sea.temperature: .* with camera.climate = 'latitude'"),
        ({"time": "2024-04-20T02:30:00Z", "place": {"latitude": 40.0}},
         r"place: 39.8 deg from the place below the camera"),
        ({"orbit": {"provider": "circular", "altitude": 3.4e7, "inclination": 0.0, "longitude": None,
                    "above": [0.0, 140.7]},
          "frames": {"count": 2, "interval": 600.0}, "camera": {"climate": "latitude"}, "sea": {"temperature": None}},
         r"camera.climate: 'latitude' without a full disk"),
        ({"orbit": {"provider": "circular", "altitude": 3.4e7, "inclination": 0.0, "longitude": None,
                    "above": [0.0, 140.7]},
          "frames": {"count": 2, "interval": 600.0}, "time": "2024-04-20T02:30:00Z"},
         r"orbit: moves, and the camera sees the Earth up to the limb by day, .* allowed: a camera that stands still"),
    ],
)  # fmt: skip
def test_what_a_disk_cannot_show_is_refused_by_name(parts, message):
    with pytest.raises(ScenarioError, match=message):
        hcss_twin.make_plan(scenario(DISK, parts))


def test_the_columns_of_a_pixel_follow_from_few():
    rng = np.random.default_rng(1)
    columns = np.zeros((60, 1))
    columns[1:, 0] = np.exp(rng.uniform(np.log(50.0), np.log(400.0), 59))
    asked = []

    def solved(positions):
        asked.append(len(positions))
        return (30.0 + 12.0 * np.exp(-positions / 300.0))[:, :, None]

    assert solve_many(solved, columns, 1e-3) == pytest.approx(solved(columns), rel=1e-6)
    assert asked == [10, 60]

    def rough(positions):
        asked.append(len(positions))
        return (30.0 + np.sin(positions))[:, :, None]

    assert np.array_equal(solve_many(rough, columns, 1e-3), rough(columns))


def test_frames_with_the_limb_have_nodes_around_all_their_pixels():
    # Rays of the mesh are 8 pixels apart: the outermost that meet the ground lie far inside this disk.
    rays = hcss_twin.make_plan(scenario(DISK, {"camera": {"rows": 32, "columns": 32, "detector_pitch": 9.6e-4}})).rays
    everywhere = slice(0, 32), slice(0, 32)
    x, y = rays.positions(everywhere, 0.0)
    assert np.array_equal(np.isnan(x), rays.unseen(everywhere, 0.0))
    assert rays.bounds(0.0) is None  # tables are those of the pass
    assert max(np.nanmax(np.abs(x)), np.nanmax(np.abs(y))) <= 1.0


@pytest.mark.parametrize(("kink", "accepted"), [(1.0, True), (3.0, True), (9.0, False)])
def test_kinks_of_the_air_are_accepted_within_twice_the_tolerance(kink, accepted, monkeypatch):
    # The best polynomial of order n misses a kink by about a quarter of its change of slope over n.
    def columns(*_):
        return lambda places: [np.full((1, 1, 1), 10.0 + kink * abs(y - 0.123)) for _, y in places]

    monkeypatch.setattr(views, "_columns", columns)
    # Plans of one scenario are kept: each kink has a wind of its own.
    sea = {"temperature": None, "wind_speed": 5.0 + kink}
    planned = scenario(DISK, {"camera": {"climate": "latitude"}, "sea": sea, "accuracy": 0.01})
    if accepted:
        axis = hcss_twin.make_plan(planned).views
        assert axis.order_x == 0
        assert axis.order_y == 32
        assert axis.estimated_error <= 0.006
    else:
        with pytest.raises(ScenarioError, match=r"remains with 1 x 33 views .* allowed: an error of 6\.0e-03"):
            hcss_twin.make_plan(planned)
