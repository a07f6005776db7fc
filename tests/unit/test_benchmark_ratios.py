"""Committed ratios: what counts as worse, whichever way is better, and what files of them must hold."""

import json
import math
import sys
from pathlib import Path

import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
if not FOLDER.exists():
    pytest.skip("not in an installed package", allow_module_level=True)
sys.path.insert(0, str(FOLDER))
from regression import BaselineError, Ratio, read_ratios, regressions, write_ratios  # noqa: E402

sys.path.remove(str(FOLDER))


def ratio(value, better="lower", name="a"):
    return Ratio(name, value, better, 1.0, "one thing over another")


def worse(before, now, better):
    return regressions({"a": ratio(before, better)}, {"a": ratio(now, better)})


@pytest.mark.parametrize(
    ("before", "now", "better", "fails"),
    [
        (4.0, 4.99, "lower", False),
        (4.0, 5.0, "lower", False),
        (4.0, 5.01, "lower", True),
        (4.0, 0.1, "lower", False),
        (5.0, 4.01, "higher", False),
        (5.0, 4.0, "higher", False),
        (5.0, 3.99, "higher", True),
        (5.0, 5000.0, "higher", False),
    ],
)
def test_worse_by_more_than_a_quarter_fails_and_better_never(before, now, better, fails):
    assert bool(worse(before, now, better)) == fails


def test_a_line_names_the_ratio_both_values_and_by_how_much():
    (line,) = worse(2.0, 3.0, "lower")
    for part in ("a: 3", "committed 2", "50 %", "25 %", "one thing over another"):
        assert part in line


def test_a_ratio_that_was_not_measured_fails():
    (line,) = regressions({"a": ratio(2.0)}, {})
    assert "not measured" in line


def test_a_ratio_that_is_no_number_fails():
    assert worse(2.0, math.nan, "lower")
    assert worse(2.0, math.nan, "higher")


def test_ratios_that_were_not_committed_are_not_judged():
    assert regressions({}, {"new": ratio(1e9)}) == []


def test_what_is_allowed_can_be_given():
    assert regressions({"a": ratio(1.0)}, {"a": ratio(1.2)}, allowed=0.1)


@pytest.mark.parametrize(("value", "better", "reached"), [(0.9, "lower", True), (1.1, "lower", False)])
def test_an_aim_is_an_upper_limit_where_lower_is_better_and_a_lower_one_where_higher_is(value, better, reached):
    assert ratio(value).reached == reached
    assert ratio(value, "higher").reached != reached


def test_ratios_come_back_from_their_file_to_three_digits(tmp_path):
    path = tmp_path / "ratios.json"
    write_ratios(path, {"a": ratio(1.23456), "b": ratio(2e5, "higher", "b")}, {"about": "x"})
    found = read_ratios(path)
    assert found["a"] == ratio(1.23)
    assert found["b"] == ratio(2e5, "higher", "b")
    assert json.loads(path.read_text())["about"] == "x"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"ratios": {"a": {}}}',
        '{"ratios": {"a": {"value": 0, "better": "lower", "aim": 1, "what": ""}}}',
        '{"ratios": {"a": {"value": 1, "better": "more", "aim": 1, "what": ""}}}',
    ],
)
def test_a_file_without_ratios_is_refused_by_name(tmp_path, text):
    path = tmp_path / "ratios.json"
    path.write_text(text)
    with pytest.raises(BaselineError, match=r"ratios\.json"):
        read_ratios(path)


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(BaselineError, match=r"none\.json"):
        read_ratios(tmp_path / "none.json")
