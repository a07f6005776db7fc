"""Trajectories: right ones are read as SGP4 and sidereal time have them, impossible ones refused, doubtful ones noted.

Inputs (``orbit_inputs.py``) were made before the readers were tried.
"""

import os
import re
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("sgp4")
pytest.importorskip("erfa", reason="the reference is not installed")

import orbit_inputs
from hcss_payload import Circular, EarthOrientation, PayloadError, PositionTable, TwoLineElements, read_oem
from hcss_payload.examination import examine, examine_place
from hcss_payload.mean_elements import read_elements
from payload_scenes import LINES, START


def examined(given, folder):
    """Trajectory and notes of an input."""
    if given.content is not None:
        (folder / given.orbit["file"]).write_bytes(given.content)
    if "lines" in given.orbit:
        trajectory = TwoLineElements(*given.orbit["lines"], given.start)
    elif given.orbit["provider"] in ("tle", "omm"):
        trajectory = read_elements(folder / given.orbit["file"], given.start, EarthOrientation())
    else:
        trajectory = read_oem(folder / given.orbit["file"], given.start)
    return trajectory, examine(trajectory, 0.0, 60.0)


def test_right_orbits_are_read_and_not_questioned(tmp_path):
    given_inputs = orbit_inputs.good()
    for given in [*given_inputs[:100:3], *given_inputs[100:]]:
        trajectory, notes = examined(given, tmp_path)
        apart = [
            np.linalg.norm(trajectory.at(time) - np.array(at))
            for time, at in zip((0.0, 30.0, 60.0), given.expected_m, strict=True)
        ]
        assert max(apart) < given.within_m, given.name
        assert notes == (), given.name


def test_elements_of_another_century_are_too_old_before_they_have_decayed():
    [first, second] = LINES
    first = f"{first[:18]}57{first[20:68]}"
    first += str(sum(int(character) if character.isdigit() else character == "-" for character in first) % 10)
    with pytest.raises(PayloadError, match="days older than the frames"):
        examine(TwoLineElements(first, second, START), 0.0, 60.0)


def test_wrong_orbits_are_refused_or_noted(tmp_path):
    silent, misnamed = [], []
    for given in orbit_inputs.bad():
        try:
            _, notes = examined(given, tmp_path)
        except PayloadError as error:
            checked = given.name.startswith("elements message") or "XML" in given.name
            if checked and not re.search(given.names, str(error)):
                misnamed.append((given.name, str(error)))
            continue
        if not notes:
            silent.append(given.name)
    assert silent == ["message: place 3300 km away"]  # the trajectory alone is right
    assert misnamed == []


def test_the_estimated_error_between_points_is_that_of_the_orbit():
    # A circular orbit in closed form, read at the points alone.
    orbit = Circular(500e3, 51.6)
    for step, degree, least_m in ((300.0, 3, 2e3), (600.0, 5, 3e3), (900.0, 7, 1e3)):
        times = np.arange(-4.0 * step, 4.5 * step, step)
        table = PositionTable(times, [orbit.at(time) for time in times], degree=degree)
        error = np.linalg.norm(table.at(0.5 * step) - orbit.at(0.5 * step))
        assert error > 0.5 * least_m
        with pytest.raises(PayloadError, match=rf"points {step:g} s apart, .* err by about") as refused:
            examine(table, 0.0, step)
        stated = float(str(refused.value).partition("about ")[2].partition(" m")[0])
        assert 0.5 < stated / error < 4.0
    close = np.arange(-300.0, 301.0, 60.0)
    assert examine(PositionTable(close, [orbit.at(time) for time in close]), 0.0, 60.0) == ()


def test_old_elements_are_noted_with_their_age_and_very_old_ones_refused():
    day = 86400.0
    orbit = TwoLineElements(*LINES, START)
    assert examine(orbit, 0.0, 5.0 * day) == ()
    (note,) = examine(orbit, 30.0 * day, 30.0 * day)
    assert "30.6 days" in note
    assert "1 to 3 km more" in note
    with pytest.raises(PayloadError, match=r"401 days .*allowed: up to 180 days"):
        examine(orbit, 400.0 * day, 400.0 * day)


def test_a_place_far_from_what_the_camera_sees_is_noted_or_refused():
    seen, above = np.array([[30.0, 150.0], [31.0, 150.0]]), np.array([[7e6, 0.0, 0.0]])
    assert examine_place((30.5, 150.0), seen, 50e3, above) == ()
    (note,) = examine_place((27.0, 150.0), seen, 50e3, above)
    assert "27 N 150 E is 332 km from the nearest pixel of all frames, 30 N 150 E" in note  # pyproj: 332 441 m
    with pytest.raises(PayloadError, match=r"is 33.. km from the nearest pixel .* closest valid choice is 30, 150"):
        examine_place((0.0, 150.0), seen, 50e3, above)


def test_a_stated_interpolation_and_usable_spans_of_several_segments_hold(tmp_path):
    lines = orbit_inputs.elements("station", 1.0)
    linear = {"INTERPOLATION": "LINEAR", "INTERPOLATION_DEGREE": "1"}
    blocks = [
        orbit_inputs.block(lines, -60.0, 60.0, 10.0, keys=linear | {"USEABLE_STOP_TIME": orbit_inputs.stamp(START)}),
        orbit_inputs.block(
            lines, -60.0, 60.0, 10.0, keys={"USEABLE_START_TIME": orbit_inputs.stamp(START + timedelta(seconds=1))}
        ),
    ]
    (tmp_path / "a.oem").write_bytes(orbit_inputs.message(*reversed(blocks)))
    orbit = read_oem(tmp_path / "a.oem", START)
    ends = [
        np.array(orbit_inputs.earth_fixed(lines, START + timedelta(seconds=seconds))[0])
        for seconds in (-10.0, 0.0, 5.0)
    ]
    assert orbit.at(-5.0) == pytest.approx(0.5 * (ends[0] + ends[1]), abs=1e-3)
    assert orbit.at(5.0) == pytest.approx(ends[2], abs=0.1)
    with pytest.raises(PayloadError, match=r"time 0.5 s; the table holds -60 to 0 s, 1 to 60 s between USEABLE_START"):
        orbit.at(0.5)


def test_elements_with_a_byte_order_mark_are_read():
    path = Path(os.environ.get("HCSS_SAMPLE_DATA", ""), "cases", "bom.tle")
    if not path.is_file():
        pytest.skip("HCSS_SAMPLE_DATA names no folder with cases/bom.tle")
    assert read_elements(path, START, EarthOrientation()).epoch.isoformat()[:10] == "2024-04-20"
