"""The variables that a scenario requests, by name or by group, and those that its providers bring."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from hcss_twin.core.errors import choose_from
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING
from hcss_twin.cube.variables import (
    BAND_FRAME,
    BETWEEN_COLUMNS,
    DIRECTION,
    ELEMENT,
    FRAME,
    GEOMETRY,
    LOCATION,
    MOVING_LOCATION,
    SURFACE_CLASS,
    TERM_PREFIX,
    VARIABLES,
    VariableSpec,
    flags,
)

if TYPE_CHECKING:
    from hcss_twin.providers import OutputVariable


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


_LACKING = {
    "layers": "the scene has no cloud layer; allowed: with a layer of cloud",
    "shadows": 'clouds cast no shadows; allowed: with slant.shadows = "on"',
    "waves": 'the scene has no resolved waves; allowed: with sea.waves = "on"',
    "elements": "the scene has no elements; allowed: with a section [[elements]]",
    "surfaces": "the scene is sea everywhere; allowed: with a section [surfaces]",
    "texture": "clear sky has no texture; allowed: with sea.temperature_texture or atmosphere.water_vapour_texture",
    "light": "columns are independent; allowed: with radiance.light",
    "altitude": "the altitude of the sensor is not known; allowed: with platform.altitude; cubes of cameras have the "
    "coordinates of their pixels without being asked",
}
"""Reason why a scene lacks the variables that need a feature."""


def expand(
    requested: Iterable[str],
    terms: Mapping[str, str],
    layer_count: int = 1,
    shadows: bool = False,
    waves: bool = True,
    altitude: bool = True,
    moves: bool = False,
    elements: Sequence[Mapping[str, tuple[str, str]]] = (),
    derived: Sequence[Mapping[str, OutputVariable]] = (),
    surfaces: Sequence[str] = (),
    texture: bool = True,
    light: bool = False,
) -> list[VariableSpec]:
    """Return the requested variables, in the order of the table, then terms, those of providers and viewing geometry.

    Parameters
    ----------
    requested : iterable of str
        Names of variables, or groups: ``all`` (without viewing geometry), ``terms`` (of the radiance), ``truth`` (every
        variable of that kind), ``geometry`` (coordinates of the pixels). Groups contain the variables available in the
        scene; per-layer variables only with several layers, because with one they duplicate others.
    terms : mapping of str to str
        Description of each term of the selected radiance model, by name.
    layer_count : int
        Number of cloud layers of the scene.
    shadows, waves : bool
        Whether clouds cast shadows, and whether waves are resolved.
    altitude : bool
        Whether the sensor altitude is known; the directions toward the sensor need it.
    moves : bool
        Whether the image moves over the ground; latitude and longitude then have a time dimension.
    elements : sequence of mapping
        ``variables`` of each element provider of the scene.
    derived : sequence of mapping
        ``variables`` of each variable provider of the scene.
    surfaces : sequence of str
        Names of the surface classes of the scene.
    texture : bool
        Whether sea temperature or water vapour have texture.
    light : bool
        Whether there may be light between columns.

    Raises
    ------
    ValueError
        If nothing is requested, a name is unknown (with the allowed names and the closest one), the scene lacks a
        feature that a variable needs, or a variable provider uses a name of the engine or of another provider.
    """
    present = {
        "layers": layer_count > 0,
        "shadows": shadows,
        "waves": waves,
        "altitude": altitude,
        "elements": bool(elements),
        "surfaces": bool(surfaces),
        "texture": texture,
        "light": light,
    }
    lacking = {feature for feature, exists in present.items() if not exists}
    specs = (
        *(surface_class(spec, surfaces) if spec.name == SURFACE_CLASS else spec for spec in VARIABLES),
        *(element_variable(name, *about) for name, about in _united(elements).items()),
        *(term_variable(name, text) for name, text in terms.items()),
        *_own_variables(derived, terms),
        *(MOVING_LOCATION if moves else LOCATION),
        *DIRECTION,
    )
    known = {spec.name: spec for spec in specs}
    not_in_groups = lacking | ({"layers"} if layer_count < 2 else set())
    grouped = [spec for spec in specs if spec.needs not in not_in_groups]
    groups = {
        "all": {spec.name for spec in grouped if spec.kind != "geometry"},
        "terms": {TERM_PREFIX + name for name in terms} | ({BETWEEN_COLUMNS} if light and terms else set()),
        "truth": {spec.name for spec in grouped if spec.kind == "truth"},
        "geometry": {spec.name for spec in grouped if spec.kind == "geometry"},
    }
    wanted: set[str] = set()
    for name in requested:
        if name not in groups and name not in known:
            raise ValueError(f"unknown output variable '{name}'; {choose_from(name, [*groups, *known])}")
        needs = known[name].needs if name in known else None
        if needs in lacking:
            raise ValueError(f"'{name}': {_LACKING[needs]}")
        wanted |= groups.get(name, {name})
    if not wanted:
        raise ValueError(f"no output variable is requested; {choose_from('', [*groups, *known])}")
    return [spec for name, spec in known.items() if name in wanted]


def _united(elements: Sequence[Mapping[str, tuple[str, str]]]) -> dict[str, tuple[str, str]]:
    """Join the variables of several providers; equal names need equal units, and the first description is used."""
    united: dict[str, tuple[str, str]] = {}
    for name, about in ((name, about) for variables in elements for name, about in variables.items()):
        if united.setdefault(name, about)[0] != about[0]:
            raise ValueError(f"'element_{name}': two element providers give it in {united[name][0]} and {about[0]}")
    return united


GROUPS = ("all", "terms", "truth", "geometry")
"""Names that request several variables."""


def _own_variables(derived: Sequence[Mapping[str, OutputVariable]], terms: Iterable[str]) -> list[VariableSpec]:
    """Return the variables of variable providers after checking that nothing else has their names."""
    specs: list[VariableSpec] = []
    of_engine = {spec.name for spec in (*VARIABLES, *COORDINATES, *GEOMETRY)} | {GRID_MAPPING, *GROUPS, "band", "layer"}
    of_engine |= {TERM_PREFIX + name for name in terms}
    for name, about in ((name, about) for variables in derived for name, about in variables.items()):
        if name in of_engine or name.startswith((TERM_PREFIX, f"{ELEMENT}_")):
            raise ValueError(
                f"'{name}' of a variable provider is a name of the engine; allowed: names that no variable, coordinate "
                f"or group has and that begin neither with {TERM_PREFIX} nor with {ELEMENT}_"
            )
        if name in [spec.name for spec in specs]:
            raise ValueError(f"'{name}': two variable providers give it; allowed: one section for each name")
        specs.append(own_variable(name, about))
    return specs
