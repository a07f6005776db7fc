"""Directions toward the sensor, between which radiance is tabulated."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

from hcss_twin.providers import Sun, View


class Views(Protocol):
    """The view from any position in a rectangle."""

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        ...


class Directions(Views, Protocol):
    """All directions of a sequence as a rectangle of coordinates in which radiance is smooth."""

    @property
    def suns(self) -> Callable[[View], list[Sun | None]] | None:
        """Returns the suns of the place of a view at some frames; None if all places have one sun."""
        ...
