"""Radiance models: what one column of sea, cloud and air sends to the sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.atmosphere import TransmittanceProvider
from hcss_twin.providers.clouds import CloudLayer
from hcss_twin.providers.common import Declares
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
    """What a radiance model is built from: the scene's providers and states.

    The providers come with their optional members, and what they return has been checked.

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
        From the lowest to the highest, none overlapping; there may be none.
    sea_temperature_K : float
        Of the water's skin.
    view : View
        Direction toward the sensor.
    solar_irradiance : SolarIrradiance
        Maps wavenumbers (V,) to W m-2 (cm-1)-1 at 1 au.
    wind_from_deg : float
        Bearing from which the wind blows, for anisotropic seas.
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


class SolarIrradiance(Protocol):
    """Extraterrestrial spectral irradiance at 1 au."""

    def __call__(self, wavenumber_cm1: Array) -> Array:
        """Return W m-2 (cm-1)-1 at ``wavenumber_cm1`` (V,)."""
        ...


@runtime_checkable
class RadianceModel(Protocol):
    """Assembly of the spectral radiance of one column of sea, cloud and air.

    A model that cannot take as many layers as ``inputs.layers`` has raises ``ProviderError`` when it is made.

    Attributes
    ----------
    terms : mapping of str to str
        Name of each part and its description; the parts sum to the radiance at the sensor.
    solar_terms : frozenset of str
        Those that are exactly 0 without a sun.
    """

    declares: Declares
    terms: Mapping[str, str]
    solar_terms: frozenset[str]

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (V,) of a cloud-free column, W m-2 sr-1 (cm-1)-1; ``sun`` is None below the horizon."""
        ...

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (N, V) of cloudy columns.

        ``thickness_m`` (N, L) has one column per layer, in the order of ``inputs.layers``; 0 means that the
        layer has no cloud there, and no row is all 0.

        Every term is continuous in every thickness, also where the top or base of a cloud crosses a level of the
        profile: the engine tabulates them, and stops with an error where they jump.
        """
        ...


class RadianceModelOptions(Protocol):
    """What a radiance model may have beside ``RadianceModel``.

    Attributes
    ----------
    sea_sun_terms : frozenset of str
        Terms that in the clear column are direct sunlight reflected by the sea. Without it a scene cannot have shadows.
    """

    sea_sun_terms: frozenset[str]
