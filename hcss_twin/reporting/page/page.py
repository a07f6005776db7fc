"""One file that holds a whole report: no network, no other files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

from hcss_twin.drafts import draft_of
from hcss_twin.errors import HcssError
from hcss_twin.reporting.page.markup import Markup, element, joined


@dataclass(frozen=True)
class Section:
    """A heading and what stands below it.

    Attributes
    ----------
    title : str
    content : sequence of str
        Blocks (:mod:`hcss_twin.reporting.page.blocks`); text that is no markup is escaped.
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
    with draft_of(path, HcssError) as draft:
        draft.write_text(text, encoding="utf-8")
