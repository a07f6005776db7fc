"""What ``hcss plan`` says without ``--verbose``: few lines, what matters first, and advice that can be followed."""

import re

import pytest
from cheap import CHEAP
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.predicted_time import predict
from hcss_twin.plan.description import describe
from hcss_twin.reports.plan_brief import MOST_LINES, plan_brief
from hcss_twin.reports.plan_text import plan_text
from hcss_twin.reports.tables import WIDTH

FIRST = ["size", "time", "memory", "error", "left out", "assumed"]
LAYER = {"type": "stratus", "coverage": 0.5, "thickness_min": 20.0}
CROWDED = {
    **CHEAP,
    "image.rows": 8,
    "image.columns": 8,
    "title": "",
    "bands": [[low, low + 0.2] for low in (3.5, 3.8, 4.5, 8.2, 8.6, 10.0, 11.0, 12.0)],
    "clouds.layers": [{**LAYER, "base": 400.0 + 900.0 * n, "top": 900.0 + 900.0 * n} for n in range(5)],
    "output.variables": ["all"],
}


def brief(name, overrides):
    plan = make_plan(Scenario.load(name, overrides))
    return plan, plan_brief(plan, predict(plan), name)


def labels(text):
    return [line[2:12].strip() for line in text.splitlines()[1:] if line[2:12].strip()]


def row(text, label):
    lines = iter(text.splitlines()[1:])
    found = [line[12:] for line in lines if line[2:12].strip() == label]
    for line in text.splitlines()[text.splitlines().index(f"  {label:<10}{found[0]}") + 1 :]:
        if line[2:12].strip():
            break
        found.append(line[12:])
    return " ".join(found)


@pytest.mark.parametrize("name", Catalog().names("scenarios", ".toml"))
def test_every_shipped_scenario_needs_few_lines_of_which_the_first_say_what_matters(name):
    _, text = brief(name, CHEAP)
    lines = text.splitlines()
    assert len(lines) <= MOST_LINES
    assert max(map(len, lines)) <= WIDTH
    assert labels(text)[:6] == FIRST
    assert labels(text)[-1] == "next"
    assert "clouds" in labels(text)


def test_a_crowded_scene_leaves_details_to_verbose_and_nothing_of_what_matters():
    _, text = brief("stratus", CROWDED)
    assert len(text.splitlines()) <= MOST_LINES
    assert labels(text)[:6] == FIRST
    assert "--verbose" in text.splitlines()[-1]


def test_the_error_is_the_largest_total_of_the_budget_in_kelvin():
    plan, text = brief("cirrus-over-cumulus", CHEAP)
    totals = {
        (of, band): entry.get("total_K", entry.get("at_least_K"))
        for of, bands in describe(plan)["error_budget"].items()
        for band, entry in bands.items()
    }
    (of, band), kelvin = max(totals.items(), key=lambda each: each[1])
    assert re.match(
        rf"(at least )?{kelvin:.2g} K in {of.removeprefix('paper-')}, {band}: mostly \w", row(text, "error")
    )


def test_the_error_names_what_is_unknown_of_every_class():
    """A class whose error is not known may have the largest: its causes stand beside the largest that is known."""
    plan, text = brief("cumulus", {**CHEAP, "view.zenith": 45.0})
    of_classes = {
        of.removeprefix("paper-"): {
            re.sub(" in .* of the band", "", each) for entry in bands.values() for each in entry["unknown"]
        }
        for of, bands in describe(plan)["error_budget"].items()
    }
    told = row(text, "error")
    named = re.search(r" K in ([^,]+), ", told)[1]
    assert any(causes for of, causes in of_classes.items() if of != named)
    for of, causes in of_classes.items():
        if of != named and causes:
            (found,) = re.findall(rf"; unknown in {of}: ([^;]+)", told)
            assert set(found.split(", ")) == causes


@pytest.mark.parametrize("name", ["degraded-cirrus", "cumulus", "cirrus-over-cumulus"])
def test_the_largest_omission_is_named_and_the_command_line_takes_its_key(name):
    options = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
    told = row(CliRunner().invoke(cli, ["plan", name, *options]).stdout, "left out")
    plan = make_plan(Scenario.load(name, CHEAP))
    largest = max(plan.omissions, key=lambda each: each.size or 0.0 if each.needs else 0.0)
    assert told.startswith(largest.what)
    key, value = re.search(r"([a-z_.]+) = (\S+)", told).groups()
    after = CliRunner().invoke(cli, ["plan", name, *options, "--set", f"{key}={value}"])
    assert after.exit_code == 0
    assert not row(after.stdout, "left out").startswith(largest.what)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"output.certificate": 60, "frames.count": 5},
        {"image.samples_per_pixel": 3, "output.certificate": 24},
        {"image.rows": 3, "image.columns": 4},
    ],
)
def test_the_plan_states_as_many_checked_pixels_as_the_run(changes, tmp_path):
    scene = Scenario.load(
        "stratus", {**CHEAP, "image.rows": 12, "image.columns": 12, "output.certificate": 24, **changes}
    )
    made = make_plan(scene)
    stated = re.search(r"checked in (\d+) random pixels", plan_brief(made, predict(made), "stratus"))
    assert stated
    assert f"certificate of {stated[1]} pixels" in plan_text(made)
    with simulate(scene) as cube:
        assert int(cube.attrs["hcss_certificate_pixels"]) == int(stated[1])


def test_a_scene_of_masks_states_no_error_and_no_accuracy():
    _, text = brief("stratus", {"output.variables": ["cloud_mask"]})
    assert row(text, "error") == "none to state: no radiance is computed"
    assert "accuracy" not in labels(text)


def test_verbose_has_all_and_json_the_prediction(tmp_path):
    options = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
    few, all_of_it = (CliRunner().invoke(cli, ["plan", "stratus", *options, *more]) for more in ([], ["--verbose"]))
    assert len(few.stdout.splitlines()) <= MOST_LINES < len(all_of_it.stdout.splitlines())
    plan = make_plan(Scenario.load("stratus", CHEAP))
    prediction = predict(plan)
    total = sum(prediction.seconds.values()) + prediction.kernels_s
    assert prediction.as_dict()["processor_s"]["total"] == pytest.approx(total)


@pytest.mark.parametrize(
    ("overrides", "keys"),
    [
        ({}, "motion.wind_from, sea.wind_from = 270 deg"),
        ({"sea.wind_from": 270.0}, "motion.wind_from = 270 deg"),
        ({"motion.wind_from": 90.0, "sea.wind_from": 90.0}, ""),
        ({"motion.wind_speed": 0.0, "sea.wind_from": 0.0}, ""),
        ({"frames.count": 1, "sea.wind_from": 0.0}, ""),
    ],
)
def test_the_default_bearing_of_the_wind_is_said_where_images_depend_on_it(overrides, keys, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        "time = 2024-04-20T12:30:00+10:00\nplace = {latitude = 35.0, longitude = 150.0}\nclouds.type = 'stratus'\n"
    )
    small = {"image.rows": 8, "image.columns": 8, "frames.count": 2}
    plan, text = brief(str(path), {**CHEAP, **small, **overrides})
    for assumed in (row(text, "assumed"), " ".join(plan_text(plan).split())):
        assert (f" {keys}" in f" {assumed}") if keys else ("wind_from = 270" not in assumed)
