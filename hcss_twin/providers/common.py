"""Names, limits and checks common to all kinds of providers."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence, Set
from typing import Any

from hcss_twin.core.errors import choose_from

DEPENDENCIES = ("view_zenith", "sun_zenith", "relative_azimuth", "thickness", "time")
"""Names in ``depends_on`` of declarations."""

RANGES = ("wavenumber_cm1", "view_zenith", "target_altitude_m")
"""Names in ``valid`` of declarations."""

LEGS = ("any", "to_space")
"""Allowed values of ``AtmosphereDeclaration.legs``."""

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


def check_options(provider: Any) -> None:
    """Check the values of a provider's optional attributes.

    Raises
    ------
    ValueError
        If a value does not match ``...Options`` of its kind in ``hcss_twin.providers``.
    """
    for name, (is_good, expected) in OPTIONAL_MEMBERS.items():
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


OF_ENGINE = frozenset(
    {"share", "radiance", "point_radiance", "transmittance", "row", "column", "row_rate", "column_rate"}
)
"""Names of truth of elements that the engine gives."""


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
    if not good or not OF_ENGINE.isdisjoint(variables) or not _is_pairs(list(variables.values())):
        raise ValueError(
            f"variables is {variables!r}; expected a mapping of names (lower-case letters, digits, underscores; not "
            f"{', '.join(sorted(OF_ENGINE))}) to pairs of text: units and description"
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
    names = [getattr(class_, "name", None) for class_ in classes]
    for class_, name in zip(classes, names, strict=True):
        if not isinstance(name, str) or not re.fullmatch("[a-z][a-z0-9_]*", name) or names.count(name) > 1:
            raise ValueError(
                f"classes has the name {name!r}; expected distinct names of lower-case letters, digits, underscores"
            )
        if name == "sea" and class_.boundary is not None:
            raise ValueError("the class 'sea' has a boundary; expected None: it is the sea model of the scenario")
        given = class_.temperature_K
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


def _is_range(value: Any) -> bool:
    good = isinstance(value, tuple) and len(value) == 2 and all(isinstance(bound, int | float) for bound in value)
    return good and all(map(math.isfinite, value)) and value[0] <= value[1]


def _is_pairs(value: Any) -> bool:
    return (
        isinstance(value, Sequence)
        and not isinstance(value, str)
        and all(
            isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(part, str) for part in pair) for pair in value
        )
    )


OPTIONAL_MEMBERS: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "skipped": (_is_pairs, "a tuple of pairs of text: what is left out, and why"),
    "image_coverage": (lambda value: value is None or _is_number(value, 1.0), "None or a number from 0 to 1"),
    "honours": (
        lambda value: isinstance(value, tuple | list | Set) and all(option in LAYER_OPTIONS for option in value),
        f"a tuple of names among {', '.join(LAYER_OPTIONS)}",
    ),
    "frame_summary": (callable, "a method"),
    "thickness_in_frame_m": (callable, "a method"),
    "thickness_around_m": (callable, "a method"),
    "height_shares": (callable, "a method"),
    "cloud_top_range_m": (
        lambda value: value is None or _is_range(value),
        "None or a pair of altitudes, the lowest first",
    ),
    "cloud_top_m": (callable, "a method"),
    "clear_sky_varies": (lambda value: value in (True, False), "True or False"),
    "cloud_depth_m": (callable, "a method"),
    "goes_on_with": (lambda value: isinstance(value, str), "text: key and value of the scenario"),
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
    "scattering_of_amounts": (callable, "a method"),
    "vapour_kinks": (callable, "a method"),
    "bound_profile": (callable, "a static method"),
    "thread_safe": (lambda value: isinstance(value, bool), "True or False"),
    "model_errors": (callable, "a method"),
    "cache_token": (lambda value: value is None or isinstance(value, str), "None or text"),
    "expected_failures": (lambda value: isinstance(value, Mapping), "a mapping of laws to reasons"),
    "sea_sun_terms": (
        lambda value: isinstance(value, Set) and all(isinstance(name, str) for name in value),
        "a set of names of terms",
    ),
    "instants": (lambda value: _is_range(value), "a pair of numbers of seconds, the earliest first"),
    "measure_with": (callable, "a method"),
    "points_after": (callable, "a method"),
    "worked_out": (lambda value: isinstance(value, Mapping), "a mapping of names to plain values"),
    "single_precision": (lambda value: isinstance(value, bool), "True or False"),
}
"""Members that a provider may have: whether a value is allowed, and what is."""
