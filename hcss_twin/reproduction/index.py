"""Everything that can be computed again, and how it is named."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.errors import HcssError, choose_from
from hcss_twin.reproduction.figure_items import FIGURES
from hcss_twin.reproduction.item import Item
from hcss_twin.reproduction.table_items import TABLES

ITEMS: tuple[Item, ...] = TABLES + FIGURES

_ROMAN = ("0", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X")


def chosen(names: Sequence[str]) -> tuple[Item, ...]:
    """Return the items of these names in the order of :data:`ITEMS`; all where none is named.

    Raises
    ------
    HcssError
        If there is none of a name; the closest is told.
    """
    known = {item.name: item for item in ITEMS}
    for name in names:
        if name not in known:
            raise HcssError(f"no item '{name}'; {choose_from(name, known)}")
    return tuple(item for item in ITEMS if not names or item.name in names)


def heading(name: str) -> str:
    """Return the name of an item as the paper writes it: ``Table IV, modtran``, ``Figure 12``."""
    kind, *rest = name.split("-")
    if not rest:
        return kind.capitalize()
    number = _ROMAN[int(rest[0])] if kind == "table" and rest[0].isdigit() else rest[0]
    return ", ".join([f"{kind.capitalize()} {number}", *(word.upper() for word in rest[1:])])
