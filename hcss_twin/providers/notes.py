"""Notes of providers that are told only where they apply. Not part of the frozen interface: plain text always works."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Self


class Note(str):
    """A note for ``Declares.notes`` that does not apply to every scene.

    Parameters
    ----------
    text : str
    sunlight : bool
        Told only where sunlight is computed.
    below_um : float
        Told only where a band reaches below this wavelength.
    """

    sunlight: bool
    below_um: float

    def __new__(cls, text: str, *, sunlight: bool = False, below_um: float = math.inf) -> Self:
        """Make a text that knows where it applies."""
        note = super().__new__(cls, text)
        note.sunlight, note.below_um = sunlight, below_um
        return note


def applying(notes: Iterable[str], sunlight: bool, shortest_um: float) -> tuple[str, ...]:
    """Return the notes that apply to a scene, each once, with its sunlight and its shortest wavelength."""
    told = (
        note
        for note in notes
        if not isinstance(note, Note) or ((sunlight or not note.sunlight) and shortest_um < note.below_um)
    )
    return tuple(dict.fromkeys(told))
