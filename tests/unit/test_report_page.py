"""Pages of reports hold everything themselves and show text as it is."""

from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure

from hcss_twin.core.errors import HcssError
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.page import Markup, Page, page_text
from hcss_twin.reports.tables import WIDTH, Table, bound_text

VOID = {"meta", "img", "br", "input", "link", "hr"}


class Balance(HTMLParser):
    """Elements that are open, and addresses that are asked for."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        self.addresses += [value for name, value in attrs if name in {"src", "href"}]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def figure():
    drawn = Figure(figsize=(1, 1))
    drawn.subplots().plot([0, 1], [0, 1])
    return drawn


def parsed(text):
    found = Balance()
    found.feed(text)
    assert found.open == []
    return found


SECTIONS = (
    Page.Section(
        "First & <last>",
        [Markup.paragraph("a < b & c"), Markup.badge("passed", "good"), Markup.picture(figure(), "a line", "x")],
    ),
    Page.Section(
        "Second", [Table(["name", "value"], [["<x>", "1"]]), Markup.folded("more", Markup.facts([("k", "v")]))]
    ),
    Page.Section("Third", ["plain <text>"]),
)


def test_every_element_is_closed_and_text_is_shown_as_it_was_given():
    found = parsed(page_text(Page("T < 1", "s", SECTIONS, ["const a = 1 < 2;"])))
    for text in ("a < b & c", "<x>", "plain <text>", "First & <last>", "T < 1"):
        assert text in found.text


def test_a_page_asks_for_nothing_from_elsewhere():
    found = parsed(page_text(Page("t", "s", SECTIONS)))
    assert found.addresses
    assert all(address.startswith(("data:", "#")) for address in found.addresses)


def test_contents_link_to_every_section():
    text = page_text(Page("t", "s", SECTIONS))
    for section in SECTIONS:
        assert f'href="#{section.anchor}"' in text
        assert f'id="{section.anchor}"' in text


def test_the_same_figure_gives_the_same_bytes():
    assert Figures.png(figure()) == Figures.png(figure())


def test_markup_is_not_escaped_again_and_attributes_always_are():
    assert Markup.joined([Markup("<b>"), "<b>"]) == "<b>&lt;b&gt;"
    assert Markup.element("a", "x", class_="c", data_key='"<', hidden=None) == (
        '<a class="c" data-key="&quot;&lt;">x</a>'
    )


def test_rows_and_titles_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="a row of 1 cells in a table of 2"):
        Table(["a", "b"], [["1"]])
    with pytest.raises(ValueError, match="titles that differ"):
        page_text(Page("t", "s", [Page.Section("A b", []), Page.Section("a-B", [])]))


def test_a_page_that_cannot_be_written_is_an_error_and_leaves_nothing(tmp_path):
    with pytest.raises(HcssError):
        Page("t", "s", SECTIONS).write(tmp_path / "missing" / "page.html")
    assert list(tmp_path.iterdir()) == []
    Page("t", "s", SECTIONS).write(tmp_path / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


# --- the same as text


def test_a_table_is_one_on_a_page_and_aligned_lines_on_a_terminal():
    data = Table(["name", "value"], [["<x>", "1"], ["longer", "23.5"]], "All of them.")
    assert list(data.lines()) == ["All of them.", "  name    value", "  <x>         1", "  longer   23.5"]
    found = parsed(page_text(Page("t", "s", [Page.Section("A", [data])])))
    for text in ("All of them.", "<x>", "23.5"):
        assert text in found.text


def test_a_row_of_one_cell_is_a_heading_that_widens_no_column():
    rows = [["", "a", "b"], ["a group of measures"], ["x", "1", "22"]]
    assert list(Table.aligned(rows)) == ["     a   b", "a group of measures", "  x  1  22"]


def test_text_beside_a_label_is_wrapped_below_itself_and_words_stay_whole():
    lines = Table.labelled("sea", "word " * 60, 13, 4).splitlines()
    assert lines[0].startswith("  sea          word")
    assert all(line.startswith(" " * 19 + "word") for line in lines[1:])
    assert max(map(len, lines)) <= WIDTH
    assert Table.labelled("", "x" * 200, 13).endswith("x" * 200)


@pytest.mark.parametrize(
    ("bound", "text"), [(None, "unknown"), (0.0, "nothing"), (0.0123, "1.2 %"), (1.0, "1 x"), (2.55, "2.5 x")]
)
def test_bounds_are_percentages_below_one_and_factors_above(bound, text):
    assert bound_text(bound) == text


def test_a_number_that_is_none_is_missing_and_zero_has_no_sign():
    assert [Table.number(each) for each in (None, float("nan"), float("inf"), -0.0, 1.23456)] == [
        "-",
        "-",
        "-",
        "0",
        "1.235",
    ]
