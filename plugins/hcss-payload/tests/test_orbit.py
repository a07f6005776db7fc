"""Positions against astropy and Skyfield, and laws of the other trajectories."""

from datetime import timedelta

import numpy as np
import pytest
from hcss_payload import (
    Circular,
    EarthOrientation,
    Geostationary,
    PayloadError,
    PositionTable,
    TwoLineElements,
    read_oem,
    write_oem,
)
from hcss_payload.trajectory import velocity_m_s
from payload_scenes import LINES, START

from hcss_twin.physics.geodesy import altitude_m


def astropy_orientation(time):
    from astropy.utils import iers

    table = iers.IERS_B.open()
    x, y = (value.to_value("arcsec") for value in table.pm_xy(time))
    return EarthOrientation(float(table.ut1_utc(time).to_value("s")), (float(x), float(y)))


def test_elements_agree_with_astropy_within_half_a_metre():
    pytest.importorskip("sgp4")
    pytest.importorskip("astropy", reason="the reference is not installed")
    from astropy import units
    from astropy.coordinates import ITRS, TEME, CartesianRepresentation
    from astropy.time import Time
    from astropy.utils import iers
    from sgp4.api import Satrec

    iers.conf.auto_download = False
    time_s = 1234.5
    time = Time(START, scale="utc") + time_s * units.s
    orbit = TwoLineElements(*LINES, START, astropy_orientation(time))
    _, kilometres, _ = Satrec.twoline2rv(*LINES).sgp4(time.jd1, time.jd2)
    with iers.earth_orientation_table.set(iers.IERS_B.open()):
        teme = TEME(CartesianRepresentation(kilometres, unit="km"), obstime=time)
        expected = teme.transform_to(ITRS(obstime=time)).cartesian.xyz.to_value("m")
    assert np.linalg.norm(orbit.at(time_s) - expected) < 0.5


def test_elements_agree_with_skyfield_over_a_day():
    skyfield = pytest.importorskip("skyfield.api", reason="the reference is not installed")
    from skyfield.framelib import itrs

    timescale = skyfield.load.timescale(builtin=True)
    satellite = skyfield.EarthSatellite(*LINES, "like Landsat", timescale)
    for hour in (0, 7, 24):
        moment = timescale.from_datetime(START + timedelta(hours=hour))
        orbit = TwoLineElements(*LINES, START, EarthOrientation(float(moment.dut1)))
        expected = satellite.at(moment).frame_xyz(itrs).m
        assert np.linalg.norm(orbit.at(3600.0 * hour) - expected) < 1.0


@pytest.mark.parametrize("frame", ["GCRF", "TEME"])
@pytest.mark.parametrize("scale", ["UTC", "TAI", "TT"])
def test_messages_in_frames_that_do_not_turn_agree_with_astropy(frame, scale, tmp_path):
    pytest.importorskip("erfa")
    pytest.importorskip("astropy", reason="the reference is not installed")
    from astropy import units
    from astropy.coordinates import GCRS, ITRS, TEME, CartesianRepresentation
    from astropy.time import Time
    from astropy.utils import iers

    orbit = Circular(700e3, 98.2)
    moments = Time(START, scale="utc") + np.arange(0.0, 601.0, 30.0) * units.s  # 21 states
    lines = [
        f"CCSDS_OEM_VERS = 2.0\nMETA_START\nCENTER_NAME = EARTH\nREF_FRAME = {frame}\nTIME_SYSTEM = {scale}\nMETA_STOP"
    ]
    with iers.earth_orientation_table.set(iers.IERS_B.open()):
        for moment, time_s in zip(moments, np.arange(0.0, 601.0, 30.0), strict=True):
            fixed = ITRS(CartesianRepresentation(orbit.at(time_s), unit="m"), obstime=moment)
            other = fixed.transform_to(GCRS(obstime=moment) if frame == "GCRF" else TEME(obstime=moment))
            stamp = getattr(moment, scale.lower()).isot
            lines.append(f"{stamp} " + " ".join(f"{x:.6f}" for x in other.cartesian.xyz.to_value("km")))
    (tmp_path / "orbit.oem").write_text("\n".join(lines))
    message = read_oem(tmp_path / "orbit.oem", START, astropy_orientation(moments[10]))
    for time_s in (0.0, 45.0, 311.0, 600.0):
        assert np.linalg.norm(message.at(time_s) - orbit.at(time_s)) < 0.5


def test_a_time_within_a_leap_second_is_told(tmp_path):
    path = tmp_path / "orbit.oem"
    write_oem(path, Circular(500e3, 51.6), START, [0.0, 60.0, 120.0], "TEST")
    path.write_text(path.read_text().replace("02:31:00.000000 ", "23:59:60.5 "))
    with pytest.raises(PayloadError, match=r"'2024-04-20T23:59:60\.5' is within a leap second; allowed: UTC"):
        read_oem(path, START)


def test_geostationary_satellite_does_not_move():
    orbit = Geostationary(140.7)
    assert altitude_m(orbit.at(0.0)) == pytest.approx(35_786e3, abs=1e3)
    assert np.array_equal(orbit.at(0.0), orbit.at(1e5))


def test_circular_orbit_keeps_kepler_and_its_node():
    orbit = Circular(700e3, 98.2, node_longitude_deg=170.0)
    assert orbit.at(0.0) / np.linalg.norm(orbit.at(0.0)) == pytest.approx(
        [np.cos(np.radians(170)), np.sin(np.radians(170)), 0.0]
    )
    radius = np.linalg.norm(orbit.at(0.0))
    period = 2 * np.pi * np.sqrt(radius**3 / 3.986004418e14)
    after = orbit.at(period)
    # One turn later at the same latitude, west by the rotation of the Earth.
    assert after[2] == pytest.approx(0.0, abs=1e-3)
    west = np.radians(170.0) - np.arctan2(after[1], after[0])
    assert west == pytest.approx(7.292115e-5 * period)
    assert np.linalg.norm(velocity_m_s(orbit, 10.0)) == pytest.approx(7.6e3, rel=0.02)


def test_table_and_message_return_the_orbit(tmp_path):
    orbit = Circular(500e3, 51.6)
    times = np.arange(0.0, 1201.0, 60.0)
    table = PositionTable(times, np.array([orbit.at(time) for time in times]))
    write_oem(tmp_path / "orbit.oem", orbit, START, times, "TEST")
    message = read_oem(tmp_path / "orbit.oem", START)
    for time in (0.0, 17.3, 601.0, 1200.0):
        assert np.linalg.norm(table.at(time) - orbit.at(time)) < 0.01
        assert np.linalg.norm(message.at(time) - orbit.at(time)) < 0.01
    assert (
        np.linalg.norm(read_oem(tmp_path / "orbit.oem", START + timedelta(seconds=60)).at(0.0) - orbit.at(60.0)) < 1e-3
    )
    with pytest.raises(PayloadError, match="time 1201 s; the table holds 0 to 1200 s"):
        message.at(1201.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ITRF2020", "TOD", "REF_FRAME TOD; allowed: ITRF, TEME, GCRF, ICRF, EME2000"),
        ("= UTC", "= TDB", "TIME_SYSTEM TDB; allowed: UTC, TAI, GPS, TT"),
        ("CCSDS_OEM_VERS", "CCSDS_OPM_VERS", "no CCSDS_OEM_VERS"),
        ("T02:31:00", "T02:xx", "no time with numbers"),
    ],
)
def test_other_messages_are_refused_by_name(tmp_path, old, new, message):
    path = tmp_path / "orbit.oem"
    write_oem(path, Circular(500e3, 51.6), START, [0.0, 60.0, 120.0], "TEST")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(PayloadError, match=message):
        read_oem(path, START)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Circular(5e4, 98.0), "trajectory.altitude_m: 50000 m; allowed: 100000 to 1e.08 m; closest.* 100000"),
        (lambda: Circular(float("nan"), 98.0), "trajectory.altitude_m: nan m; allowed"),
        (lambda: PositionTable([0.0, 0.0], np.zeros((2, 3))), "times_s: 2 times; allowed: two or more, each later"),
        (lambda: PositionTable([0.0, 1.0], np.zeros((3, 3))), r"positions_m: shape \(3, 3\); allowed: \(2, 3\)"),
        (lambda: TwoLineElements(LINES[0][:-1] + "x", LINES[1], START), "line1: .* checksum"),
        (lambda: TwoLineElements(*LINES, START.replace(tzinfo=None)), "start: .* a time in UTC"),
    ],
)
def test_wrong_parameters_are_named(make, message):
    with pytest.raises(PayloadError, match=message):
        make()
