"""Committed ratios: whether they reach their aims, and what files of them must hold."""

import json
import sys
from pathlib import Path

import pytest

import hcss_twin

FOLDER = Path(hcss_twin.__file__).parents[1] / "benchmarks"
if not FOLDER.exists():
    pytest.skip("not in an installed package", allow_module_level=True)
sys.path.insert(0, str(FOLDER))
from regression import BaselineError, Ratio, read_ratios, write_ratios  # noqa: E402

sys.path.remove(str(FOLDER))


def ratio(value, better="lower", name="a"):
    return Ratio(name, value, better, 1.0, "one thing over another")


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
