"""Optics: scattering and absorption by cloud particles."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.clouds import Microphysics
from hcss_twin.providers.declarations import Declaration, among


@dataclass(frozen=True)
class SingleScattering:
    """Bulk single-scattering properties of a cloud volume.

    Attributes
    ----------
    extinction_m1 : ndarray (V,)
        Volume extinction coefficient in m-1, greater than 0.
    albedo : ndarray (V,)
        Single-scattering albedo in [0, 1].
    moments : ndarray (K, V)
        Legendre moments of the phase function: means of P_k over the scattering cosine, without the factor 2k + 1.
        ``moments[0]`` = 1 within 1e-9, the others are above -1 and below 1; ``moments[1]`` is the asymmetry parameter.
        K is 2 or more; K = 2 means Henyey-Greenstein.
    """

    extinction_m1: Array
    albedo: Array
    moments: Array


@dataclass(frozen=True)
class OpticsInputs:
    """Inputs of an optics provider; ``catalog`` reads data files."""

    catalog: Catalog


@dataclass(frozen=True, kw_only=True)
class OpticsDeclaration(Declaration):
    """What an optics provider declares, besides notes and its own errors.

    Attributes
    ----------
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1``.
    materials : set of str
        What it has particles of; layers of other materials are refused.
    notes_by_material : mapping of str to tuple of str
        Notes for layers of that material.
    """

    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict, metadata=among("wavenumber_cm1"))
    materials: Set[str] = frozenset({"water", "ice"})
    notes_by_material: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@runtime_checkable
class Optics(Protocol):
    """Bulk optical properties of cloud particles."""

    declares: OpticsDeclaration

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at ``wavenumber_cm1`` (V,); extinction in proportion to the number density."""
        ...
