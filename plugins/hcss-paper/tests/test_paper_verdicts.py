"""Verdicts follow from checks; what an item is called; how a row is compared."""

import base64
import json
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from hcss_paper.index import ITEMS, Item, chosen, heading
from hcss_paper.inputs import AssumedInput, fitted_inputs, in_words
from hcss_paper.report import reproduction_page
from hcss_paper.reproduction import (
    Check,
    Drawing,
    Reproduction,
    Row,
    judged,
    largest_check,
    rms_check,
    settled,
    verdict_of,
)
from hcss_paper.run import Outcome, outcomes, relative, totals
from matplotlib.figure import Figure

from hcss_twin.core.errors import HcssError
from hcss_twin.reports.page import page_text

GOOD, BAD = Check("good", True), Check("bad", False)
SAID = Check("said", True, "section I")
PRINTED = Row("x", "K", 1.0, 1.0)
SEA = in_words("sea")


@pytest.mark.parametrize(
    ("checks", "inputs", "verdict"),
    [
        ([GOOD], (), "reproduced"),
        ([GOOD, GOOD], SEA, "reproduced with fitted inputs"),
        ([GOOD, BAD], (), "not reproducible"),
        ([BAD], SEA, "not reproducible"),
    ],
)
def test_a_verdict_is_that_of_the_checks_and_inputs(checks, inputs, verdict):
    assert verdict_of([PRINTED], checks, inputs) == verdict


def test_no_verdict_without_a_check():
    with pytest.raises(ValueError, match="something that can fail"):
        verdict_of([PRINTED], [], ())


@pytest.mark.parametrize("rows", [[], [Row("x", "K", None, 1.0)], [Row("x", "K", 1.0, None)]])
def test_no_verdict_without_a_printed_number_or_a_statement_of_the_paper(rows):
    with pytest.raises(ValueError, match="no printed number is compared"):
        verdict_of(rows, [GOOD], ())
    assert verdict_of(rows, [GOOD, SAID], ()) == "reproduced"
    assert verdict_of([*rows, PRINTED], [GOOD], ()) == "reproduced"


def test_an_item_whose_rows_lose_a_printed_number_fails():
    one = Item("fine", "fine", f"{__name__}:fine", 1)
    assert [found.verdict for found in outcomes([one, replace(one, numbers=2)], 1)] == ["reproduced", "failed"]


def test_the_reason_told_is_that_of_the_verdict():
    assert judged([PRINTED], [GOOD], "yes", "no").reason == "yes"
    assert judged([PRINTED], [BAD], "yes", "no").reason == "no"


def test_fitted_inputs_are_told_with_their_values_and_how_to_fit_them():
    found = judged([PRINTED], [GOOD], "yes", "no", inputs=["sea temperature"])
    [sea], [note] = found.fitted_inputs, found.notes
    assert (sea.name, sea.value, sea.unit) == ("sea temperature", fitted_inputs()["sea temperature"].value, "K")
    assert f"{sea.value:g} K" in sea.text
    assert "python -m hcss_paper.fits" in note


def test_a_reading_chosen_to_fit_is_a_fitted_input():
    found = judged([PRINTED], [GOOD], "yes", "no", choices=["L counts cells"])
    assert found.verdict == "reproduced with fitted inputs"
    assert found.fitted_inputs == (AssumedInput("L counts cells", name=None, value=None, unit=None),)


def test_a_choice_in_the_words_of_a_fitted_input_is_not_that_number():
    words = fitted_inputs()["sea temperature"].assumed.text
    found = judged([PRINTED], [GOOD], "yes", "no", inputs=["sea temperature"], choices=[words])
    written = Outcome(Item("a", "", ""), found, "", 1).as_dict()["fitted_inputs"]
    assert [input_["text"] for input_ in written] == [words, words]
    assert [input_["name"] for input_ in written] == ["sea temperature", None]


@pytest.mark.parametrize(
    ("claimed", "checks", "inputs", "verdict"),
    [
        ("reproduced", [GOOD], (), "reproduced"),
        ("reproduced", [GOOD], SEA, "reproduced with fitted inputs"),
        ("reproduced", [GOOD, BAD], (), "not reproducible"),
        ("reproduced with fitted inputs", [BAD], SEA, "not reproducible"),
        ("not reproducible", [GOOD], (), "not reproducible"),
    ],
)
def test_an_item_claims_no_more_than_its_checks_allow(claimed, checks, inputs, verdict):
    found = settled(Reproduction(claimed, "Said.", [], checks, inputs))
    assert found.verdict == verdict
    assert ("bad" in found.reason) == (verdict == "not reproducible" != claimed)


def test_limits_of_checks_count_as_holding_and_a_little_more_does_not():
    printed = np.array([1.0, 2.0])
    off = np.array([1.1, 2.2])
    assert rms_check("x", off, printed, 0.1 + 1e-12).holds
    assert not rms_check("x", off, printed, 0.099).holds
    assert largest_check("x", off, printed, 0.2 + 1e-12, "K").holds
    assert not largest_check("x", off, printed, 0.199, "K").holds


def test_differences_are_shares_of_what_is_printed_and_of_percentages_themselves():
    assert relative(Row("x", "K", 200.0, 202.0)) == pytest.approx(0.01)
    assert relative(Row("x", "K", -2.0, -3.0)) == pytest.approx(-0.5)
    assert relative(Row("x", "%", 10.0, 11.0)) == pytest.approx(0.01)
    assert relative(Row("x", "K", 0.0, 0.0)) == 0.0
    for row in (Row("x", "K", 0.0, 1.0), Row("x", "K", None, 1.0), Row("x", "K", 1.0, None)):
        assert relative(row) is None


def test_names_of_items_differ_and_each_target_is_there():
    assert len({item.name for item in ITEMS}) == len({heading(item.name) for item in ITEMS}) == len(ITEMS)
    for item in ITEMS:
        module, _, function = item.target.partition(":")
        assert callable(getattr(import_module(module), function))


def test_headings_are_those_of_the_paper():
    names = ("table-4", "table-10", "table-4-modtran", "figure-12", "headline")
    assert [heading(name) for name in names] == ["Table IV", "Table X", "Table IV, MODTRAN", "Figure 12", "Headline"]


def test_items_come_in_the_papers_order_and_once():
    assert [item.name for item in chosen(["table-3", "table-1", "table-3"])] == ["table-1", "table-3"]
    assert chosen([]) == ITEMS


def test_an_unknown_item_is_told_the_closest():
    with pytest.raises(HcssError, match="closest is 'table-4'"):
        chosen(["tabel-4"])


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("table II", "table-2"),
        ("Table II", "table-2"),
        ("table 2", "table-2"),
        ("II", "table-2"),
        ("2", "table-2"),
        ("Table IV, MODTRAN", "table-4-modtran"),
        ("x", "table-10"),
        ("Fig. 12", "figure-12"),
        ("Sun angles", "sun-angles"),
        *((heading(item.name), item.name) for item in ITEMS),
    ],
)
def test_an_item_may_be_named_as_in_the_paper(written, name):
    assert [item.name for item in chosen([written])] == [name]


@pytest.mark.parametrize(
    ("written", "closest"), [("Tabel II", "table-2"), ("table XI", "table-1"), ("figur 12", "figure-12")]
)
def test_a_name_that_is_nearly_that_of_the_paper_is_told_the_closest(written, closest):
    with pytest.raises(HcssError, match=f"no item '{written}'; allowed: .*; closest is '{closest}"):
        chosen([written])


def fine(seed):
    return Reproduction("reproduced", "Yes.", [Row(f"seed {seed}", "K", 0.45, 0.46, 0.5)], [GOOD])


def broken(seed):
    raise KeyError("<no such band>")


def test_an_item_that_raises_is_reported_and_the_others_are_computed():
    items = [Item(name, name, f"{__name__}:{name}", 1) for name in ("broken", "fine")]
    first, second = outcomes(items, 7)
    assert (first.verdict, first.result, first.worst) == ("failed", None, None)
    assert "KeyError" in first.error
    assert first.as_dict()["error"] == first.error
    assert second.verdict == "reproduced"
    assert second.as_dict()["rows"][0] | {"difference": 0.01} == {
        "label": "seed 7",
        "unit": "K",
        "published": 0.45,
        "computed": 0.46,
        "difference": 0.01,
        "mixture": None,
        "physical": 0.5,
    }
    text = page_text(reproduction_page([first, second], 7))
    assert "&lt;no such band&gt;" in text
    assert "<no such band>" not in text


def test_an_input_that_serves_two_items_counts_once_and_a_choice_is_not_a_number():
    rows = [Row("a", "K", 1.0, 1.0), Row("b", "K", None, 1.0), Row("c", "K", 1.0, None)]
    two = [
        Outcome(Item(name, "", ""), judged(rows, [GOOD], "", "", inputs=inputs, choices=["seen from above"]), "", 1)
        for name, inputs in (("a", ["sea temperature"]), ("b", ["sea temperature", "glint scale"]))
    ]
    assert [(outcome.compared, len(outcome.free), len(outcome.choices)) for outcome in two] == [(1, 1, 1), (1, 2, 1)]
    broken = Outcome(Item("c", "", ""), None, "KeyError", 1)
    assert totals([*two, broken]) == [
        "2 reproduced with fitted inputs: 2 numbers compared, 2 fitted inputs and 1 choices",
        "1 failed: 0 numbers compared, 0 fitted inputs and 0 choices",
    ]


def drawn(seed, label="fine"):
    figure = Figure(figsize=(1, 1))
    figure.subplots().set_xlabel(label)
    return replace(fine(seed), drawings=[Drawing("A drawing", figure, "an empty axis")])


def undrawable(seed):
    return drawn(seed, r"$\nosuchsymbol$")


def test_a_drawing_that_raises_while_it_is_drawn_makes_its_item_failed_alone():
    items = [Item(name, name, f"{__name__}:{name}", 1) for name in ("undrawable", "drawn")]
    first, second = outcomes(items, 7)
    assert (first.verdict, first.result, first.pictures) == ("failed", None, ())
    assert "nosuchsymbol" in first.error
    assert second.verdict == "reproduced"
    text = page_text(reproduction_page([first, second], 7))
    assert "nosuchsymbol" in text
    assert text.count('alt="an empty axis"') == 1
    assert base64.b64encode(second.pictures[0]).decode() in text


def test_an_interruption_is_not_taken_for_a_failure(monkeypatch):
    def interrupted(seed):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"{__name__}.fine", interrupted)
    with pytest.raises(KeyboardInterrupt):
        list(outcomes([Item("fine", "fine", f"{__name__}:fine")], 1))


def cells(rows):
    found = Outcome(Item("table-1", "", ""), Reproduction("reproduced", "", rows, [GOOD]), "", 1)
    return page_text(reproduction_page([found], 1))


def test_numbers_have_the_decimals_of_the_print_and_computed_ones_one_more():
    text = cells([Row("a", "K", 0.625, 0.62701, 0.7), Row("b", "K", 0.45, 0.4499999, None)])
    for shown in ("0.625", "0.6270", "+0.0020", "0.7000", "0.450", "0.4500", "+0.0000"):
        assert f">{shown}<" in text


def test_what_is_equal_is_shown_as_equal():
    text = cells([Row("a", "K", 3, 3.0), Row("b", "K", 0.033, 0.033)])
    assert text.count(">3<") == 2
    assert text.count(">0<") == 2
    assert ">0.0330<" not in text


def test_rows_without_print_have_three_digits_and_no_difference():
    text = cells([Row("a", "m", None, 2.1345, 1.0)])
    assert ">2.134<" in text or ">2.135<" in text
    assert ">+" not in text
    assert ">published<" not in text


def test_numbers_that_are_not_finite_spoil_neither_page_nor_json():
    rows = [Row("a", "m", 1.0, float("nan"), float("inf")), Row("b", "m", None, float("nan"))]
    assert ">nan<" in cells(rows)
    found = Outcome(Item("a", "", ""), Reproduction("reproduced", "", rows, [Check("x", np.True_)]), "", 1)
    assert found.worst is None
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["rows"][0]["computed"] is None
