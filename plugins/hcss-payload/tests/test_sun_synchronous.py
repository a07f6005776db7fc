"""Sun-synchronous orbits: published inclinations, and the sun at their nodes."""

from datetime import UTC, datetime

import numpy as np
import pytest
from camera_scenes import PASS, scenario
from hcss_payload import Circular, PayloadError
from hcss_payload.build import trajectory_of
from hcss_payload.rays import geographic
from hcss_payload.sun_synchronous import inclination_deg, node_hours, sun_synchronous, sun_synchronous_above

from hcss_twin.core.errors import ScenarioError
from hcss_twin.providers import Catalog

START = datetime(2024, 7, 20, 3, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    ("altitude_km", "published_deg"),
    [
        (705.0, 98.2),  # Landsat 8: US Geological Survey
        (786.0, 98.62),  # Sentinel-2: ESA
        (824.0, 98.7),  # Suomi NPP: NOAA
        (500.0, 97.4),  # Wertz, Space Mission Engineering
    ],
)
def test_inclinations_are_those_of_satellites(altitude_km, published_deg):
    assert inclination_deg(1e3 * altitude_km) == pytest.approx(published_deg, abs=0.08)


@pytest.mark.parametrize("altitude_km", [300.0, 500.0, 1400.0, 5800.0])
def test_the_plane_turns_once_a_year_by_the_published_rate(altitude_km):
    # node rate = -1.5 n J2 (R / p)^2 cos i (Vallado), n from Kepler's third law
    axis, tilt = 6378.137 + altitude_km, np.radians(inclination_deg(1e3 * altitude_km))
    motion = np.sqrt(398600.4418 / axis**3)
    rate = -1.5 * motion * 1.0826359e-3 * (6378.137 / axis) ** 2 * np.cos(tilt)
    assert np.degrees(rate) * 86400.0 == pytest.approx(0.98564736, rel=1e-6)


def test_the_local_time_of_the_node_stays_for_a_year():
    orbit = sun_synchronous(500e3, START, 13.5)
    along, _ = orbit.rates_rad_s
    for day in (0, 10, 364):
        turns = np.round(day * 86400.0 * along / (2.0 * np.pi))
        time_s = float(turns * 2.0 * np.pi / along)
        latitude, longitude, altitude = geographic(orbit.at(time_s))
        assert latitude == pytest.approx(0.0, abs=1e-3)
        assert altitude == pytest.approx(500e3, abs=1.0)
        hours = (3.5 + time_s / 3600.0 + longitude / 15.0) % 24.0
        assert hours == pytest.approx(13.5, abs=2e-3)  # seconds in a year
        assert orbit.at(time_s + 1.0)[2] > 0.0  # it ascends


def test_the_descending_node_is_half_a_turn_away():
    orbit = sun_synchronous(500e3, START, 10.5, argument_deg=180.0, ascending=False)
    latitude, longitude, _ = geographic(orbit.at(0.0))
    assert (latitude, (3.5 + longitude / 15.0) % 24.0) == pytest.approx((0.0, 10.5), abs=1e-3)
    assert orbit.at(1.0)[2] < 0.0


def test_an_orbit_above_a_place_has_the_local_time_of_that_pass():
    orbit = sun_synchronous_above(500e3, START, (30.0, 140.0), 60.0)
    latitude, longitude, _ = geographic(orbit.at(60.0))
    assert (latitude, longitude) == pytest.approx((30.0, 140.0), abs=2e-4)
    found = node_hours(orbit, START)
    assert sun_synchronous_above(500e3, START, (30.0, 140.0), 60.0, node=(found, True)) == orbit
    with pytest.raises(
        PayloadError, match=r"trajectory.local_time: 09:00, and the pass above 30 N 140 E has 1"
    ) as told:
        sun_synchronous_above(500e3, START, (30.0, 140.0), 60.0, node=(9.0, True))
    stated = str(told.value).partition("at about ")[2].partition(",")[0]
    shifted = datetime.fromisoformat(stated)
    again = sun_synchronous_above(500e3, shifted, (30.0, 140.0), 0.0, node=(9.0, True))
    assert node_hours(again, shifted) == pytest.approx(9.0, abs=0.05)


def test_precession_is_that_of_sgp4():
    sgp4 = pytest.importorskip("sgp4.model")  # in Python, which tells all elements
    orbit = Circular(700e3, 98.0, precesses=True)
    along, node = orbit.rates_rad_s
    kepler = np.sqrt(398600.4418 / 7078.137**3) * 60.0
    satellite, motion = sgp4.Satrec(), kepler
    for _ in range(3):  # the elements' mean motion is another one than Kepler's
        satellite.sgp4init(
            sgp4.WGS72, "i", 1, 27000.0, 0.0, 0.0, 0.0, 1e-6, 0.0, np.radians(98.0), 0.0, motion, 0.0
        )  # fmt: skip
        motion *= kepler / satellite.no_unkozai
    assert node + 7.292115e-5 == pytest.approx(satellite.nodedot / 60.0, rel=5e-3)
    assert along == pytest.approx((satellite.mdot + satellite.argpdot) / 60.0, rel=1e-5)
    assert abs(along * 60.0 / kepler - 1.0) > 1e-3


def test_a_scenario_takes_times_of_day_and_is_read_again():
    import json

    import hcss_twin

    keys = {"provider": "sun-synchronous", "altitude": "500 km", "local_time": "13:30", "node": "descending"}
    one = scenario({**PASS, "orbit": None}, {"orbit": keys})
    again = hcss_twin.Scenario.from_dict(json.loads(one.to_json()))
    assert trajectory_of(again, Catalog()) == trajectory_of(one, Catalog())
    assert trajectory_of(one, Catalog()).inclination_deg == inclination_deg(500e3)


def test_an_orbit_with_an_epoch_does_not_depend_on_the_start():
    for keys in (
        {"provider": "sun-synchronous", "altitude": 5e5, "local_time": 13.5, "argument": 20.0},
        {"altitude": 5e5, "inclination": 60.0, "node_longitude": 30.0, "argument": 10.0},
        {"altitude": 5e5, "inclination": 60.0, "above": [30.0, 140.0], "above_time": 100.0},
    ):
        keys = keys | {"epoch": "2024-04-20T12:00:00+00:00"}
        early, late = (
            trajectory_of(scenario({**PASS, "orbit": None}, {"orbit": keys, "time": time}), Catalog())
            for time in ("2024-04-20T12:00:00+00:00", "2024-04-21T15:00:00+02:00")
        )
        assert late.at(30.0) == pytest.approx(early.at(25 * 3600.0 + 30.0), abs=0.01)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"altitude": "500 km"}, "needs local_time, or above"),
        ({"altitude": "500 km", "local_time": "25:00"}, "not a local time; allowed"),
        ({"altitude": "500 km", "local_time": "12:00", "inclination": 98.0}, "inclination given with provider"),
        ({"local_time": "12:00"}, "'sun-synchronous' needs altitude"),
        ({"altitude": "6500 km", "local_time": "12:00"}, "allowed for sun-synchronous orbits: 100 to 5900 km"),
    ],
)
def test_wrong_keys_are_named(keys, message):
    with pytest.raises(ScenarioError, match=message):
        trajectory_of(scenario({**PASS, "orbit": None}, {"orbit": {"provider": "sun-synchronous", **keys}}), Catalog())


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"file": "a.tle"}, "default, needs altitude, inclination; with file: provider = 'tle', 'omm', 'oem', 'table'"),
        ({"altitude": 5e5, "local_time": "13:30"}, "with altitude, local_time: provider = 'sun-synchronous'"),
        ({"altitude": 5e5, "argument": 3.0, "longitude": 10.0}, "'circular', the default, needs inclination$"),
    ],
)  # fmt: skip
def test_keys_of_another_provider_name_it(keys, message):
    with pytest.raises(ScenarioError, match=message):
        trajectory_of(scenario({**PASS, "orbit": None}, {"orbit": keys}), Catalog())
