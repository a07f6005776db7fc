"""What a platform says about view, pixels and motion, and what contradicts it."""

import json
import math

import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.physics.viewing import slant_range_m

RAW = {"time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35, "longitude": 150}}
ALTITUDE = {"altitude": "800 km"}
OPTICS = {"focal_length": "400 mm", "detector_pitch": "15 um"}
RADIUS_M = 6371008.7714
CUBE = {
    "image": {"rows": 4, "columns": 4},
    "frames": {"count": 1},
    "output": {"variables": ["cloud_mask"]},
    **{key.split(".")[0]: {key.split(".")[1]: value} for key, value in CHEAP.items()},
}


def scenario(platform, **sections):
    return Scenario.from_dict({**RAW, "platform": platform, **sections})


def test_the_plan_says_how_long_the_footprints_of_detectors_are():
    told = [make_plan(scenario({**ALTITUDE, **OPTICS}, view={"zenith": zenith}, **CUBE)).notes for zenith in (0, 60)]
    assert not any("footprint" in note for note in told[0])
    size = slant_range_m(60.0, 800e3) * 15e-6 / 0.4
    assert any(f"{size:.4g} m; along" in note and f"{2 * size:.4g} m long" in note for note in told[1])


def again(one, overrides=None):
    return Scenario.from_dict(json.loads(one.to_json()), overrides, base=one.base)


def test_a_look_angle_is_the_other_way_of_saying_the_view_zenith():
    found = scenario({**ALTITUDE, "off_nadir": 30})
    sine = (RADIUS_M + 800e3) / RADIUS_M * math.sin(math.radians(30))
    assert found.view.zenith == pytest.approx(math.degrees(math.asin(sine)), rel=1e-12)
    assert found.view.azimuth == 0.0


@pytest.mark.parametrize(("latitude", "longitude"), [(35.0, 150.0), (-20.0, 140.7), (0.0, 100.0), (60.0, -170.0)])
def test_a_geostationary_sensor_is_seen_in_the_direction_of_projs_vectors(latitude, longitude):
    from pyproj import Transformer

    output = {"variables": ["pixel_view_zenith"]}
    platform = scenario({"longitude": 140.7}, place={"latitude": latitude, "longitude": longitude}, output=output)
    assert platform.platform.altitude == pytest.approx(35_786_000, rel=1e-5)
    # topocentric coordinates of PROJ (EPSG method 9837)
    axes = f"+proj=pipeline +step +proj=cart +step +proj=topocentric +lat_0={latitude} +lon_0={longitude} +h_0=0"
    east, north, up = Transformer.from_pipeline(axes).transform(140.7, 0.0, platform.platform.altitude)
    zenith, azimuth = math.degrees(math.atan2(math.hypot(east, north), up)), math.degrees(math.atan2(east, north))
    assert (platform.view.zenith, platform.view.azimuth) == pytest.approx((zenith, azimuth % 360.0), abs=1e-9)
    assert again(platform) == platform
    assert again(platform, {"platform.longitude": 150.0}).view != platform.view


def test_what_contradicts_a_geostationary_sensor_is_refused():
    # on a sphere: cos c = cos 35 cos 80.7; 90 - atan((cos c - R / r) / sin c) = 91.09
    wrong = {
        "given with view.azimuth": {"view": {"azimuth": 10.0}},
        "zenith 91.08 deg from 35, 60": {"place": {"latitude": 35, "longitude": 60}},
        "allowed: mode = 'staring'": {"motion": {"platform_speed": "orbit"}},
    }
    for words, sections in wrong.items():
        with pytest.raises(ScenarioError, match=words):
            scenario({"longitude": 140.7}, **sections)


def test_pitch_and_focal_length_are_the_other_way_of_saying_the_size_of_pixels():
    # 15 um / 400 mm from 800 km.
    assert scenario({**ALTITUDE, **OPTICS}).image.pixel_size == pytest.approx(30.0, rel=1e-12)
    slant = scenario({**ALTITUDE, **OPTICS, "off_nadir": 45}).image.pixel_size
    said = scenario({**ALTITUDE, **OPTICS}, view={"zenith": 52.740093943449025}).image.pixel_size
    assert slant == pytest.approx(said, rel=1e-12)
    assert slant == pytest.approx(15e-6 / 0.4 * 1213.45e3, rel=1e-4)


@pytest.mark.parametrize(
    ("platform", "motion", "speed"),
    [
        (ALTITUDE, {}, 0.0),
        (ALTITUDE, {"platform_speed": "orbit"}, 6623.79),
        ({**ALTITUDE, "mode": "push-broom"}, {}, 6623.79),
        ({**ALTITUDE, "mode": "push-broom"}, {"platform_speed": "orbit"}, 6623.79),
        ({**ALTITUDE, "mode": "push-broom"}, {"platform_speed": "1 km/s"}, 1000.0),
        ({**ALTITUDE, "mode": "staring"}, {}, 0.0),
        ({**ALTITUDE, "mode": "staring"}, {"platform_speed": 0}, 0.0),
        ({}, {"platform_speed": -7500}, -7500.0),
    ],
)
def test_the_footprint_moves_as_mode_and_speed_say(platform, motion, speed):
    found = scenario(platform, motion=motion)
    assert found.motion.platform_speed == pytest.approx(speed, abs=0.01)
    assert again(found) == found


def test_a_scenario_with_a_platform_survives_json_and_overrides():
    found = scenario({**ALTITUDE, **OPTICS, "off_nadir": 30, "mode": "push-broom"})
    same, higher = again(found), again(found, {"platform.altitude": "900 km"})
    assert (same.view, same.image, same.motion) == (found.view, found.image, found.motion)
    assert higher.view.zenith > found.view.zenith
    assert higher.image.pixel_size > found.image.pixel_size
    assert higher.motion.platform_speed < found.motion.platform_speed
    assert again(found, {"motion.platform_speed": 1000}).motion.platform_speed == 1000.0


@pytest.mark.parametrize(
    ("platform", "sections", "field", "words"),
    [
        ({"off_nadir": 30}, {}, "platform.altitude", ["is required with off_nadir", "100 km to 42000 km"]),
        ({"mode": "staring"}, {}, "platform.altitude", ["is required with mode"]),
        ({"altitude": "99 km"}, {}, "platform.altitude", ["out of range", "closest valid choice is 100000"]),
        ({"altitude": "42 Mm"}, {}, "platform.altitude", ["'Mm' is not a unit"]),
        (
            {**ALTITUDE, "off_nadir": 30},
            {"view": {"zenith": 0}},
            "platform.off_nadir",
            ["30 deg given with view.zenith 0 deg", "one of them"],
        ),
        ({**ALTITUDE, "off_nadir": 70}, {}, "platform.off_nadir", ["misses the Earth", "choice is 62.258"]),
        ({**ALTITUDE, "off_nadir": 62.5}, {}, "platform.off_nadir", ["meets the ground at zenith 86"]),
        (
            {**ALTITUDE, **OPTICS},
            {"image": {"pixel_size": 20}},
            "platform.detector_pitch",
            ["with image.pixel_size 20 m", "one of them"],
        ),
        ({**ALTITUDE, "focal_length": 1}, {}, "platform.detector_pitch", ["required with focal_length"]),
        ({**ALTITUDE, "detector_pitch": 1e-5}, {}, "platform.focal_length", ["required with detector_pitch"]),
        (
            {**ALTITUDE, "focal_length": "1 mm", "detector_pitch": "1 cm"},
            {},
            "platform.detector_pitch",
            ["pixels of 8e+06 m", "to 100000 m"],
        ),
        (
            {**ALTITUDE, "mode": "staring"},
            {"motion": {"platform_speed": 1000}},
            "platform.mode",
            ["'staring' with motion.platform_speed 1000.0"],
        ),
        (
            {**ALTITUDE, "mode": "push-broom"},
            {"motion": {"platform_speed": 0}},
            "platform.mode",
            ["'push-broom' with motion.platform_speed 0", "'orbit'"],
        ),
        ({**ALTITUDE, "mode": "pushbroom"}, {}, "platform.mode", ["closest is 'push-broom'"]),
        ({}, {"motion": {"platform_speed": "orbit"}}, "motion.platform_speed", ["without platform.altitude"]),
        (ALTITUDE, {"motion": {"platform_speed": "orbits"}}, "motion.platform_speed", ["closest is 'orbit'"]),
        (ALTITUDE, {"motion": {"platform_speed": "mach 3"}}, "motion.platform_speed", ["m/s"]),
        (ALTITUDE, {"motion": {"platform_speed": True}}, "motion.platform_speed", ["not a speed"]),
        (
            ALTITUDE,
            {"motion": {"platform_speed": "200 km/s"}},
            "motion.platform_speed",
            ["'200 km/s' is out of range", "closest valid choice is 100000"],
        ),
        (
            {},
            {"output": {"variables": ["pixel_view_zenith"]}},
            "output.variables",
            ["altitude of the sensor is not known", "with platform.altitude"],
        ),
    ],
)
def test_what_contradicts_the_platform_is_refused_by_name(platform, sections, field, words):
    with pytest.raises(ScenarioError) as caught:
        scenario(platform, **sections)
    (problem,) = caught.value.problems
    assert problem.field == field
    for word in words:
        assert word in problem.message


@pytest.mark.parametrize(
    ("platform", "sections"),
    [
        ({**ALTITUDE, "off_nadir": 30}, {"view": {"zenith": 34.2525}}),  # asin((1 + 800 / 6371) sin 30)
        ({**ALTITUDE, **OPTICS}, {"image": {"pixel_size": 30}}),  # 15 um / 400 mm x 800 km
        ({"longitude": 150.0, "altitude": "35786 km"}, {"view": {"azimuth": 180}}),  # south of a place north of it
    ],
)
def test_keys_that_agree_with_the_platform_are_accepted(platform, sections):
    alone, both = scenario(platform), scenario(platform, **sections)
    assert (both.view, both.image.pixel_size) == (alone.view, alone.image.pixel_size)
    assert again(both).view == both.view
    ((section, keys),) = sections.items()
    with pytest.raises(ScenarioError, match="or both within"):
        scenario(platform, **{section: {name: 1.1 * value for name, value in keys.items()}})


def test_a_satellite_above_one_place_is_geostationary():
    with pytest.raises(ScenarioError, match=r"longitude: with platform\.altitude 700 km, where no satellite stays"):
        scenario({"longitude": 150.0, "altitude": "700 km"})


def test_all_contradictions_are_told_at_once():
    with pytest.raises(ScenarioError) as caught:
        scenario(
            {**ALTITUDE, **OPTICS, "off_nadir": 30, "mode": "staring"},
            view={"zenith": 20},
            image={"pixel_size": 30},
            motion={"platform_speed": 7000},
        )
    assert [problem.field for problem in caught.value.problems] == [
        "platform.off_nadir",
        "platform.detector_pitch",
        "platform.mode",
    ]
