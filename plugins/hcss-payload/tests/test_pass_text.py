"""What the plan says about the pass of a camera: its orbit, the age of its elements, its jitter."""

import math

import pytest
from camera_scenes import PASS, scenario
from hcss_payload.build import payload_of
from hcss_payload.pass_text import assumed, pass_notes
from orbit_inputs import elements

from hcss_twin.providers import Catalog


def pass_of(**sections):
    given = scenario({key: value for key, value in PASS.items() if key not in sections}, sections)
    return given, payload_of(given, Catalog())


def orbit_note(**sections):
    return next(iter(pass_notes(*pass_of(**sections), 0.0)))


def test_the_pass_names_orbit_and_height():
    note = orbit_note()
    assert note.startswith("orbit: circular, 7")
    assert "inclination 98.20 deg" in note


def test_a_sun_synchronous_orbit_names_the_local_time_of_its_node():
    orbit = {"provider": "sun-synchronous", "altitude": 7e5, "local_time": "13:30"}
    assert "ascending node at 13:30 local mean solar time" in orbit_note(orbit=orbit)


@pytest.mark.parametrize("days", [0.5, 2.25, -1.0])
def test_mean_elements_name_their_age_and_what_is_assumed_about_the_earth(days):
    lines = elements("polar", days, seed=1)
    orbit = {"provider": "tle", "lines": list(lines)}
    given, payload = pass_of(orbit=orbit)
    age_days = (given.time - payload.trajectory.epoch).total_seconds() / 86400.0
    side = "before" if age_days >= 0.0 else "after"
    assert f"{abs(age_days):.2f} days {side} the start" in next(iter(pass_notes(given, payload, 0.0)))
    values = {field: why for field, _, why in assumed(given, payload)}
    radius_m = math.hypot(*payload.trajectory.at(0.0))
    turned_m = 2.0 * math.pi * radius_m * 0.9 / 86164.1  # 0.9 s of a sidereal day
    assert values.keys() == {"orbit.dut1", "orbit.pole"}
    assert f"up to {turned_m:.0f} m" in values["orbit.dut1"]


def test_a_stated_orientation_of_the_earth_is_not_assumed():
    orbit = {"provider": "tle", "lines": list(elements("polar", 1.0, seed=1)), "dut1": 0.01, "pole": [0.1, 0.3]}
    assert not list(assumed(*pass_of(orbit=orbit)))
    assert not list(assumed(*pass_of()))


def test_jitter_is_stated_in_microradians_and_pixels():
    *_, note = pass_notes(*pass_of(jitter={"rms": ["30 urad", "20 urad", 0.0]}), 0.0)
    assert note.startswith("jitter: rms 30, 20, 0 urad around x, y, z (0.3, 0.2 pixels")  # a pixel is 100 urad
    *_, none = pass_notes(*pass_of(), 0.0)
    assert none.startswith("jitter: none; [jitter]")
