"""Radiance models: spectral radiance of one column of sea, cloud and air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.core.result_cache import ArrayMemory, OwnMemory
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.atmosphere import TransmittanceProvider
from hcss_twin.providers.clouds import CloudLayer
from hcss_twin.providers.declarations import Declaration, among
from hcss_twin.providers.optics import Optics
from hcss_twin.providers.sea import SeaModel


@dataclass(frozen=True)
class View:
    """Direction from the surface point to the sensor."""

    zenith_deg: float
    azimuth_deg: float


@dataclass(frozen=True)
class Sun:
    """The sun seen from the surface point.

    Attributes
    ----------
    zenith_deg, azimuth_deg : float
        Apparent (refracted) zenith and bearing.
    distance_au : float
        Earth-Sun distance.
    """

    zenith_deg: float
    azimuth_deg: float
    distance_au: float

    @property
    def is_up(self) -> bool:
        """Whether the sun is above the horizon of the surface point."""
        return self.zenith_deg < 90.0


@dataclass(frozen=True)
class RadianceInputs:
    """Inputs of a radiance model: the scene's providers, whose results are checked, and states.

    Attributes
    ----------
    profile : Profile
        The air.
    transmittance : TransmittanceProvider
        Of gas and aerosol.
    sea : SeaModel
        Emissivity and reflection of the sea.
    optics : Optics
        Of the particles of every layer.
    layers : tuple of CloudLayer (L,)
        From the lowest to the highest, without overlap; may be empty.
    sea_temperature_K : float
        Of the water's skin.
    view : View
        Direction toward the sensor.
    solar_irradiance : SolarIrradiance
        Maps wavenumbers (V,) to W m-2 (cm-1)-1 at 1 au.
    wind_from_deg : float
        Bearing from which the wind blows, for anisotropic seas.
    numerical_level : int
        Which of the model's levels of numerical accuracy to use, 0 is the coarsest.
    memory : ArrayMemory or None
        Where a model may keep arrays for the other scenes of the process, by a hash of all that they depend on.
    air_memory : OwnMemory or None
        Where a model may keep arrays for other scenes in the same air, by a hash of all else that they depend on.
    sunlight_steps : int
        How many levels finer, as far as there are any, to solve sunlight that clouds scatter toward the sensor: its
        error depends on the scattering angle. A model may ignore it.
    """

    profile: Profile
    transmittance: TransmittanceProvider
    sea: SeaModel
    optics: Optics
    layers: tuple[CloudLayer, ...]
    sea_temperature_K: float
    view: View
    solar_irradiance: SolarIrradiance
    wind_from_deg: float = 0.0
    numerical_level: int = 0
    memory: ArrayMemory | None = None
    air_memory: OwnMemory | None = None
    sunlight_steps: int = 0


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

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (V,) of a cloud-free column, W m-2 sr-1 (cm-1)-1; ``sun`` is None below the horizon."""
        ...

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (N, V) of cloudy columns.

        ``thickness_m`` (N, L) is in the order of ``inputs.layers``; 0: no cloud in that layer; no row is all 0. Every
        term is continuous in every thickness, also where a cloud boundary crosses a level of the profile, because the
        engine interpolates tables of them; a jump is an error.
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

    def expect(self, suns: Sequence[Sun | None]) -> None:
        """Prepare for columns at the same wavenumbers under each of these suns; results stay the same but for rounding.

        A model may then solve for all of them what it solves for the first.
        """
        ...

    def expect_views(self, views: Sequence[View]) -> None:
        """Prepare for columns of models toward each of these views, its own among them, alike in all other inputs.

        A model may then leave in ``inputs.memory`` what it solves for all of them; results stay the same but for
        rounding.
        """
        ...
