"""What stands in a section of a page: paragraphs, tables, lists of facts, verdicts, folded parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from hcss_twin.reporting.page.markup import Markup, element, joined

Tone = Literal["good", "fair", "bad", "plain"]


def paragraph(text: str) -> Markup:
    """Return one paragraph."""
    return element("p", text)


def note(text: str, tone: Tone = "plain") -> Markup:
    """Return a paragraph that is set off; ``tone`` colours its edge."""
    return element("p", text, class_=f"note {tone}")


def badge(text: str, tone: Tone = "plain") -> Markup:
    """Return a short verdict in a colour; its text says what the colour says."""
    return element("span", text, class_=f"badge {tone}")


def bullets(items: Iterable[str]) -> Markup:
    """Return a list with bullets."""
    return element("ul", *(element("li", item) for item in items))


def facts(pairs: Iterable[tuple[str, str]]) -> Markup:
    """Return names and what they stand for, in two columns."""
    rows = (Markup(element("dt", name) + element("dd", value)) for name, value in pairs)
    return element("dl", *rows)


def table(
    header: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", text_columns: int = 1
) -> Markup:
    """Return a table that scrolls by itself where the screen is narrow.

    Parameters
    ----------
    header : sequence of str
    rows : iterable of sequence of str
        As many cells as the header; numbers are formatted by the caller.
    caption : str, optional
    text_columns : int
        So many from the left are aligned as text; the others, numbers, to the right.

    Raises
    ------
    ValueError
        If a row has another length than the header.
    """
    head = element("tr", *(element("th", name, scope="col") for name in header))
    body = []
    for row in rows:
        if len(row) != len(header):
            raise ValueError(f"a row of {len(row)} cells in a table of {len(header)}: {list(row)}")
        cells = (
            element("td", cell, class_=None if place < text_columns else "number")
            for place, cell in enumerate(row)
        )
        body.append(element("tr", *cells))
    title = element("caption", caption) if caption else Markup("")
    return element(
        "div", element("table", title, element("thead", head), element("tbody", *body)), class_="scroll"
    )


def folded(summary: str, *content: str) -> Markup:
    """Return content that is shown when its summary is clicked, and always on paper."""
    return element("details", element("summary", summary), *content)


def preformatted(text: str) -> Markup:
    """Return text with the line ends and blanks it has."""
    return element("div", element("pre", text), class_="scroll")


def beside(*content: str) -> Markup:
    """Return blocks side by side where the screen is wide enough."""
    return Markup(f'<div class="beside">{joined(content)}</div>')
