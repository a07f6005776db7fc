"""Radiance models: spectral radiance of one column of sea, cloud and air."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.core.result_cache import ArrayMemory
from hcss_twin.providers.column_states import ColumnSetting, ColumnStates
from hcss_twin.providers.declarations import Declaration, among
from hcss_twin.providers.optics import Optics


@dataclass(frozen=True)
class RadianceInputs:
    """Inputs of a radiance model: what all columns of a scene share. What differs between them are states.

    Attributes
    ----------
    setting : ColumnSetting
        The scene's own, at night, with checked providers. States may have others, with as many layers.
    optics : Optics
        Of the particles of every layer.
    solar_irradiance : SolarIrradiance
        Maps wavenumbers (V,) to W m-2 (cm-1)-1 at 1 au.
    wind_from_deg : float
        Bearing from which the wind blows, for anisotropic seas.
    numerical_level : int
        Which of the model's levels of numerical accuracy to use, 0 is the coarsest.
    sunlight_steps : int
        How many levels finer, as far as there are any, to solve sunlight that clouds scatter toward the sensor: its
        error depends on the scattering angle. A model may ignore it.
    memory : ArrayMemory or None
        Where a model may keep arrays for the other scenes of the process, by a hash of all that they depend on.
    """

    setting: ColumnSetting
    optics: Optics
    solar_irradiance: SolarIrradiance
    wind_from_deg: float = 0.0
    numerical_level: int = 0
    sunlight_steps: int = 0
    memory: ArrayMemory | None = None


class SolarIrradiance(Protocol):
    """Extraterrestrial spectral irradiance at 1 au."""

    def __call__(self, wavenumber_cm1: Array) -> Array:
        """Return W m-2 (cm-1)-1 at ``wavenumber_cm1`` (V,)."""
        ...


@dataclass(frozen=True, kw_only=True)
class RadianceDeclaration(Declaration):
    """What a radiance model declares, besides notes and its own errors.

    Attributes
    ----------
    depends_on : frozenset of str or None
        Variables that matter, among ``view_zenith``, ``sun_zenith``, ``relative_azimuth``, ``thickness``; the
        conformance kit checks it. None: not said.
    numerical_levels : int
        Number of levels of numerical accuracy (streams, nodes, ...), each finer and more expensive than the one before.
        The engine chooses the coarsest whose result is near enough to that of the next one; the finest is a reference
        only.
    """

    depends_on: frozenset[str] | None = field(
        default=None, metadata=among("view_zenith", "sun_zenith", "relative_azimuth", "thickness")
    )
    numerical_levels: int = 1


@runtime_checkable
class RadianceModel(Protocol):
    """Assembly of the spectral radiance of one column of sea, cloud and air.

    The constructor raises ``ProviderError`` for more layers than the model can have.

    Attributes
    ----------
    terms : mapping of str to str
        Names and descriptions of the terms, which sum to the radiance at the sensor.
    solar_terms : frozenset of str
        Terms that are exactly 0 without a sun.
    """

    declares: RadianceDeclaration
    terms: Mapping[str, str]
    solar_terms: frozenset[str]

    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Return each term (N, V) of N columns, W m-2 sr-1 (cm-1)-1.

        ``states.groups()`` yields the columns that share view, sun, sea, air and layers; a model may share more of what
        it solves between them. A column of which all thicknesses are 0 is clear sky. Every term is continuous in every
        thickness, also where a cloud boundary crosses a level of the profile, because the engine interpolates tables of
        them; a jump is an error. A column does not depend on the others, but for rounding.
        """
        ...


class RadianceModelOptions(Protocol):
    """Optional members of a radiance model.

    Attributes
    ----------
    sea_sun_terms : frozenset of str
        Terms of direct sunlight reflected by the sea in the clear column; needed for scenes with shadows.
    """

    sea_sun_terms: frozenset[str]
