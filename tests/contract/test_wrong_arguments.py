"""Wrong values for the arguments of public functions: an error of the package that names the argument, and no other."""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hcss_export import export_cube

import hcss_twin
from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import HcssError, OptionError

sys.path.insert(0, str(Path(__file__).parents[2] / "campaigns" / "arguments"))

from wrong_arguments import WRONG, calls, outcomes


def test_no_other_error_escapes_from_cheap_functions(tmp_path, monkeypatch):
    # results.json of the campaign has all functions, 30 values for each argument
    monkeypatch.chdir(tmp_path)
    counts, escaped = outcomes(calls(tmp_path)[0], {name: WRONG[name] for name in list(WRONG)[::4]})
    assert not escaped
    assert sum(number for (_, outcome), number in counts.items() if outcome == "refused") > 130
    assert len(WRONG) == 30


def test_the_error_names_argument_value_and_what_is_allowed():
    with pytest.raises(OptionError, match=r"^export_cube: bands: nan \(float\); allowed: a sequence of text$"):
        export_cube("c.nc", "envi", bands=np.nan)
    with pytest.raises(OptionError, match=r"^make_plan: scenario: .* \(Dataset\); allowed: "):
        hcss_twin.make_plan(WRONG["dataset"])


@checked
def example(
    number: float, count: int = 1, words: Sequence[str] | tuple[int, float] | None = None, *, flag: bool = False
) -> None:
    """An example."""


@pytest.mark.parametrize(
    "right",
    [
        {"number": 1},
        {"number": np.float32(1.5), "count": np.int16(3)},
        {"number": 0.0, "words": ["a"]},
        {"number": 0.0, "words": (1, 2)},
        {"number": 0.0, "flag": np.True_},
    ],
)
def test_what_can_take_the_place_of_a_type_is_accepted(right):
    example(**right)


@pytest.mark.parametrize(
    "wrong",
    [
        {"number": True},
        {"number": "1"},
        {"number": 10**400},
        {"count": 1.0},
        {"words": "a"},
        {"words": (1, 2, 3)},
        {"flag": 1},
    ],
)
def test_what_cannot_is_refused(wrong):
    with pytest.raises(HcssError, match=rf"^example: {next(iter(wrong))}: "):
        example(**{"number": 1.0} | wrong)
