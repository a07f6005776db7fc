"""Text that is HTML already, and text that is not."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


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
