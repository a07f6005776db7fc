"""Variables of a cube that providers define: terms of the radiance, elements, classes, derived variables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from hcss_twin.providers import OutputVariable

from hcss_twin.cube.variables import BAND_FRAME, ELEMENT, FRAME, TERM_PREFIX, VariableSpec, flags

_TERM = re.compile(r"[a-z][a-z0-9_]*\Z")


def term_variable(name: str, description: str) -> VariableSpec:
    """Return the variable ``radiance_<name>`` of one term of the radiance model.

    Raises
    ------
    ValueError
        If ``name`` contains anything but lower-case letters, digits and underscores.
    """
    if not _TERM.match(name):
        raise ValueError(f"radiance term '{name}': a term is named with lower-case letters, digits and underscores")
    return VariableSpec(
        name=TERM_PREFIX + name,
        dims=BAND_FRAME,
        units="W m-2 sr-1",
        long_name=f"part of the radiance: {name.replace('_', ' ')}",
        kind="radiance",
        description=description,
        lowest=0.0,
    )


def surface_class(spec: VariableSpec, names: Sequence[str]) -> VariableSpec:
    """Return the variable ``surface_class`` with the names of the scene's classes as its flags."""
    return replace(spec, attributes=flags(" ".join(names))) if names else spec


def element_variable(name: str, units: str, description: str) -> VariableSpec:
    """Return the truth variable ``element_<name>`` of an element provider."""
    return VariableSpec(
        name=f"{ELEMENT}_{name}",
        units=units,
        long_name=f"{name.replace('_', ' ')} of the element",
        kind="truth",
        description=description,
        may_be_missing=True,
        needs="elements",
    )


INPUTS = "hcss_inputs"
"""Attribute of a variable of a provider: the variables and the geometry that it is derived from."""


def own_variable(name: str, about: OutputVariable, needs: Iterable[str] = ()) -> VariableSpec:
    """Return a variable of a variable provider, derived from ``needs``."""
    meanings = about.flag_meanings
    attributes: dict[str, str | float | NDArray[Any]] = {INPUTS: " ".join(needs)}
    if meanings:
        attributes |= flags(" ".join(meanings), about.dtype)
    return VariableSpec(
        name=name,
        dims=BAND_FRAME if about.per_band else FRAME,
        dtype=about.dtype,
        units=about.units,
        long_name=about.long_name,
        kind="own",
        description=about.description,
        standard_name=about.standard_name,
        attributes=attributes,
        lowest=about.lowest,
        highest=about.highest,
        may_be_missing=about.may_be_missing,
    )
