"""What ``hcss plan --verbose`` prints: one screen, and nothing about what the scene does not have."""

import json
from dataclasses import replace

import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.plugins import Origin
from hcss_twin.plan.description import describe
from hcss_twin.reports.plan_text import plan_text
from hcss_twin.reports.tables import WIDTH

TINY = {**CHEAP, "image.rows": 8, "image.columns": 8}
NIGHT = {"time": "2024-04-20T00:30:00+10:00"}


def planned(name="stratus", **overrides):
    return make_plan(Scenario.load(name, {**TINY, **{k.replace("__", "."): v for k, v in overrides.items()}}))


def row(text, label):
    """The text of the rows with a label, without its line breaks."""
    found, inside = [], False
    for line in text.splitlines()[1:]:
        if line[2:15].strip():
            inside = line[2:15].strip() == label
        if inside:
            found.append(line[15:].strip())
    return " ".join(found)


@pytest.mark.parametrize("name", Catalog().names("scenarios", ".toml"))
def test_every_shipped_scenario_fits_on_a_screen(name):
    textured = {key: value for key, value in CHEAP.items() if key != "sea.temperature_texture"}
    plan = make_plan(Scenario.load(name, textured))
    lines = plan_text(plan).splitlines()
    assert len(lines) <= 63 + 12 * (max(len(plan.layers), 1) - 1)
    assert max(map(len, lines)) <= WIDTH


def test_the_text_tells_place_time_clouds_sea_bands_and_what_comes_out():
    text = plan_text(planned(frames__count=3, clouds__coverage=0.3, motion__wind_speed=7.0, clouds__temperature=270))
    assert text.splitlines()[0].startswith("Stratus over sea")
    for name, words in {
        "scene": ("35 N 150 E", "2024-04-20 12:30:00+10:00", "3 frames"),
        "image": ("8 rows x 8 columns of 20 m", "1000 m/s"),
        "view": ("20 deg", "18.72 deg"),
        "sun": ("24.389",),
        "clouds": ("stratus", "0.3", "33 m", "1000 m", "fractal"),
        "particles": ("270 K",),
        "wind": ("7 m/s", "270 deg", "1800 s"),
        "sea": ("291.4 K", "10 m/s", "cox-munk"),
        "atmosphere": ("us-standard-1976", "band-model"),
        "bands": ("swir-2.7-3.0 (2.7-3 um)", "mwir (3-5 um)", "lwir (8-14 um)"),
        "output": ("radiance, cloud_mask", "24 pixels"),
        "accuracy": ("0.001", "28 % numerics"),
    }.items():
        assert [word for word in words if word not in row(text, name)] == []


def test_what_is_filled_in_is_in_the_row_of_the_sea_too():
    bare = {"time": "2024-04-20T12:30:00+10:00", "place": {"latitude": -35.0, "longitude": -150.0}}
    plan = make_plan(Scenario.from_dict(bare, TINY))
    text = plan_text(plan)
    assert row(text, "scene").startswith("35 S 150 W")
    assert row(text, "clouds") == "none"
    assert row(text, "sea").startswith(f"{plan.assembly.sea_temperature_K:.5g} K, wind ")
    assert row(text, "filled in").count(" = ") == 4


def test_the_largest_approximation_comes_first_and_what_loses_nothing_last():
    text = plan_text(planned())
    told = row(text, "approximated")
    places = [told.index(word) for word in ("footprint of a pixel", "view angles", "nothing ", "statistical ")]
    assert places == sorted(places)


def test_octaves_are_gathered_in_the_text_and_all_there_in_json():
    plan = planned("baseline", image__pixel_size=2000.0)
    several = [item["what"] for item in describe(plan)["skipped"] if "interpolation of octave" in item["what"]]
    assert len(several) > 3
    assert "interpolation of octave 1 to 10" in row(plan_text(plan), "approximated")
    assert plan_text(plan).count("interpolation of octave") == 1
    assert len(json.dumps(describe(plan)["skipped"])) > len(row(plan_text(plan), "approximated"))


def test_a_night_scene_is_not_told_about_sunlight():
    day, night = planned("baseline"), planned("baseline", **NIGHT)
    assert any("sun glint" in note for note in day.notes)
    assert not any("sun" in note for note in night.notes)
    terms = next(item.why for item in night.omissions if item.what == "look-up of terms of the radiance")
    assert "sea_emission" in terms
    assert "sun" not in terms
    words = plan_text(night).lower().split("nothing", 1)[0].split("approximated", 1)[1]
    assert "sunlight" not in words
    assert row(plan_text(night), "sun").endswith("below the horizon in 8 of 8 frames")


def test_a_scene_of_long_waves_is_not_told_about_short_ones():
    assert any("128 moments" in note for note in planned().notes)
    long_waves = planned(bands=["lwir"])
    assert not any("moments" in note for note in long_waves.notes)
    assert any("2.6 um" in note for note in planned(bands=[[2.0, 2.2]]).notes)


def test_a_scene_of_masks_is_told_about_clouds_alone():
    plan = planned(output__variables=["cloud_mask"])
    assert [note[:8] for note in plan.notes] == ["Coverage"]
    assert not any("waves" in item.what or "terms" in item.what for item in plan.omissions)
    text = plan_text(plan)
    for label in ("sea", "atmosphere", "bands", "radiance", "particles", "accuracy"):
        assert row(text, label) == ""
    thickness = plan_text(planned(output__variables=["cloud_optical_thickness"]))
    assert row(thickness, "bands") != ""
    assert row(thickness, "particles") != ""
    assert row(thickness, "sea") == ""


def test_a_provider_that_somebody_else_brings_is_told_with_its_package():
    plan = planned()
    entries = dict(plan.assembly.entries)
    entries["sea"] = replace(entries["sea"], origin=Origin("sea", "hcss-my-sea", "1.2"))
    foreign = replace(plan, assembly=replace(plan.assembly, entries=entries))
    assert row(plan_text(foreign), "sea").endswith("; cox-munk [hcss-my-sea 1.2]")
    assert row(plan_text(foreign), "atmosphere").endswith("; band-model")


def test_rounding_and_compression_are_told_with_the_output():
    text = plan_text(planned(output__compression=1, output__quantization="0.02 %"))
    assert row(text, "output").startswith("radiance, cloud_mask: 0.0 MB before compression, compressed at level 1;")
    assert row(text, "rounding").startswith("numbers are rounded to 12 bits")


def test_the_text_tells_noise_and_range_of_an_instrument():
    keys = {"nedt": "20 mK at 290 K", "saturation_temperature": 330.0, "bits": 12, "pixel_angle": 4e-5}
    text = plan_text(planned(instrument=keys, bands=[[10.0, 10.2]]))
    assert "10-10.2um: NEDT 0.02 K at 290 K, saturates at 330 K, one number is 0.0007" in row(text, "sensor")
