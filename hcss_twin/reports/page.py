"""A report as one self-contained HTML file, without network access or other files.

A page is data: sections with a title and blocks. A block is text, a :class:`~hcss_twin.reports.tables.Table`, or markup
made by the functions here. :func:`page_text` alone renders it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from pathlib import Path
from typing import Literal, TypeAlias

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import Writing
from hcss_twin.reports.tables import Table


class Markup(str):
    """Text that is already HTML; all other strings are escaped when added to a page."""

    __slots__ = ()


Block: TypeAlias = str | Table
Tone = Literal["good", "fair", "bad", "plain"]

_VOID = {"br", "img", "input"}


def markup(block: Block) -> Markup:
    """Return a block as HTML: render tables, and escape text unless it is markup already."""
    if isinstance(block, Table):
        return _table(block)
    return block if isinstance(block, Markup) else Markup(escape(block))


def joined(parts: Iterable[Block], between: str = "") -> Markup:
    """Return concatenated blocks as HTML, with text escaped."""
    return Markup(markup(between).join(markup(part) for part in parts))


def element(name: str, *content: Block, **attributes: str | None) -> Markup:
    """Return ``<name ...>content</name>``.

    Parameters
    ----------
    name : str
    content : str or Table
        Escaped unless it is markup.
    attributes : str or None
        Underscores become hyphens, the one of ``class_`` is removed; None omits the attribute.
    """
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(value, quote=True)}"'
        for key, value in attributes.items()
        if value is not None
    )
    opening = f"<{name}{written}>"
    return Markup(opening if name in _VOID else f"{opening}{joined(content)}</{name}>")


def paragraph(text: Block) -> Markup:
    """Return one paragraph."""
    return element("p", text)


def note(text: str, tone: Tone = "plain") -> Markup:
    """Return a highlighted paragraph; ``tone`` sets the colour of its edge."""
    return element("p", text, class_=f"note {tone}")


def badge(text: str, tone: Tone = "plain") -> Markup:
    """Return a short coloured verdict; the text carries the same meaning as the colour."""
    return element("span", text, class_=f"badge {tone}")


def bullets(items: Iterable[str]) -> Markup:
    """Return a list with bullets."""
    return element("ul", *(element("li", item) for item in items))


def facts(pairs: Iterable[tuple[str, str]]) -> Markup:
    """Return names and their values in two columns."""
    return element("dl", *(part for name, value in pairs for part in (element("dt", name), element("dd", value))))


def folded(summary: str, *content: Block) -> Markup:
    """Return content that is shown when its summary is clicked, and always in print."""
    return element("details", element("summary", summary), *content)


def preformatted(text: str) -> Markup:
    """Return preformatted text."""
    return element("div", element("pre", text), class_="scroll")


def beside(*content: Block) -> Markup:
    """Return blocks side by side if the screen is wide enough."""
    return element("div", *content, class_="beside")


def _table(table: Table) -> Markup:
    """Return a table that scrolls separately on narrow screens; rows with numbers do not wrap."""
    head = element("tr", *(element("th", name, scope="col") for name in table.header))
    body = (
        element(
            "tr",
            *(
                element("td", cell, class_=None if column < table.text_columns else "number")
                for column, cell in enumerate(row)
            ),
        )
        for row in table.rows
    )
    caption = element("caption", table.caption) if table.caption else Markup("")
    whole = element("table", caption, element("thead", head), element("tbody", *body))
    return element("div", whole, class_="scroll" if table.text_columns >= len(table.header) else "scroll nowrap")


@dataclass(frozen=True)
class Section:
    """A heading and the blocks below it; text is escaped unless it is markup."""

    title: str
    content: Sequence[Block]

    @property
    def anchor(self) -> str:
        """Anchor of the section in links."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes
    ----------
    title, subtitle : str
    sections : sequence of Section
        Sections; a list of links at the top if there are more than two.
    scripts : sequence of str
        Optional JavaScript at the end of the page, for interactive parts.
    """

    title: str
    subtitle: str
    sections: Sequence[Section]
    scripts: Sequence[str] = ()


def resource(name: str) -> str:
    """Return a style sheet or a script of this package."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


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
    links = (element("a", section.title, href=f"#{section.anchor}") for section in page.sections)
    contents = element("nav", *links) if len(page.sections) > 2 else ""
    body = (
        element("section", element("h2", section.title), *section.content, id=section.anchor)
        for section in page.sections
    )
    scripts = "".join(f"<script>{script}</script>" for script in page.scripts)
    head = (
        '<meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"{element('title', page.title)}<style>{resource('style.css')}</style>"
    )
    heading = element("header", element("h1", page.title), element("p", page.subtitle))
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>{heading}{contents}\n'
        f"<main>{joined(body)}</main>{scripts}</body></html>\n"
    )


def write_page(path: Path, page: Page) -> None:
    """Write a page atomically.

    Raises
    ------
    HcssError
        If it cannot be written.
    """
    text = page_text(page)
    with Writing(path, HcssError, "HTML") as draft:
        draft.write_text(text, encoding="utf-8")
