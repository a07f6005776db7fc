"""What providers declare: notes for users and properties that let the engine skip work or place nodes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, Self, TypeVar

from hcss_twin.core.errors import choose_from


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """What a provider of any kind can declare; kinds with more have a declaration of their own.

    Attributes
    ----------
    notes : tuple of str
        Notes for users; copied into plan and cube.
    own_errors : tuple of str
        Provider-stated accuracy with its reference, quoted in the certificate in addition to the engine's error.
    """

    notes: tuple[str, ...] = ()
    own_errors: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ModelError:
    """How far a provider is from the best reference known, for some wavelengths, columns and views.

    Attributes
    ----------
    name : str
        What errs: ``gas``, ``particles``, ``sea``, ``plane-parallel clouds``.
    lower_um, upper_um : float
        Wavelengths of the figure.
    relative, kelvin : float or None
        Error of the band radiance, and of the brightness temperature; the engine derives the one that is None.
    statistic : str
        ``rms`` or ``largest``, over the columns of the condition.
    condition : str
        Columns and paths that were compared.
    source : str
        The reference.
    command : str
        Command that computes the figure again; empty: a figure of notes, not recomputed.
    path : str
        ``up``: radiance toward the sensor, the only one in a scene's total; ``sky`` and ``sun``: other paths.
    column : str
        ``clear``, ``cloudy``, the name or material of a cloud layer, or empty for all.
    sunlight : bool or None
        Only with or only without sunlight; None: both.
    zenith_deg : (float, float)
        View zenith angles.
    needs : str
        Key and value that avoid the error, if there are any.
    """

    name: str
    lower_um: float
    upper_um: float
    relative: float | None = None
    kelvin: float | None = None
    statistic: str = "rms"
    condition: str = ""
    source: str = ""
    command: str = ""
    path: str = "up"
    column: str = ""
    sunlight: bool | None = None
    zenith_deg: tuple[float, float] = (0.0, 90.0)
    needs: str = ""

    def __post_init__(self) -> None:
        sizes = [size for size in (self.relative, self.kelvin) if size is not None]
        if not sizes or not all(math.isfinite(size) and size >= 0.0 for size in sizes):
            raise ValueError(
                f"model error '{self.name}': relative {self.relative}, kelvin {self.kelvin}; allowed: one or both, "
                "0 or more"
            )
        if not 0.0 < self.lower_um < self.upper_um:
            raise ValueError(
                f"model error '{self.name}': {self.lower_um} to {self.upper_um} um; allowed: 0 < lower < upper"
            )
        if self.path not in PATHS:
            raise ValueError(f"model error '{self.name}': path {self.path!r}; {choose_from(self.path, PATHS)}")


PATHS = ("up", "sky", "sun")
"""Paths of a :class:`ModelError`."""


class ProviderOptions(Protocol):
    """Optional members of a provider of any kind.

    Attributes
    ----------
    expected_failures : mapping of str to str
        Laws of the conformance kit that the provider breaks on purpose, each with the reason; on the class.
    cache_token : str or None
        Names the state of what results depend on beside inputs, parameters, code and files of the catalog: the version
        of a remote table, the hash of a generated file. Cached results of another token are not used.
    """

    expected_failures: Mapping[str, str]
    cache_token: str | None

    def model_errors(self) -> Sequence[ModelError]:
        """Return how far the provider is from the best reference known; without this member it is ``unknown``.

        ``hcss plugins NAME`` shows the figures of a static or class method, which do not depend on a scene.
        """


class Note(str):
    """A note for ``Declaration.notes`` that does not apply to every scene.

    Parameters
    ----------
    text : str
    sunlight : bool
        Only for scenes with sunlight.
    below_um : float
        Only for bands that reach below this wavelength.
    narrow_cm1 : tuple of (float, float, float)
        Only for bands, which the note then names, that reach into one of these ranges (first and last wavenumber) and
        are narrower than its width (third number).
    """

    sunlight: bool
    below_um: float
    narrow_cm1: tuple[tuple[float, float, float], ...]

    def __new__(
        cls,
        text: str,
        *,
        sunlight: bool = False,
        below_um: float = math.inf,
        narrow_cm1: tuple[tuple[float, float, float], ...] = (),
    ) -> Self:
        """Create the text with its conditions."""
        note = super().__new__(cls, text)
        note.sunlight, note.below_um, note.narrow_cm1 = sunlight, below_um, narrow_cm1
        return note

    def is_about(self, lower_um: float, upper_um: float) -> bool:
        """Whether the note applies to a band."""
        first, last = 1e4 / upper_um, 1e4 / lower_um
        return lower_um < self.below_um and (
            not self.narrow_cm1
            or any(first < high and low < last and last - first < width for low, high, width in self.narrow_cm1)
        )


Declared = TypeVar("Declared", bound=Declaration)


def attributed(declares: Declared, speaker: str) -> Declared:
    """Return a declaration whose notes and own errors begin with ``speaker``, e.g. ``"optics provider ada"``."""

    def with_speaker(texts: Iterable[str]) -> tuple[str, ...]:
        spoken = ((note, f"{speaker}: {note}") for note in texts)
        return tuple(Note(text, **vars(note)) if isinstance(note, Note) else text for note, text in spoken)

    spoken: dict[str, Any] = {name: with_speaker(getattr(declares, name)) for name in ("notes", "own_errors")}
    by_material = getattr(declares, "notes_by_material", None)
    if by_material is not None:
        spoken["notes_by_material"] = {name: with_speaker(texts) for name, texts in by_material.items()}
    return replace(declares, **spoken)


def applying(notes: Iterable[str], sunlight: bool, bands: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """Return the notes that apply to a scene, each once.

    Parameters
    ----------
    sunlight : bool
        Whether the scene has sunlight.
    bands : mapping of str to (float, float)
        Shortest and longest wavelength of each band, um.
    """
    selected: list[str] = []
    for note in notes:
        if not isinstance(note, Note):
            selected.append(note)
        elif sunlight or not note.sunlight:
            about = [name for name, limits in bands.items() if note.is_about(*limits)]
            selected += [f"band '{name}': {note}" for name in about] if note.narrow_cm1 else [note] * bool(about)
    return tuple(dict.fromkeys(selected))


def among(*names: str) -> dict[str, Any]:
    """Return the metadata of a field that may hold only these names."""
    return {"among": names}
