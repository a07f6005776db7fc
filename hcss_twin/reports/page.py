"""A report as one self-contained HTML file, without network access or other files.

A page is data: sections with a title and blocks. A block is text, a :class:`~hcss_twin.reports.tables.Table`, or
:class:`Markup`. :func:`page_text` alone renders it.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from hcss_twin.core.errors import HcssError
from hcss_twin.core.files import Writing
from hcss_twin.reports.figures import Figures
from hcss_twin.reports.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


__all__ = ["Markup", "Page"]

LONG_CELL = 40
"""Characters beyond which a cell of a table wraps."""

_VOID = {"br", "img", "input"}


class Markup(str):
    """Text that is already HTML, and what makes it; all other strings are escaped when added to a page.

    Attributes
    ----------
    Block
        What a section consists of: text, markup or a table.
    Tone
        Colours of notes and badges.
    """

    Block: TypeAlias = str | Table
    Tone = Literal["good", "fair", "bad", "plain"]

    __slots__ = ()

    @staticmethod
    def of(block: Block) -> Markup:
        """Return a block as HTML: render tables, and escape text unless it is markup already."""
        if isinstance(block, Table):
            return Markup.table(block)
        return block if isinstance(block, Markup) else Markup(escape(block))

    @staticmethod
    def joined(parts: Iterable[Block], between: str = "") -> Markup:
        """Return concatenated blocks as HTML, with text escaped."""
        return Markup(Markup.of(between).join(Markup.of(part) for part in parts))

    @staticmethod
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
        return Markup(opening if name in _VOID else f"{opening}{Markup.joined(content)}</{name}>")

    @staticmethod
    def paragraph(text: Block) -> Markup:
        """Return one paragraph."""
        return Markup.element("p", text)

    @staticmethod
    def note(text: str, tone: Tone = "plain") -> Markup:
        """Return a highlighted paragraph; ``tone`` sets the colour of its edge."""
        return Markup.element("p", text, class_=f"note {tone}")

    @staticmethod
    def badge(text: str, tone: Tone = "plain") -> Markup:
        """Return a short coloured verdict; the text carries the same meaning as the colour."""
        return Markup.element("span", text, class_=f"badge {tone}")

    @staticmethod
    def bullets(items: Iterable[str]) -> Markup:
        """Return a list with bullets."""
        return Markup.element("ul", *(Markup.element("li", item) for item in items))

    @staticmethod
    def facts(pairs: Iterable[tuple[str, str]]) -> Markup:
        """Return names and their values in two columns."""
        return Markup.element(
            "dl", *(part for name, value in pairs for part in (Markup.element("dt", name), Markup.element("dd", value)))
        )

    @staticmethod
    def folded(summary: str, *content: Block) -> Markup:
        """Return content that is shown when its summary is clicked, and always in print."""
        return Markup.element("details", Markup.element("summary", summary), *content)

    @staticmethod
    def preformatted(text: str) -> Markup:
        """Return preformatted text."""
        return Markup.element("div", Markup.element("pre", text), class_="scroll")

    @staticmethod
    def beside(*content: Block) -> Markup:
        """Return blocks side by side if the screen is wide enough."""
        return Markup.element("div", *content, class_="beside")

    @staticmethod
    def table(table: Table) -> Markup:
        """Return a table that scrolls separately on narrow screens; rows with numbers do not wrap."""
        head = Markup.element("tr", *(Markup.element("th", name, scope="col") for name in table.header))
        body = (
            Markup.element(
                "tr",
                *(
                    Markup.element("td", cell, class_=_kind(cell, column < table.text_columns))
                    for column, cell in enumerate(row)
                ),
            )
            for row in table.rows
        )
        caption = Markup.element("caption", table.caption) if table.caption else Markup("")
        whole = Markup.element("table", caption, Markup.element("thead", head), Markup.element("tbody", *body))
        return Markup.element(
            "div", whole, class_="scroll" if table.text_columns >= len(table.header) else "scroll nowrap"
        )

    @staticmethod
    def drawing(figure: Figure, alternative: str, caption: str = "", wide: bool = False) -> Markup:
        """Return a figure of lines as SVG, sharp at any size; the same figure gives the same bytes.

        Parameters
        ----------
        figure : Figure
        alternative, caption : str
            As for :func:`picture`.
        wide : bool
            Keep its size on narrow screens, where it scrolls.
        """
        import matplotlib as mpl

        stream = io.BytesIO()
        with mpl.rc_context({"svg.hashsalt": "hcss", "svg.fonttype": "path"}):
            figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        return Markup._figure(data_address(stream.getvalue(), "image/svg+xml"), alternative, caption, wide)

    @staticmethod
    def picture(content: Figure | bytes, alternative: str, caption: str = "") -> Markup:
        """Return a picture with its caption.

        Parameters
        ----------
        content : Figure or bytes
            A figure of matplotlib, or the bytes of a PNG file.
        alternative : str
            Alternative text for screen readers.
        caption : str, optional
            Caption below the picture.
        """
        png = content if isinstance(content, bytes) else Figures.png(content)
        return Markup._figure(data_address(png), alternative, caption)

    @staticmethod
    def _figure(address: str, alternative: str, caption: str, wide: bool = False) -> Markup:
        image = Markup.element("img", src=address, alt=alternative, loading="lazy")
        shown = Markup.element("div", image, class_="scroll keeps-size") if wide else image
        return Markup.element("figure", shown, *([Markup.element("figcaption", caption)] if caption else []))


def _kind(cell: str, is_text: bool) -> str | None:
    """Return the class of a cell of a table."""
    return "long" if len(cell) > LONG_CELL else None if is_text else "number"


def data_address(content: bytes, media_type: str = "image/png") -> str:
    """Return bytes as a data URL."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes
    ----------
    title, subtitle : str
    sections : sequence of Page.Section
        Sections; a list of links at the top if there are more than two.
    scripts : sequence of str
        Optional JavaScript at the end of the page, for interactive parts.
    """

    @dataclass(frozen=True)
    class Section:
        """A heading and the blocks below it; text is escaped unless it is markup."""

        title: str
        content: Sequence[Markup.Block]

        @property
        def anchor(self) -> str:
            """Anchor of the section in links."""
            return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")

    title: str
    subtitle: str
    sections: Sequence[Page.Section]
    scripts: Sequence[str] = ()

    def write(self, path: Path) -> None:
        """Write the page atomically.

        Raises
        ------
        HcssError
            If it cannot be written.
        """
        text = page_text(self)
        with Writing(path, HcssError, "HTML") as draft:
            draft.write_text(text, encoding="utf-8")


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
    links = (Markup.element("a", section.title, href=f"#{section.anchor}") for section in page.sections)
    contents = Markup.element("nav", *links) if len(page.sections) > 2 else ""
    body = (
        Markup.element("section", Markup.element("h2", section.title), *section.content, id=section.anchor)
        for section in page.sections
    )
    scripts = "".join(f"<script>{script}</script>" for script in page.scripts)
    head = (
        '<meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"{Markup.element('title', page.title)}<style>{resource('style.css')}</style>"
    )
    heading = Markup.element("header", Markup.element("h1", page.title), Markup.element("p", page.subtitle))
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>{heading}{contents}\n'
        f"<main>{Markup.joined(body)}</main>{scripts}</body></html>\n"
    )
