"""Variables of the cube, and rounding of their values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.cube.writer import MANTISSA_BITS, bits_for, largest_error
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.assembly import Assembly
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
        If there is no such variable.
    """
    layers, shadows = len(assembly.layers), scenario.slant.shadows
    wanted = tuple(scenario.output.variables) if wanted is None else wanted
    try:
        altitude = scenario.platform.altitude is not None
        moves = assembly.motion.platform_speed_m_s != 0.0
        elements = tuple(each.variables for each in assembly.elements)
        surfaces = () if assembly.surfaces is None else assembly.surfaces.names
        terms = assembly.model.terms
        return tuple(expand(wanted, terms, layers, shadows, waves, altitude, moves, elements, surfaces))
    except ValueError as error:
        raise ScenarioError([Problem("output.variables", str(error))]) from error


def wants_radiance(variables: tuple[VariableSpec, ...]) -> bool:
    """Whether any of the variables requires radiance."""
    return any(spec.needs_radiance for spec in variables)


LARGEST_SHARE = 0.3
"""Largest share of the accuracy for rounding; the tables need the rest."""

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
