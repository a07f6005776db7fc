"""Laws of providers as plain functions: the conformance kit and the probes of a run share them.

A law returns nothing if the provider keeps it, raises :class:`~hcss_twin.laws.law.LawBroken` with the numbers if not,
and ``unittest.SkipTest`` where it says nothing about a provider. No module here imports pytest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hcss_twin.core.arrays import Array
from hcss_twin.laws import atmosphere, clouds, conduct, elements, particles, radiance, sea, sensors, surfaces
from hcss_twin.laws.law import Law
from hcss_twin.providers import Kind, Microphysics

__all__ = ["laws_of", "questions_of"]

_OF_KIND: Mapping[Kind, Sequence[Law]] = {
    Kind.CLOUDS: clouds.LAWS,
    Kind.SEA: sea.LAWS,
    Kind.OPTICS: particles.LAWS,
    Kind.ATMOSPHERE: atmosphere.LAWS,
    Kind.RADIANCE: radiance.LAWS,
    Kind.ELEMENTS: elements.LAWS,
    Kind.SURFACES: surfaces.LAWS,
    Kind.VARIABLES: (),
    Kind.SENSORS: sensors.LAWS,
}

_SPECTRAL = (Kind.SEA, Kind.OPTICS, Kind.ATMOSPHERE, Kind.RADIANCE)
"""Kinds with results at wavenumbers."""

_NOT_IN_A_RUN = (
    conduct.results_belong_to_the_caller,
    conduct.nothing_is_printed,
    conduct.results_are_in_double_precision,
    atmosphere.declared_range_is_usable_to_its_ends,
    sea.declared_range_is_usable_to_its_ends,
    particles.declared_range_is_usable_to_its_ends,
)
"""A run does not change what it gets, and need not need the ends of a range."""


def laws_of(kind: Kind, *, in_a_run: bool = False) -> dict[str, Law]:
    """Return the laws of a kind of provider by their names, to hold a provider to them.

    A law is a function; its parameters are among ``provider``, ``make`` (maps inputs to a provider), ``inputs``,
    ``wavenumber_cm1``, ``cloud``, ``questions`` (:func:`questions_of`), and others with defaults.

    Parameters
    ----------
    in_a_run : bool
        Only those that a run asks of providers of other packages, before its first frame.
    """
    laws = [*_OF_KIND[kind], *conduct.LAWS, *([conduct.results_are_in_double_precision] if kind in _SPECTRAL else [])]
    return {law.__name__: law for law in laws if not (in_a_run and law in _NOT_IN_A_RUN)}


def questions_of(
    kind: Kind,
    provider: Any,
    inputs: Any,
    *,
    wavenumber_cm1: Array | None = None,
    cloud: Microphysics | None = None,
    two: tuple[Any, Any] | None = None,
    time_s: float = 0.0,
) -> tuple[conduct.Question, ...]:
    """Return calls of a provider for the laws that all kinds share: a method and two sets of arguments each.

    Parameters
    ----------
    wavenumber_cm1 : ndarray (V,), optional
        For sea, optics, air and radiance.
    cloud : Microphysics, optional
        Particles, for optics.
    two : pair, optional
        Frames (B, y, x) for sensors, mappings of names to arrays for variables.
    time_s : float
        Of the first call, for elements.
    """
    match kind:
        case Kind.CLOUDS:
            return conduct.of_clouds(provider, inputs)
        case Kind.ELEMENTS:
            return conduct.of_elements(inputs, time_s)
        case Kind.SURFACES:
            return conduct.of_surfaces(inputs)
        case Kind.SENSORS | Kind.VARIABLES:
            assert two is not None, f"{kind} needs two frames or mappings"
            return conduct.of_sensors(inputs, *two) if kind is Kind.SENSORS else conduct.of_variables(*two)
    assert wavenumber_cm1 is not None, f"{kind} needs wavenumbers"
    if kind is Kind.OPTICS:
        assert cloud is not None, "optics needs particles"
        return conduct.of_optics(cloud, wavenumber_cm1)
    if kind is Kind.RADIANCE:
        return conduct.of_radiance(provider, inputs.setting, wavenumber_cm1)
    return conduct.of_sea(provider, wavenumber_cm1) if kind is Kind.SEA else conduct.of_air(provider, wavenumber_cm1)
