"""Declarations common to all kinds of providers, and their checks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import choose_from


@dataclass(frozen=True)
class Declares:
    """Properties of a provider that let the engine skip work or place nodes.

    All have defaults. Declare every dependence: the engine may reuse one result for all values of other variables.

    Attributes
    ----------
    depends_on : frozenset of str
        Among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``, ``time``.
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1`` for every kind but the radiance model; for a
        transmittance provider also ``view_zenith`` (degrees) and ``target_altitude_m`` (of the lower ends of legs).
    native_grid_cm1 : ndarray (N,), optional
        For a transmittance provider: ascending spectral nodes; calls use only these and band edges.
    resolution_cm1 : float
        Spectral resolution of the results; 0: monochromatic.
    evolves : bool
        Whether a cloud field changes in other ways than by translation.
    tileable : bool
        Whether a cloud generator can give any window of a frame alone.
    notes : tuple of str
        Notes for users; copied into plan and cube.
    legs : {"any", "to_space"}
        Paths of a transmittance provider: any legs, or only legs from one target to space. The radiance model fits a
        law to the latter for other paths.
    notes_by_phase : mapping of str to tuple of str
        Notes of an optics provider for layers with particles of that phase ("water", "ice").
    own_errors : tuple of str
        Provider-stated accuracy with its reference, quoted in the certificate in addition to the engine's error.
    reach_pixels : int or None
        For a sensor: largest distance in rows or columns at which one pixel affects another; 0: none, None: the whole
        frame. The engine computes so much of the scene around the frames.
    remembers : bool
        Whether measurements depend on earlier frames, so that a sensor needs all of them in order.
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
        Only for scenes with sunlight.
    below_um : float
        Only for bands that reach below this wavelength.
    """

    sunlight: bool
    below_um: float

    def __new__(cls, text: str, *, sunlight: bool = False, below_um: float = math.inf) -> Self:
        """Create the text with its conditions."""
        note = super().__new__(cls, text)
        note.sunlight, note.below_um = sunlight, below_um
        return note


def attributed(declares: Declares, speaker: str) -> Declares:
    """Return a declaration whose notes and own errors begin with ``speaker``, e.g. ``"optics provider ada"``."""

    def with_speaker(texts: Iterable[str]) -> tuple[str, ...]:
        return tuple(_with_text(text, f"{speaker}: {text}") for text in texts)

    by_phase = {phase: with_speaker(texts) for phase, texts in declares.notes_by_phase.items()}
    return replace(
        declares,
        notes=with_speaker(declares.notes),
        notes_by_phase=by_phase,
        own_errors=with_speaker(declares.own_errors),
    )


def _with_text(note: str, text: str) -> str:
    return Note(text, sunlight=note.sunlight, below_um=note.below_um) if isinstance(note, Note) else text


def applying(notes: Iterable[str], sunlight: bool, shortest_um: float) -> tuple[str, ...]:
    """Return the notes that apply to a scene with this sunlight and shortest wavelength, each once."""
    selected = (
        note
        for note in notes
        if not isinstance(note, Note) or ((sunlight or not note.sunlight) and shortest_um < note.below_um)
    )
    return tuple(dict.fromkeys(selected))


DEPENDENCIES = ("view_zenith", "sun_zenith", "relative_azimuth", "thickness", "time")
"""Allowed names in ``Declares.depends_on``."""

RANGES = ("wavenumber_cm1", "view_zenith", "target_altitude_m")
"""Allowed names in ``Declares.valid``."""

LEGS = ("any", "to_space")
"""Allowed values of ``Declares.legs``."""

LAYER_OPTIONS = ("coverage_mode", "edge_taper")
"""Cloud-layer fields that a generator may ignore: the allowed names in ``honours``."""

FRACTION_TOLERANCE = 1e-9
"""Allowed rounding error of emissivity, transmittance, albedo and moments at their limits, in the kit and in runs."""

THICKNESS_TOLERANCE = 1e-6
"""Relative tolerance by which a float32 thickness may leave the layer's range, in the kit and in runs."""

KELVIN_TOLERANCE = 1e-6
"""Allowed rounding error of a surface temperature at the limits of its class, in the kit and in runs."""

MEASURED_LIMITS: Mapping[str, tuple[float, float]] = {
    "photon_rate": (-math.inf, math.inf),
    "digital_number": (0.0, 2.0**31 - 1.0),
    "saturated": (0.0, 2.0),
}
"""Ranges of a sensor's variables, in the kit and in runs."""

MEASURED = tuple(MEASURED_LIMITS)
"""Allowed names in ``Sensor.variables``."""


def check_declares(declares: Declares) -> None:
    """Check the names, ranges and types of a declaration.

    Raises
    ------
    ValueError
        If it names an unknown dependency or range, a range is not (low, high), the native grid does not ascend, or
        another field has the wrong type.
    """
    for name in declares.depends_on:
        if name not in DEPENDENCIES:
            raise ValueError(f"declares.depends_on names '{name}'; {choose_from(name, DEPENDENCIES)}")
    for name, bounds in declares.valid.items():
        if name not in RANGES:
            raise ValueError(
                f"declares.valid names '{name}', which the engine does not use; {choose_from(name, RANGES)}"
            )
        if len(bounds) != 2 or not bounds[0] <= bounds[1]:
            raise ValueError(f"declares.valid['{name}'] is {bounds}; expected (low, high)")
    if declares.legs not in LEGS:
        raise ValueError(f"declares.legs is {declares.legs!r}; {choose_from(str(declares.legs), LEGS)}")
    if not (math.isfinite(declares.resolution_cm1) and declares.resolution_cm1 >= 0.0):
        raise ValueError(f"declares.resolution_cm1 is {declares.resolution_cm1!r}; allowed: 0 or more")
    by_phase = {f"notes_by_phase['{phase}']": notes for phase, notes in declares.notes_by_phase.items()}
    for name, texts in {"notes": declares.notes, "own_errors": declares.own_errors, **by_phase}.items():
        # a single string is a sequence of letters, each of which would become a note
        if not isinstance(texts, tuple) or not all(isinstance(each, str) for each in texts):
            raise ValueError(f"declares.{name} is {texts!r}; expected a tuple of strings")
    for name in ("evolves", "tileable", "remembers"):
        if not isinstance(getattr(declares, name), bool):
            raise ValueError(f"declares.{name} is {getattr(declares, name)!r}; expected True or False")
    reach = declares.reach_pixels
    if reach is not None and (isinstance(reach, bool) or not isinstance(reach, int) or reach < 0):
        raise ValueError(f"declares.reach_pixels is {reach!r}; expected None or a whole number, 0 or more")
    _check_grid(declares.native_grid_cm1)


def _check_grid(grid: Any) -> None:
    if grid is None:
        return
    import numpy as np

    nodes = np.asarray(grid)
    if nodes.ndim != 1 or nodes.size < 2 or nodes.dtype.kind != "f" or not np.all(np.diff(nodes) > 0.0):
        raise ValueError(
            f"declares.native_grid_cm1 has shape {nodes.shape} and type {nodes.dtype}; expected two or more "
            "ascending floating-point wavenumbers"
        )


def check_options(provider: Any) -> None:
    """Check the values of a provider's optional attributes.

    Raises
    ------
    ValueError
        If a value does not match ``...Options`` of its kind in ``hcss_twin.providers``.
    """
    for name, (is_good, expected) in _OPTIONS.items():
        if hasattr(provider, name) and not is_good(getattr(provider, name)):
            raise ValueError(f"{name} is {getattr(provider, name)!r}; expected {expected}")


def check_measured(variables: Any) -> None:
    """Check the declared variables of a sensor.

    Raises
    ------
    ValueError
        If it is not a tuple of distinct names that the engine knows.
    """
    if not isinstance(variables, tuple) or not all(isinstance(name, str) for name in variables):
        raise ValueError(f"variables is {variables!r}; expected a tuple of names")
    for name in variables:
        if name not in MEASURED or variables.count(name) > 1:
            raise ValueError(f"variables names '{name}'; {choose_from(name, MEASURED)}, each once")


def check_element_variables(variables: Any) -> None:
    """Check the declared truth variables of an element provider.

    Raises
    ------
    ValueError
        If it is not a mapping of names to units and description.
    """
    good = isinstance(variables, Mapping) and all(
        isinstance(name, str) and re.fullmatch("[a-z][a-z0-9_]*", name) for name in variables
    )
    if not good or "share" in variables or "radiance" in variables or not _is_pairs(list(variables.values())):
        raise ValueError(
            f"variables is {variables!r}; expected a mapping of names (lower-case letters, digits, underscores; not "
            "'share' or 'radiance') to pairs of text: units and description"
        )


MAX_CLASSES = 12
"""Maximum number of classes of a surface."""


def check_surface_classes(classes: Any) -> None:
    """Check the declared classes of a surface provider.

    Raises
    ------
    ValueError
        If they are not one to ``MAX_CLASSES`` classes with distinct names and positive temperatures.
    """
    count = len(classes) if isinstance(classes, tuple) else 0
    if not 0 < count <= MAX_CLASSES:
        raise ValueError(f"classes is {classes!r}; expected a tuple of 1 to {MAX_CLASSES} SurfaceClass")
    names = [getattr(each, "name", None) for each in classes]
    for each, name in zip(classes, names, strict=True):
        if not isinstance(name, str) or not re.fullmatch("[a-z][a-z0-9_]*", name) or names.count(name) > 1:
            raise ValueError(
                f"classes has the name {name!r}; expected distinct names of lower-case letters, digits, underscores"
            )
        if name == "sea" and each.boundary is not None:
            raise ValueError("the class 'sea' has a boundary; expected None: it is the sea model of the scenario")
        given = each.temperature_K
        ends = given if isinstance(given, tuple) else (given,) if given is not None else ()
        if (
            not all(_is_number(end, 5000.0) and end > 0.0 for end in ends)
            or len(ends) > 2
            or list(ends) != sorted(ends)
        ):
            raise ValueError(
                f"temperature_K of class '{name}' is {given!r}; expected None, a number of kelvin, or (lowest, highest)"
            )


def _is_number(value: Any, high: float) -> bool:
    try:
        return not isinstance(value, str | bool) and 0.0 <= float(value) <= high and math.isfinite(value)
    except (TypeError, ValueError):
        return False


def _is_pairs(value: Any) -> bool:
    return (
        isinstance(value, Sequence)
        and not isinstance(value, str)
        and all(
            isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(part, str) for part in pair) for pair in value
        )
    )


def _is_names(value: Any) -> bool:
    return isinstance(value, Set) and all(isinstance(name, str) for name in value)


_OPTIONS: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "skipped": (_is_pairs, "a tuple of pairs of text: what is left out, and why"),
    "image_coverage": (lambda value: value is None or _is_number(value, 1.0), "None or a number from 0 to 1"),
    "honours": (
        lambda value: isinstance(value, tuple | list | Set) and all(each in LAYER_OPTIONS for each in value),
        f"a tuple of names among {', '.join(LAYER_OPTIONS)}",
    ),
    "frame_summary": (callable, "a method"),
    "thickness_in_frame_m": (callable, "a method"),
    "thickness_around_m": (callable, "a method"),
    "anisotropic": (lambda value: value in (True, False), "True or False"),
    "significant_wave_height_m": (lambda value: _is_number(value, math.inf), "a number of metres, 0 or more"),
    "mean_square_slope": (lambda value: _is_number(value, math.inf), "a number, 0 or more"),
    "reflection_weights": (callable, "a method"),
    "wave_slope_rms": (callable, "a method"),
    "wave_field": (callable, "a method"),
    "tilted": (callable, "a method"),
    "path_radiance": (callable, "a method"),
    "solar_path_radiance": (callable, "a method"),
    "absorber_amounts": (callable, "a method"),
    "transmittance_of_amounts": (callable, "a method"),
    "bound_profile": (callable, "a static method"),
    "sea_sun_terms": (_is_names, "a set of names of terms"),
    "worked_out": (lambda value: isinstance(value, Mapping), "a mapping of names to plain values"),
}
