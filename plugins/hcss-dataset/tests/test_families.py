"""Families of targets and their tracks against closed forms."""

import copy
import json
import math

import numpy as np
import pytest
from hcss_dataset.distribution import Distribution
from hcss_dataset.families import FAMILIES, family, fresnel, gas_intensity, glint_intensity, reference_K
from hcss_dataset.rendering import Studio
from hcss_dataset.tracks import great_circle, read_tracks
from sets import CLEAR, NOISELESS, keys

from hcss_twin import Scenario, simulate
from hcss_twin.providers import EARTH_RADIUS_M, ScenarioError

ALL = {**CLEAR, **NOISELESS, "time": "2024-04-20T12:30:00+10:00"}
GAS = [{"limits": [3.6, 3.7], "emissivity": 0.5}]


def sequences(given, count=1, **base):
    studio = Studio(Distribution.load(keys({**ALL, **base}, targets=given)))
    return [studio.sequence(number) for number in range(count)]


def planck_um(um, kelvin):
    """Spectral radiance of a black body, W m-2 sr-1 um-1, with the constants of CODATA."""
    metre = um * 1e-6
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    return 1e-6 * 2 * h * c**2 / metre**5 / np.expm1(h * c / (metre * k * kelvin))


def band_integral(low, high, of):
    um = np.linspace(low, high, 2001)
    return np.trapezoid(of(um), um)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_states_its_sources_use_and_gaps_and_gives_frames(name):
    about = family(name)
    assert all(about[key] for key in ("title", "intended_use", "sources", "not_known"))
    (sequence,) = sequences({"count": 2, "family": name}, **{"image.pixel_size": 40.0})
    frame = next(sequence.frames())
    assert [each["family"] for each in frame.labels["targets"]] == [name] * 2
    assert all(any(each["flux"]) for each in frame.labels["targets"])
    shown = json.loads(sequence.scenario.to_json())["elements"][0]["parameters"]["tracks"]
    assert len(shown) == 2 * (1 + sum(part.get("count", 1) for part in about["targets"].get("parts", ())))


def test_the_skin_of_an_aircraft_has_the_recovery_temperature():
    (sequence,) = sequences({"count": 1, "family": "boat"})
    plan, altitude, speed = sequence.plan, 10_000.0, 250.0
    air = float(plan.assembly.profile.temperature_at(altitude))
    mach = speed / math.sqrt(1.4 * 8.314462 / 0.0289647 * air)
    expected = air * (1.0 + 0.71 ** (1 / 3) * 0.2 * mach**2)
    assert reference_K("recovery", plan, altitude, speed) == pytest.approx(expected, abs=0.1)
    assert expected - air > 20.0
    assert reference_K("sea", plan, 0.0, 0.0) == plan.scenario.sea.temperature or plan.scenario.sea.temperature is None


def test_grey_gas_radiates_in_its_bands_alone():
    (sequence,) = sequences({"count": 1, "family": "boat"})
    found = gas_intensity(sequence.plan, 600.0, 10.0, GAS)
    expected = 10.0 * 0.5 * band_integral(3.6, 3.7, lambda um: planck_um(um, 600.0))
    # the limits of gas lie between wavenumbers of the plan
    assert found["mwir"] == pytest.approx(expected, rel=0.05)
    assert found["lwir"] == 0.0


def test_reflectance_is_that_of_fresnel():
    n, k = np.array([1.33, 1.15]), np.array([0.0, 0.1])
    assert fresnel(n, k, 0.0) == pytest.approx(((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2))
    brewster = math.degrees(math.atan(1.33))
    across = (1.33**2 - 1) ** 2 / (1.33**2 + 1) ** 2
    assert fresnel(n[:1], k[:1], brewster)[0] == pytest.approx(0.5 * across)
    assert fresnel(n, k, 90.0) == pytest.approx(1.0)


def test_a_glint_is_the_sun_in_a_curved_mirror():
    (sequence,) = sequences({"count": 1, "family": "boat"})
    plan = sequence.plan
    found, larger = (glint_intensity(plan, radius, 0.0, plan.view)["mwir"] for radius in (10.0, 20.0))
    assert larger == pytest.approx(4.0 * found)
    sun = plan.sun_up_at(0.0)
    incidence = 0.5 * sun.zenith_deg  # the view is from above
    index = (np.full(1, 1.37), np.full(1, 0.0036))  # of water at 3.7 um, Hale and Querry (1973)
    irradiance = band_integral(3.6, 3.8, lambda um: planck_um(um, 5772.0)) * math.pi * (6.957e8 / 1.496e11) ** 2
    without_air = irradiance * fresnel(*index, incidence)[0] * 10.0**2 / 4.0
    # air lets 80 to 95 % through here, and the sun is no black body
    assert 0.7 * without_air < found < 1.05 * without_air


def test_there_is_no_glint_by_night():
    studio = Studio(Distribution.load(keys({**CLEAR, **NOISELESS}, targets={"count": 1, "family": "glint"})))
    with pytest.raises(ScenarioError, match="without sun"):
        studio.sequence(0)


def body(kelvin):
    strength = {"temperature": kelvin, "area": 100.0}
    return {"count": 1, "margin": 10, "altitude": 8000.0, "strength": strength}


def test_bodies_are_warmer_or_colder_than_what_they_hide():
    labels = []
    for kelvin in (230.0, 250.0, 330.0):
        (sequence,) = sequences(body(kelvin), time="2024-04-20T23:30:00+10:00")
        labels.append(next(sequence.frames()).labels["targets"][0])
    cold, middle, warm = labels
    assert cold["flux"][1] < middle["flux"][1] < 0.0 < warm["flux"][1]
    assert cold["peak"][1] < 0.0 < warm["peak"][1]
    share = 100.0 / 20.0**2
    # what is hidden and the air before it cancel in the difference of two bodies
    reaching = [
        each["transmittance"][1] * band_integral(10.5, 11.0, lambda um, at=each["temperature_K"]: planck_um(um, at))
        for each in labels
    ]
    assert warm["flux"][1] - cold["flux"][1] == pytest.approx(share * (reaching[2] - reaching[0]), rel=1e-3)


def test_a_plume_belongs_to_its_aircraft_and_a_wake_does_not_belong_to_its_ship():
    margins = {"count": 1, "margin": 16, "heading": 0.0}
    plume, wake = (copy.deepcopy(family(name)["targets"]["parts"]) for name in ("aircraft", "ship"))
    plume[0]["strength"]["gas_bands"] = GAS
    wake[0] |= {"count": 3, "spacing": 60.0}
    for parts, belongs in ((plume, True), (wake, False)):
        alone = margins | {"altitude": 500.0, "speed": 10.0, "strength": {"temperature": 300.0, "area": 200.0}}
        (with_parts,), (without,) = sequences(alone | {"parts": parts}), sequences(alone)
        both, one = next(with_parts.frames()), next(without.frames())
        labels, bare = both.labels["targets"][0], one.labels["targets"][0]
        assert len(both.labels["targets"]) == 1
        assert (labels["flux"][0] > 1.05 * bare["flux"][0]) == belongs
        assert np.array_equal(both.clean, one.clean)
        step = np.array(both.labels["radiance_per_number"])
        added = [(each.image.astype(float) - each.clean).sum(axis=(1, 2)) * step for each in (both, one)]
        assert abs(added[0][0] - added[1][0]) > 20 * step[0]
        if belongs:
            assert added[0][0] == pytest.approx(labels["flux"][0], rel=0.02)


@pytest.mark.parametrize("north_m", [0.0, 4e5])
def test_great_circles_have_the_sides_of_right_triangles(north_m):
    """From a place north of the centre, toward east: Napier's rules for the triangle with the centre."""
    along_m = np.array([0.0, 2e5, 6e5])
    found = great_circle((0.0, north_m), 0.0, 100.0, 90.0, along_m / 100.0, 0.0)
    up, along = north_m / EARTH_RADIUS_M, along_m / EARTH_RADIUS_M
    away = np.arccos(np.cos(up) * np.cos(along))
    assert np.hypot(*found.T) == pytest.approx(EARTH_RADIUS_M * away, abs=1.0)
    bearing = np.arctan2(np.tan(along), math.sin(up)) if north_m else np.array([0.0, 0.5, 0.5]) * math.pi
    assert np.arctan2(found[1:, 0], found[1:, 1]) == pytest.approx(bearing[1:], abs=1e-9)
    if north_m:  # it bends toward the equator of the centre
        assert found[2, 1] < north_m - 1000.0


def test_labels_follow_a_great_circle_and_so_does_a_run(tmp_path):
    given = {"count": 1, "margin": 8, "altitude": 9000.0, "speed": 250.0, "track": "great-circle", "heading": 90.0}
    given["strength"] = {"intensity": 1e6}
    base = {"frames.count": 3, "frames.interval": 60.0, "image.pixel_size": 4000.0}
    (sequence,) = sequences(given, **base)
    labels = [frame.labels["targets"][0] for frame in sequence.frames()]
    start = np.array(labels[0]["position_m"])
    expected = great_circle(tuple(start), 9000.0, 250.0, 90.0, np.array([0.0, 60.0, 120.0]), 0.0)
    assert [each["position_m"] for each in labels] == pytest.approx(expected, abs=0.1)
    for each in labels:
        assert each["centroid"] == pytest.approx(each["place"], abs=0.01)
        ground = 250.0 * EARTH_RADIUS_M / (EARTH_RADIUS_M + 9000.0)
        assert np.hypot(*each["velocity_m_s"][:2]) == pytest.approx(ground, rel=1e-4)
        assert each["altitude_m"] == 9000.0
    shown = json.loads(sequence.scenario.to_json())
    shown["output"] |= {"variables": ["radiance", "element", "element_share"]}
    with simulate(Scenario.from_dict(shown), tmp_path / "run.nc") as cube:
        for index, each in enumerate(labels):
            (row,), (column,) = np.nonzero(cube["element"].isel(time=index).to_numpy())
            assert (row, column) == tuple(int(at) for at in each["place"])


TABLE = "# two sources\nsource,time,x,y,altitude\na,5,0,0,1000\na,6,30,40,1000\na,9,30,340,1100\n"


def test_tracks_of_a_table_begin_at_the_place_that_is_drawn(tmp_path):
    path = tmp_path / "tracks.csv"
    path.write_text(TABLE)
    given = {"count": 1, "margin": 15, "track": {"file": str(path)}, "strength": {"intensity": 1e4}}
    (sequence,) = sequences(given, **{"frames.count": 3, "frames.interval": 1.5})
    labels = [frame.labels["targets"][0] for frame in sequence.frames()]
    start = np.array(labels[0]["position_m"])
    assert [np.subtract(each["position_m"], start).tolist() for each in labels] == pytest.approx(
        np.array([[0.0, 0.0], [30.0, 90.0], [30.0, 240.0]]), abs=1e-6
    )
    assert [each["altitude_m"] for each in labels] == pytest.approx([1000.0, 1000.0 + 100 / 6, 1000.0 + 200 / 3])
    assert labels[1]["velocity_m_s"] == pytest.approx([0.0, 100.0, 100.0 / 3])


def test_places_in_degrees_are_distances_and_bearings(tmp_path):
    path = tmp_path / "tracks.csv"
    path.write_text("source,time,latitude,longitude,altitude\n1,0,60,10,0\n1,10,60,11,0\n1,20,61,10,0\n")
    (track,) = read_tracks(path)
    # a degree of the parallel is 2 asin(cos 60 sin .5) long, and begins north of east by half its convergence
    chord = 2.0 * math.asin(math.cos(math.radians(60)) * math.sin(math.radians(0.5)))
    assert np.hypot(*track[1, 1:3]) == pytest.approx(EARTH_RADIUS_M * chord)
    turn = math.atan(math.sin(math.radians(60)) * math.tan(math.radians(0.5)))
    assert math.atan2(track[1, 2], track[1, 1]) == pytest.approx(turn)
    assert track[2, 1:3] == pytest.approx([0.0, EARTH_RADIUS_M * math.radians(1.0)], abs=1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"family": "shipp"}, "closest is 'ship'"),
        ({"family": {"choice": ["ship", "plane"]}}, "'plane'"),
        ({"track": "great circle"}, "great-circle"),
        ({"track": "great-circle", "climb": 1.0}, "keeps its altitude"),
        ({"track": {"file": "missing.csv"}}, "missing.csv"),
        ({"strength": {"reference": "air", "area": 1.0}}, "difference: is missing"),
        ({"strength": {"reference": "water", "difference": 1.0, "area": 1.0}}, "allowed: .*sea"),
        ({"parts": [{"strength": {"scr": 3.0}}]}, "parts.*strength"),
        ({"parts": [{"strength": {"intensity": 3.0}}], "strength": {"scr": 3.0}}, "that of one part"),
    ],
)
def test_mistakes_of_families_are_named(change, words):
    given = {"count": 1, "altitude": 10.0, "strength": {"intensity": 1.0}}
    with pytest.raises(ScenarioError, match=words):
        Distribution.load(keys(targets=given | change))
