"""What the providers of all kinds share.

Notes of providers that are told only where they apply. Not part of the frozen interface: plain text always works.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, Self

from hcss_twin.core.arrays import Array

"""Numbers as the contract wants them everywhere but in cloud fields: float64."""


@dataclass(frozen=True)
class Declares:
    """What a provider says about itself; it only removes work or places nodes.

    Leave out what you do not know, but never a dependence: what ``depends_on`` leaves out may be asked for once and
    used everywhere.

    Attributes
    ----------
    depends_on : frozenset of str
        Among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``, ``time``.
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1`` of every kind but the radiance model, and of a
        transmittance provider also ``view_zenith`` (degrees) and ``target_altitude_m`` (of the lower ends of legs).
        Asking outside is an error.
    native_grid_cm1 : ndarray (N,), optional
        Of a transmittance provider: ascending spectral nodes to which calls are restricted between band edges.
    resolution_cm1 : float
        Spectral resolution of its results; 0 where the provider is pointwise.
    evolves : bool
        Whether a cloud field changes other than by translation.
    tileable : bool
        Whether a cloud generator can give any window of a frame alone.
    notes : tuple of str
        What a user should know; copied into plan and cube.
    legs : {"any", "to_space"}
        Paths a transmittance provider knows: any legs, or only such as reach from one target to space. For the
        latter the radiance model fits a law that serves other paths.
    notes_by_phase : mapping of str to tuple of str
        The same of an optics provider, told only where a layer has particles of that phase ("water", "ice").
    own_errors : tuple of str
        How far the provider itself may be off, with against what that was found: quoted beside the engine's error in
        the certificate of a cube, never added to it.
    reach_pixels : int or None
        Of a sensor: how many rows or columns away a pixel can be that has a share in what another one measures; 0
        where each pixel stands alone, None where the whole frame has. As much of the scene is computed around frames.
    remembers : bool
        Whether what a sensor measures depends on earlier frames, so that it needs all of them in order.
    """

    depends_on: frozenset[str] = frozenset()
    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    native_grid_cm1: Array | None = None
    resolution_cm1: float = 0.0
    evolves: bool = False
    tileable: bool = True
    notes: tuple[str, ...] = ()
    legs: Literal["any", "to_space"] = "any"
    notes_by_phase: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    own_errors: tuple[str, ...] = ()
    reach_pixels: int | None = 0
    remembers: bool = False


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
    return replace(declares, notes=told(declares.notes), notes_by_phase=by_phase, own_errors=told(declares.own_errors))


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
