"""Text that is HTML already, and text that is not.

What stands in a section of a page: paragraphs, tables, lists of facts, verdicts, folded parts.

One file that holds a whole report: no network, no other files.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib import resources
from pathlib import Path
from typing import Literal

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import atomic_write


class Markup(str):
    """Text that is HTML already; every other string is escaped where it enters a page."""

    __slots__ = ()


def markup(text: str) -> Markup:
    """Return text as HTML: escaped, unless it is markup already."""
    return text if isinstance(text, Markup) else Markup(escape(text))


def joined(parts: Iterable[str], between: str = "") -> Markup:
    """Return parts one after the other; those that are not markup are escaped, ``between`` too."""
    return Markup(markup(between).join(markup(part) for part in parts))


def element(name: str, *content: str, **attributes: str | None) -> Markup:
    """Return ``<name ...>content</name>``.

    Parameters
    ----------
    name : str
        Of the element.
    content : str
        Escaped unless it is markup.
    attributes : str or None
        Underscores become hyphens, ``class_`` and ``for_`` lose theirs; None leaves the attribute out.
    """
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(value, quote=True)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Markup(f"<{name}{written}>{joined(content)}</{name}>")


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


def table(header: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", text_columns: int = 1) -> Markup:
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
            element("td", cell, class_=None if place < text_columns else "number") for place, cell in enumerate(row)
        )
        body.append(element("tr", *cells))
    title = element("caption", caption) if caption else Markup("")
    return element("div", element("table", title, element("thead", head), element("tbody", *body)), class_="scroll")


def folded(summary: str, *content: str) -> Markup:
    """Return content that is shown when its summary is clicked, and always on paper."""
    return element("details", element("summary", summary), *content)


def preformatted(text: str) -> Markup:
    """Return text with the line ends and blanks it has."""
    return element("div", element("pre", text), class_="scroll")


def beside(*content: str) -> Markup:
    """Return blocks side by side where the screen is wide enough."""
    return Markup(f'<div class="beside">{joined(content)}</div>')


@dataclass(frozen=True)
class Section:
    """A heading and what stands below it.

    Attributes
    ----------
    title : str
    content : sequence of str
        Blocks (:mod:`hcss_twin.report.page.page`); text that is no markup is escaped.
    """

    title: str
    content: Sequence[str]

    @property
    def anchor(self) -> str:
        """Name of the section in addresses."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes
    ----------
    title, subtitle : str
    sections : sequence of Section
        Listed at the top, with links, where there are more than two.
    scripts : sequence of str
        JavaScript that stands at the end of the page, for the parts that move; the page can be read without.
    styles : sequence of str
        Style sheets of parts that only this page has, after that of all pages.
    """

    title: str
    subtitle: str
    sections: Sequence[Section]
    scripts: Sequence[str] = field(default=())
    styles: Sequence[str] = field(default=())


def page_text(page: Page) -> str:
    """Return the page as HTML 5.

    Raises
    ------
    ValueError
        If two sections have the same anchor.
    """
    anchors = [section.anchor for section in page.sections]
    if len(set(anchors)) != len(anchors):
        raise ValueError(f"sections of one page need titles that differ: {anchors}")
    style = (resources.files(__package__) / "style.css").read_text(encoding="utf-8")
    links = (element("a", section.title, href=f"#{section.anchor}") for section in page.sections)
    contents = element("nav", *links) if len(page.sections) > 2 else Markup("")
    body = (
        element("section", element("h2", section.title), *section.content, id=section.anchor)
        for section in page.sections
    )
    scripts = (Markup(f"<script>{script}</script>") for script in page.scripts)
    head = (
        '<meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"{element('title', page.title)}<style>{''.join([style, *page.styles])}</style>"
    )
    heading = element("header", element("h1", page.title), element("p", page.subtitle))
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>{heading}{contents}\n'
        f"<main>{joined(body)}</main>{joined(scripts)}</body></html>\n"
    )


def write_page(path: Path, page: Page) -> None:
    """Write a page; the file appears when it is whole.

    Raises
    ------
    HcssError
        If it cannot be written.
    """
    text = page_text(page)
    with atomic_write(path, HcssError) as draft:
        draft.write_text(text, encoding="utf-8")
