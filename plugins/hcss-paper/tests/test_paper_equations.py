"""The table of equations is true: the functions exist, and the code of each names the number of its equation."""

import re
import sys
from pathlib import Path

import pytest
from hcss_paper.equations import ENGINE, PAPER, find, summary

ALL = [*PAPER, *(equation for part in ENGINE.values() for equation in part)]


def test_no_numbered_equation_of_the_paper_is_missing():
    assert [equation.paper for equation in PAPER] == list(range(1, 25))


@pytest.mark.parametrize("equation", ALL, ids=lambda equation: equation.name.replace(" ", "-"))
def test_the_functions_of_an_equation_exist_and_say_what_they_do(equation):
    assert equation.functions
    for dotted in equation.functions:
        assert callable(find(dotted)) or isinstance(find(dotted), property)
        assert len(summary(dotted)) > 10
    assert (equation.paper is None) == bool(equation.source)


@pytest.mark.parametrize("equation", PAPER, ids=lambda equation: f"eq{equation.paper}")
def test_the_code_of_an_equation_of_the_paper_names_its_number(equation):
    numbers = set()
    for dotted in equation.functions:
        found = find(dotted)
        found = found.fget if isinstance(found, property) else found
        text = Path(sys.modules[found.__module__].__file__).read_text(encoding="utf-8")
        for first, last, second in re.findall(r"[Ee](?:q|quation)s? (\d+)(?:-(\d+))?(?: and (\d+))?", text):
            numbers |= set(range(int(first), int(last or first) + 1)) | {int(second or first)}
    assert equation.paper in numbers


def test_a_wrong_name_of_a_function_is_found():
    with pytest.raises(LookupError, match="no_such"):
        find("physics.planck.no_such")
    with pytest.raises(LookupError, match="no such module"):
        find("phisics.planck.planck")


def test_every_formula_can_be_shown_without_a_script():
    convert = pytest.importorskip("latex2mathml.converter").convert
    for equation in ALL:
        shown = convert(equation.formula, display="block")
        assert shown.startswith("<math"), equation.name
        assert "\\" not in shown, equation.name
