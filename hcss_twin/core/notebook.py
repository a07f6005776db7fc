"""Objects in notebooks and at the prompt: a title and labelled lines, as text or as a small table of HTML."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

Rows = Iterable[tuple[str, str]]


def as_text(title: str, rows: Rows) -> str:
    """Return a title with labelled lines below it."""
    listed = list(rows)
    width = max((len(label) for label, _ in listed), default=0)
    return "\n".join([title, *(f"  {label:<{width}}  {text}" for label, text in listed)])


def as_html(title: str, rows: Rows, folded: tuple[str, str] | None = None) -> str:
    """Return the same as a table in the colours of the page, with a text that opens when its heading is clicked."""
    cells = "".join(
        f'<tr><th style="text-align:left;vertical-align:top">{escape(label)}</th>'
        f'<td style="text-align:left">{escape(text)}</td></tr>'
        for label, text in rows
    )
    more = ""
    if folded is not None:
        more = f"<details><summary>{escape(folded[0])}</summary><pre>{escape(folded[1])}</pre></details>"
    return f"<div><strong>{escape(title)}</strong><table>{cells}</table>{more}</div>"
