"""Attitudes at poles, the date line, through 180 degrees and in messages."""

import numpy as np
import pytest
from hcss_payload import (
    AttitudeTable,
    Circular,
    Nadir,
    PayloadError,
    PositionTable,
    PushBroom,
    Track,
    pose_at,
    read_aem,
    write_aem,
)
from hcss_payload.mesh import Mesh
from hcss_payload.rays import geographic
from payload_scenes import START, camera
from scipy.spatial.transform import Rotation

from hcss_twin.physics.geodesy import Ellipsoid


def above(latitude, longitude, height=700e3):
    """A trajectory that rests above a place."""
    position = Ellipsoid.to_earth_centred(np.float64(latitude), np.float64(longitude), height)
    return PositionTable([0.0, 1.0], [position, position])


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [(90.0, 180.0), (-90.0, -180.0), (89.9999999, 179.99), (0.0, 180.0), (0.0, 0.0), (45.0, -180.0), (45.0, 179.99)],
)
def test_nadir_sees_the_place_below_at_poles_and_date_line(latitude, longitude):
    trajectory = above(latitude, longitude)
    pose = pose_at(0.5, trajectory, Nadir(trajectory))
    mesh = Mesh(camera(41, 8.0), pose)
    positions = mesh.positions_m()
    assert np.all(np.isfinite(positions))
    below = Ellipsoid.to_earth_centred(np.float64(latitude), np.float64(longitude))
    assert np.linalg.norm(mesh.exact_m(np.float64(20.0), np.float64(20.0)) - below) < 1e-2
    seen_latitude, seen_longitude, height = geographic(positions)
    # The interpolated points sink below the surface, in the middle of a block by its sagitta.
    assert np.abs(height).max() < (8 * 2500.0) ** 2 / 8 / 6.3e6 * 2
    if abs(latitude) < 80.0:
        assert seen_latitude[0, 20] > seen_latitude[40, 20]  # north is up
        east = (seen_longitude[20, 40] - seen_longitude[20, 0]) % 360.0
        assert 0.0 < east < 10.0  # and east right, also across the date line


def test_tracking_over_the_pole_keeps_the_target():
    orbit = Circular(700e3, 90.0, argument_deg=80.0)
    track = Track(orbit, 90.0, 0.0)
    for time in np.linspace(0.0, 400.0, 41):
        pose = pose_at(time, orbit, track)
        row, column = camera(64, 2.0).pixels(pose.to_body(track.target_m - pose.position_m))
        assert (row, column) == pytest.approx((31.5, 31.5), abs=0.02)


@pytest.mark.parametrize(
    ("bearing", "away"), [(0, 0.5), (45, 4.0), (90, 12.0), (135, 0.5), (180, 4.0), (225, 12.0), (270, 0.5), (315, 4.0)]
)
def test_tracking_shows_north_of_the_place_straight_above_it_from_any_side(bearing, away):
    place = np.array([36.7, -6.5])
    toward = away * np.array([np.cos(np.radians(bearing)), np.sin(np.radians(bearing)) / np.cos(np.radians(place[0]))])
    rest = above(*(place + toward))
    pose, optics = pose_at(0.5, rest, Track(rest, *place)), camera(64, 2.0)
    north = Ellipsoid.to_earth_centred(np.float64(place[0] + 0.005), np.float64(place[1]), 0.0)
    row, column = optics.pixels(pose.to_body(north - pose.position_m))
    assert row < 31.5 - 0.05
    assert abs(column - 31.5) < 1e-3 * (31.5 - row)


def test_push_broom_turns_smoothly_over_the_pole_and_the_date_line():
    orbit = Circular(700e3, 90.0, node_longitude_deg=179.99, argument_deg=80.0)
    turns = Rotation.from_quat([pose_at(t, orbit, PushBroom(orbit)).quaternion for t in np.arange(0.0, 400.0, 5.0)])
    assert np.degrees((turns[:-1].inv() * turns[1:]).magnitude()).max() < 0.6  # the orbit turns .3 deg in 5 s


def test_table_passes_180_degrees_the_short_way_with_either_sign():
    angles = np.radians([170.0, 178.0, 186.0, 194.0])
    unit = Rotation.from_rotvec(angles[:, None] * np.array([0.0, 0.0, 1.0])).as_quat()
    table = AttitudeTable([0.0, 1.0, 2.0, 3.0], unit * np.array([[1.0], [-1.0], [1.0], [-1.0]]))
    for time in np.linspace(0.0, 3.0, 31):
        expected = Rotation.from_rotvec([0.0, 0.0, np.radians(170.0 + 8.0 * time)])
        assert (expected.inv() * Rotation.from_quat(table.at(time))).magnitude() < 1e-9


def test_attitude_message_returns_the_attitude(tmp_path):
    orbit = Circular(700e3, 98.2, 170.0)
    attitude, times = PushBroom(orbit, roll_deg=10.0), np.arange(0.0, 61.0, 1.0)
    write_aem(tmp_path / "a.aem", attitude, START, times, "TEST")
    for old, new in (("A2B", "A2B"), ("ITRF2020", "ITRF97")):
        text = (tmp_path / "a.aem").read_text().replace(old, new)
        (tmp_path / "b.aem").write_text(text)
        table = read_aem(tmp_path / "b.aem", START)
        for time in (0.0, 12.5, 60.0):
            turn = Rotation.from_quat(attitude.at(time)).inv() * Rotation.from_quat(table.at(time))
            assert turn.magnitude() < 2e-6


def test_directions_of_attitude_messages_are_inverse(tmp_path):
    orbit = Circular(700e3, 98.2, 170.0)
    write_aem(tmp_path / "a.aem", Nadir(orbit), START, [0.0, 1.0], "TEST")
    text = (tmp_path / "a.aem").read_text()
    swapped = text.replace("REF_FRAME_A = ITRF2020", "REF_FRAME_A = SC_BODY_1").replace(
        "REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = ITRF2020"
    )
    first = read_aem(tmp_path / "a.aem", START).at(0.0)
    for name, body in (("frames", swapped), ("direction", text.replace("A2B", "B2A"))):
        (tmp_path / name).write_text(body)
        other = read_aem(tmp_path / name, START).at(0.0)
        assert (Rotation.from_quat(first) * Rotation.from_quat(other)).magnitude() < 1e-9
    (tmp_path / "both").write_text(swapped.replace("A2B", "B2A"))
    assert read_aem(tmp_path / "both", START).at(0.0) == pytest.approx(first)


def test_attitudes_without_meaning_are_refused(tmp_path):
    rest = above(10.0, 20.0)
    with pytest.raises(PayloadError, match="push-broom without motion"):
        PushBroom(rest).at(0.5)
    with pytest.raises(PayloadError, match=r"the place -10 N -160 E is below the horizon at time 0\.5 s"):
        Track(rest, -10.0, -160.0).at(0.5)
    write_aem(tmp_path / "a.aem", Nadir(rest), START, [0.0, 1.0], "TEST")
    text = (tmp_path / "a.aem").read_text()
    (tmp_path / "a.aem").write_text(text.replace("ITRF2020", "EME2000"))
    with pytest.raises(PayloadError, match="REF_FRAME_A EME2000; allowed: ITRF, SC_"):
        read_aem(tmp_path / "a.aem", START)
