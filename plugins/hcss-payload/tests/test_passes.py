"""Passes against Skyfield, and what commands and refusals tell of them."""

import json
import re
import sys
from datetime import datetime, timedelta

import numpy as np
import pytest
from camera_scenes import PASS, STARING, scenario
from click.testing import CliRunner
from hcss_payload import EarthOrientation, Geostationary, PositionTable, TwoLineElements
from hcss_payload.camera_rays import make_rays
from hcss_payload.checks import PayloadError
from hcss_payload.passes import direction_deg, find_passes
from hcss_payload.passes_command import passes
from hcss_payload.sun_synchronous import sun_synchronous
from payload_scenes import LINES, START

from hcss_twin.core.errors import ScenarioError
from hcss_twin.providers import Catalog

PLACE = (30.0, 140.0)


@pytest.mark.parametrize(("place", "lowest"), [(PLACE, 15.0), ((-61.0, 17.0), 0.0), ((0.3, -179.9), 40.0)])
def test_passes_are_those_of_skyfield_within_a_second(place, lowest):
    skyfield = pytest.importorskip("skyfield.api", reason="the reference is not installed")
    timescale = skyfield.load.timescale(builtin=True)
    satellite = skyfield.EarthSatellite(*LINES, "like Landsat", timescale)
    ground = skyfield.wgs84.latlon(*place)
    begin, end = (timescale.from_datetime(START + timedelta(days=day)) for day in (0, 4))
    times, kinds = satellite.find_events(ground, begin, end, altitude_degrees=lowest)
    expected = [(time.utc_datetime(), int(kind)) for time, kind in zip(times, kinds, strict=True)]
    orbit = TwoLineElements(*LINES, START, EarthOrientation(float(begin.dut1)))
    found = find_passes(orbit, place, START, 0.0, 4 * 86400.0, lowest)
    events = [
        (time_s, kind)
        for one in found
        for kind, time_s in enumerate((one.rise_s, one.highest_s, one.set_s))
        if time_s not in (None, 0.0)  # a pass may have begun before, and have been higher
    ]
    assert len(found) >= 2
    assert [kind for _, kind in events] == [kind for _, kind in expected]
    for (time_s, _), (moment, _) in zip(events, expected, strict=True):
        assert abs(time_s - (moment - START).total_seconds()) < 1.0
    for one in found:
        moment = timescale.from_datetime(START + timedelta(seconds=one.highest_s))
        altitude, azimuth, _ = (satellite - ground).at(moment).altaz()
        assert one.highest_deg == pytest.approx(altitude.degrees, abs=0.02)
        assert abs(one.azimuth_deg - azimuth.degrees) < 0.05 / np.cos(np.radians(one.highest_deg))


def test_the_sun_is_that_of_skyfield():
    pytest.importorskip("astropy", reason="the reference is not installed")
    from astropy import units
    from astropy.coordinates import AltAz, EarthLocation, get_sun
    from astropy.time import Time
    from astropy.utils import iers

    iers.conf.auto_download = False
    for one in find_passes(sun_synchronous(500e3, START, 13.5), PLACE, START, 0.0, 86400.0):
        time = Time(START, scale="utc") + one.highest_s * units.s
        location = EarthLocation(lat=PLACE[0] * units.deg, lon=PLACE[1] * units.deg)
        with iers.earth_orientation_table.set(iers.IERS_B.open()):
            altitude = get_sun(time).transform_to(AltAz(obstime=time, location=location)).alt.deg
        assert one.sun_deg == pytest.approx(altitude, abs=0.05 if altitude > 5.0 else 0.6)  # refracted


def test_a_pass_is_above_its_lowest_elevation_between_rise_and_set():
    orbit = sun_synchronous(500e3, START, 13.5)
    found = find_passes(orbit, PLACE, START, 0.0, 3 * 86400.0, 20.0)
    every = np.array([direction_deg(orbit, PLACE, time_s)[0] for time_s in np.arange(0.0, 3 * 86400.0, 10.0)])
    starts = np.flatnonzero((every[1:] > 20.0) & (every[:-1] <= 20.0))
    assert len(starts) == len(found)
    for one, before in zip(found, starts, strict=True):
        assert 10.0 * before <= one.rise_s <= 10.0 * (before + 1)
        assert direction_deg(orbit, PLACE, one.set_s)[0] == pytest.approx(20.0, abs=1e-4)
        assert one.highest_deg >= max(every[int(one.rise_s // 10) + 1 : int(one.set_s // 10) + 1])


def test_a_satellite_that_stays_has_one_pass_without_ends():
    (one,) = find_passes(Geostationary(140.7), PLACE, START, 0.0, 86400.0)
    assert (one.rise_s, one.set_s) == (None, None)
    assert one.highest_deg == pytest.approx(54.9, abs=0.3)
    assert find_passes(Geostationary(-40.0), PLACE, START, 0.0, 86400.0) == ()


def test_a_table_knows_no_passes_beyond_its_times():
    orbit = sun_synchronous(500e3, START, 13.5)
    (first, *_) = find_passes(orbit, PLACE, START, 0.0, 86400.0)
    times = np.arange(first.rise_s - 300.0, first.highest_s + 60.0, 20.0)
    table = PositionTable(times, np.array([orbit.at(time) for time in times]))
    (found,) = find_passes(table, PLACE, START, 0.0, 86400.0)
    assert found.rise_s == pytest.approx(first.rise_s, abs=0.01)
    assert found.highest_s == pytest.approx(first.highest_s, abs=0.1)
    assert found.set_s is None


def test_a_view_below_the_horizon_tells_the_next_pass():
    orbit = {"provider": "sun-synchronous", "altitude": "700 km", "local_time": "13:30"}
    one = scenario({**PASS, "orbit": None}, {"orbit": orbit})
    with pytest.raises(ScenarioError, match=r"is below the horizon at time 0 s; .* above 15 deg at 30 N") as told:
        make_rays(one, Catalog())
    stated = str(told.value).partition(" deg, at ")[2].partition(" ")[0]
    start = datetime.fromisoformat(stated)
    trajectory = sun_synchronous(700e3, one.time, 13.5)
    assert direction_deg(trajectory, (30.0, 150.0), (start - one.time).total_seconds())[0] > 15.0


def test_a_pass_that_never_comes_is_told():
    orbit = {"provider": "geostationary", "longitude": -30.0}
    one = scenario(STARING, {"attitude": {"provider": "track"}, "orbit": orbit})
    with pytest.raises(ScenarioError, match=r"no pass above 15 deg at 0 N 140.7 E within 3 days"):
        make_rays(one, Catalog())


def test_the_command_lists_passes_as_text_and_as_json(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        "time = 2024-07-20T12:30:00+09:00\nplace = {latitude = 30.0, longitude = 140.0}\n"
        '[orbit]\nprovider = "sun-synchronous"\naltitude = "500 km"\nlocal_time = 13:30:00\n'
    )
    told = CliRunner().invoke(passes, [str(path), "--days", "2"])
    assert told.exit_code == 0, told.output
    listed = json.loads(CliRunner().invoke(passes, [str(path), "--days", "2", "--json"]).stdout)["passes"]
    assert len(listed) == len(told.stdout.splitlines()) - 2
    assert listed[0]["highest"][:19] in told.output
    assert all(one["elevation_deg"] > 15.0 for one in listed)
    none = CliRunner().invoke(passes, [str(path), "--days", "0.001"])
    assert none.stdout.startswith("0 passes above 15 deg")


def test_a_missing_package_is_no_sky_without_passes(monkeypatch):
    monkeypatch.setitem(sys.modules, "sgp4.api", None)
    orbit = TwoLineElements(*LINES, START, EarthOrientation(0.0))
    with pytest.raises(PayloadError, match=re.escape("pip install 'hcss-payload[tle]'")):
        find_passes(orbit, PLACE, START, 0.0, 86400.0)
