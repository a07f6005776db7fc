"""Variables of the cube, and rounding of their values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.cube.requested_variables import INPUTS, expand
from hcss_twin.cube.variables import TOTAL, VariableSpec
from hcss_twin.cube.writer import MANTISSA_BITS, bits_for, largest_error
from hcss_twin.plan.accuracy import LARGEST_SHARE, RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import numbered
from hcss_twin.providers import VariableProvider
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.providers.variables import GEOMETRY as GEOMETRY_INPUTS
from hcss_twin.scenario.scenario import Scenario


def cube_variables(
    scenario: Scenario, assembly: Assembly, waves: bool, wanted: tuple[str, ...] | None = None
) -> tuple[VariableSpec, ...]:
    """Return the requested variables of a scenario, or those given instead.

    Parameters
    ----------
    waves : bool
        Whether waves are resolved.

    Raises
    ------
    ScenarioError
        If there is no such variable, or a section ``output.derived`` gives none of them.
    """
    wanted = tuple(scenario.output.variables) if wanted is None else wanted
    try:
        variables = _expanded(wanted, scenario, assembly, waves)
    except ValueError as error:
        raise ScenarioError([Problem("output.variables", str(error))]) from error
    names = {spec.name for spec in variables}
    for index, provider in enumerate(assembly.derived):
        if not names & set(provider.variables):
            message = (
                f"none of its variables is requested; allowed: output.variables with {' or '.join(provider.variables)}"
            )
            raise ScenarioError([Problem(f"output.derived[{index}]", message)])
    return tuple(
        replace(spec, attributes={**spec.attributes, INPUTS: " ".join(_provider_of(spec.name, assembly).needs)})
        if spec.kind == "own"
        else spec
        for spec in variables
    )


def computed_variables(
    scenario: Scenario, assembly: Assembly, waves: bool, requested: tuple[VariableSpec, ...]
) -> tuple[VariableSpec, ...]:
    """Return the requested variables, and those that a sensor and variable providers need besides.

    Raises
    ------
    ScenarioError
        If the scene lacks one that a provider needs.
    """
    measured = [] if scenario.sensor is None else _expanded([TOTAL], scenario, assembly, waves)
    known = {spec.name: spec for spec in (*measured, *requested)}
    for index, provider in enumerate(assembly.derived):
        needs = [name for name in provider.needs if name not in GEOMETRY_INPUTS]
        try:
            known = (
                {spec.name: spec for spec in _expanded(needs, scenario, assembly, waves)} | known if needs else known
            )
            wrong = [name for name in needs if name not in known or known[name].kind in ("own", "geometry")]
            if wrong:
                raise ValueError(f"'{wrong[0]}' is no variable of the engine; geometry: {', '.join(GEOMETRY_INPUTS)}")
        except ValueError as error:
            label = assembly.entries[numbered(Kind.VARIABLES, index, len(assembly.derived))].label
            message = f"{label} needs what the scene does not have: {error}"
            raise ScenarioError([Problem(f"output.derived[{index}].provider", message)]) from error
    return tuple(known.values())


def _provider_of(name: str, assembly: Assembly) -> VariableProvider:
    return next(provider for provider in assembly.derived if name in provider.variables)


def _expanded(names: Iterable[str], scenario: Scenario, assembly: Assembly, waves: bool) -> list[VariableSpec]:
    """Return variables by name; raises ValueError."""
    layers, shadows = len(assembly.layers), assembly.slant.shadows
    altitude = scenario.platform.altitude is not None
    moves = assembly.motion.platform_speed_m_s != 0.0
    elements = [element.variables for element in assembly.elements]
    derived = [provider.variables for provider in assembly.derived]
    surfaces = [name for surfaces in assembly.surfaces for name in surfaces.names]
    terms, texture = assembly.model.terms, assembly.has_texture
    light = scenario.radiance.is_between_columns
    return expand(names, terms, layers, shadows, waves, altitude, moves, elements, derived, surfaces, texture, light)


def wants_radiance(variables: tuple[VariableSpec, ...]) -> bool:
    """Whether any of the variables requires radiance."""
    return any(spec.needs_radiance for spec in variables)


TEMPERATURE_BITS = 4
"""Extra bits for temperatures, whose differences matter: a sixteenth of the relative error."""


def quantized(
    variables: tuple[VariableSpec, ...], scenario: Scenario, accuracy: RequestedAccuracy
) -> tuple[VariableSpec, ...]:
    """Set the significant bits of single-precision variables according to ``output.quantization``.

    Raises
    ------
    ScenarioError
        If rounding would exceed its share of the scenario's accuracy.
    """
    requested = scenario.output.quantization
    if requested == 0.0:
        return variables
    most = LARGEST_SHARE * accuracy.relative
    if requested > most:
        message = (
            f"{requested:g} is more than {100 * LARGEST_SHARE:g} % of the accuracy ({accuracy}); the radiance before "
            f"rounding needs the rest; allowed: 0 to {most:.3g}; closest valid choice is {most:.3g}"
        )
        raise ScenarioError([Problem("output.quantization", message)])
    bits = bits_for(requested)
    return tuple(_rounded(spec, bits) for spec in variables)


def rounded_within(spec: VariableSpec, relative: float) -> VariableSpec:
    """Return a variable with the significant bits whose rounding errs by no more than a relative error."""
    return _rounded(spec, bits_for(relative))


def quantization_lines(variables: tuple[VariableSpec, ...], compressed: bool) -> tuple[str, ...]:
    """Return notes on the rounding of values; empty if there is no rounding."""
    errors = {spec.significant_bits: spec.units == "K" for spec in variables if spec.significant_bits is not None}
    return tuple(
        f"{'temperatures' if temperature else 'numbers'} are rounded to {bits} bits of the mantissa: relative error "
        f"up to {largest_error(bits):.2g}" + ("" if compressed else "; saves nothing without output.compression")
        for bits, temperature in sorted(errors.items())
    )


def _rounded(spec: VariableSpec, bits: int) -> VariableSpec:
    if np.dtype(spec.dtype) != np.float32 or spec.kind == "geometry":
        return spec
    significant = bits + TEMPERATURE_BITS if spec.units == "K" else bits
    return spec if significant >= MANTISSA_BITS else replace(spec, significant_bits=significant)
