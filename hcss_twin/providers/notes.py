"""Notes of providers that are told only where they apply. Not part of the frozen interface: plain text always works."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Self

from hcss_twin.providers.common import Declares


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


def attributed(declares: Declares, speaker: str) -> Declares:
    """Return a declaration whose notes and own errors begin with who says so.

    Parameters
    ----------
    declares : Declares
    speaker : str
        For example ``"optics provider ada"``.
    """

    def told(texts: Iterable[str]) -> tuple[str, ...]:
        return tuple(_with_text(text, f"{speaker}: {text}") for text in texts)

    by_phase = {phase: told(texts) for phase, texts in declares.notes_by_phase.items()}
    return replace(
        declares, notes=told(declares.notes), notes_by_phase=by_phase, own_errors=told(declares.own_errors)
    )


def _with_text(note: str, text: str) -> str:
    return Note(text, sunlight=note.sunlight, below_um=note.below_um) if isinstance(note, Note) else text


def applying(notes: Iterable[str], sunlight: bool, shortest_um: float) -> tuple[str, ...]:
    """Return the notes that apply to a scene, each once, with its sunlight and its shortest wavelength."""
    told = (
        note
        for note in notes
        if not isinstance(note, Note) or ((sunlight or not note.sunlight) and shortest_um < note.below_um)
    )
    return tuple(dict.fromkeys(told))
