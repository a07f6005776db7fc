"""The figures that can be computed."""

from __future__ import annotations

from hcss_twin.reproduction.item import Item

FIGURES: tuple[Item, ...] = ()
