"""Lines of sight against PROJ and exact geometry."""

import numpy as np
import pyproj
import pytest
from hcss_payload import Camera, Circular, Geostationary, Jitter, Nadir, PayloadError, PushBroom, Track, pose_at
from hcss_payload.mesh import Mesh
from hcss_payload.rays import geographic, meet
from hcss_payload.scene_plane import FARTHEST_DEG, surface_place, to_scene
from hcss_payload.trajectory import velocity_m_s
from payload_scenes import camera

LOW = Circular(700e3, 98.2, 170.0)


def points(mesh):
    """Rows and columns of all points."""
    return np.meshgrid(*(np.arange(size, dtype=float) for size in mesh.shape), indexing="ij")


def off_px(mesh):
    """Distance (y, x) in pixels between each point and where the camera sees the latitude and longitude of the mesh."""
    from hcss_twin.physics.geodesy import Ellipsoid

    latitude, longitude, _ = geographic(mesh.positions_m())
    position_m = Ellipsoid.to_earth_centred(latitude, longitude, mesh.altitude_m)
    row, column = mesh.camera.pixels(mesh.pose.to_body(position_m - mesh.pose.position_m))
    y, x = points(mesh)
    return np.hypot(row - y, column - x)


@pytest.mark.parametrize("altitude", [0.0, 1500.0, 15e3])
def test_places_of_pixels_agree_with_proj_within_a_metre_limb_included(altitude):
    pyproj = pytest.importorskip("pyproj", reason="the reference is not installed")
    to_earth = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    pose = pose_at(0.0, Geostationary(140.7), Nadir(Geostationary(140.7)))
    mesh = Mesh(camera(301, 18.0), pose, altitude)
    exact = mesh.exact_m(*points(mesh))
    seen = ~np.isnan(exact[..., 0])
    assert 0.5 < seen.mean() < 0.95
    latitude, longitude, height = geographic(exact[seen])
    assert np.abs(height - altitude).max() < 0.2
    position_m = np.stack(to_earth.transform(longitude, latitude, np.full_like(latitude, altitude)), axis=-1)
    # What remains is along the normal for altitudes above 0: no pixel moves by more.
    assert np.linalg.norm(position_m - exact[seen], axis=-1).max() < 0.2
    # The place lies on the line of sight: PROJ alone, without the package's ellipsoid.
    ray = pose.to_earth(mesh.camera.directions(*(point[seen] for point in points(mesh))))
    away = position_m - pose.position_m
    assert np.linalg.norm(away - np.sum(away * ray, axis=-1, keepdims=True) * ray, axis=-1).max() < 0.2


@pytest.mark.parametrize("altitude", [0.0, 1500.0, 10e3])
def test_places_below_clouds_agree_with_proj_within_a_metre(altitude):
    to_earth = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    plane = pyproj.Proj("+proj=aeqd +lat_0=45 +lon_0=140 +ellps=WGS84")
    aside = np.array([-30e3, 0.0, 20e3])
    longitude, latitude = plane(aside, aside[::-1], inverse=True)
    position_m = np.stack(to_earth.transform(longitude, latitude, np.full_like(latitude, altitude)), axis=-1)
    x, y, _ = to_scene(*surface_place(position_m, altitude), (45.0, 140.0))
    assert np.abs(x - aside).max() < 0.5
    assert np.abs(y - aside[::-1]).max() < 0.5
    assert altitude < 10e3 or np.abs(to_scene(*surface_place(position_m), (45.0, 140.0))[1] - y).max() > 30.0


def test_nadir_agrees_with_astropy():
    coordinates = pytest.importorskip("astropy.coordinates", reason="the reference is not installed")
    for time in (0.0, 700.0, 1400.0):
        pose = pose_at(time, LOW, Nadir(LOW))
        met = meet(pose.position_m, pose.to_earth(np.array([0.0, 0.0, 1.0])))
        expected = coordinates.EarthLocation.from_geocentric(*pose.position_m, unit="m").to_geodetic("WGS84")
        latitude, longitude, height = geographic(met)
        assert abs(latitude - expected.lat.deg) < 1e-6
        assert abs(longitude - expected.lon.deg) < 1e-6
        assert abs(height) < 1e-3


def test_mesh_is_within_its_tolerance_over_a_full_disk_and_at_the_limb():
    mesh = Mesh(camera(700, 18.0), pose_at(0.0, Geostationary(0.0), Nadir(Geostationary(0.0))), 5e3)
    assert np.array_equal(np.isnan(mesh.positions_m()[..., 0]), np.isnan(mesh.exact_m(*points(mesh))[..., 0]))
    assert np.nanmax(off_px(mesh)) <= 0.006
    assert mesh.exact_share < 0.75  # fewer with more pixels: a ray is 200 km from the next here


@pytest.mark.parametrize("side_deg", [0.0, 40.0, 58.0, 63.5])
def test_mesh_is_within_its_tolerance_from_low_orbit(side_deg):
    mesh = Mesh(camera(256, 8.0, radial=(0.05, 0.0)), pose_at(300.0, LOW, PushBroom(LOW, roll_deg=side_deg)))
    assert np.nanmax(off_px(mesh)) <= 0.006
    assert side_deg > 55.0 or mesh.exact_share == 0.0


@pytest.mark.parametrize("shape", [(1, 100), (100, 1), (1, 1), (2, 9)])
def test_line_cameras_have_a_mesh(shape):
    mesh = Mesh(Camera(*shape, 0.5, 15e-6), pose_at(0.0, LOW, Nadir(LOW)), points=2)
    assert mesh.positions_m().shape == (2 * shape[0], 2 * shape[1], 3)
    assert np.nanmax(np.linalg.norm(mesh.positions_m() - mesh.exact_m(*points(mesh)), axis=-1)) < 1.0


def test_tracked_target_stays_on_its_pixel_without_jitter():
    optics = camera(512, 2.0, principal_point=(250.3, 260.9), radial=(0.1, 0.02), tangential=(1e-3, -2e-3))
    under = geographic(LOW.at(300.0))
    track = Track(LOW, under[0], under[1] + 3.0, 250.0)
    worst, shaken = [], []
    for time in np.linspace(180.0, 420.0, 13):
        for jitter, distances in ((None, worst), (Jitter((1e-4, 1e-4, 0.0)), shaken)):
            pose = pose_at(time, LOW, track, jitter)
            row, column = optics.pixels(pose.to_body(track.target_m - pose.position_m))
            distances.append(np.hypot(row - 250.3, column - 260.9))
    assert max(worst) < 0.006
    assert max(shaken) > 0.1


def test_push_broom_lines_lie_across_the_track():
    pose = pose_at(500.0, LOW, PushBroom(LOW))
    motion = pose.to_body(velocity_m_s(LOW, 500.0))
    assert motion[0] == pytest.approx(0.0, abs=1e-3)  # nothing along the columns
    assert motion[1] < -7e3
    right = pose_at(500.0, LOW, PushBroom(LOW, roll_deg=20.0)).to_earth(np.array([0.0, 0.0, 1.0]))
    assert pose.to_body(right)[0] == pytest.approx(np.sin(np.radians(20.0)))
    ahead = pose_at(500.0, LOW, PushBroom(LOW, pitch_deg=20.0)).to_earth(np.array([0.0, 0.0, 1.0]))
    assert pose.to_body(ahead)[1] == pytest.approx(-np.sin(np.radians(20.0)))


def test_pixels_invert_directions_with_distortion_and_mounting():
    optics = camera(
        200, 30.0, radial=(-0.2, 0.05), tangential=(2e-3, -1e-3), mounting=(0.1, -0.2, 0.05, np.sqrt(1 - 0.0525))
    )
    row, column = np.meshgrid(np.linspace(-0.5, 199.5, 9), np.linspace(-0.5, 199.5, 7), indexing="ij")
    back = optics.pixels(optics.directions(row, column))
    assert np.abs(back[0] - row).max() < 1e-6
    assert np.abs(back[1] - column).max() < 1e-6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rows": 0}, "camera.rows: 0; allowed: 1 to 65536; closest valid choice is 1"),
        ({"radial": (-5.0, 0.0), "field_deg": 60.0}, "camera.radial, camera.tangential: .* cannot be inverted"),
        ({"mounting": (0.0, 0.0, 0.0, 2.0)}, "camera.mounting: a quaternion with norm 2; allowed: norm 1"),
    ],
)
def test_wrong_cameras_are_named(changes, message):
    with pytest.raises(PayloadError, match=message):
        camera(**changes)


@pytest.mark.parametrize("centre", [(0.0, 140.7), (50.0, 10.0), (89.0, 0.0)])
def test_places_in_the_plane_of_the_scene_are_geodesics_of_proj(centre):
    rng = np.random.default_rng(1)
    latitude, longitude = np.degrees(np.arcsin(rng.uniform(-1.0, 1.0, 2000))), rng.uniform(-180.0, 180.0, 2000)
    x, y, _ = to_scene(latitude, longitude, centre)
    azimuth, _, distance = pyproj.Geod(ellps="WGS84").inv(
        *(np.full(2000, coordinate) for coordinate in reversed(centre)), longitude, latitude
    )
    near = np.isfinite(x)
    assert np.all(near[distance < np.radians(FARTHEST_DEG - 1.0) * 6.36e6])
    assert x[near] == pytest.approx((distance * np.sin(np.radians(azimuth)))[near], abs=1e-3)
    assert y[near] == pytest.approx((distance * np.cos(np.radians(azimuth)))[near], abs=1e-3)
