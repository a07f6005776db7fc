"""Transmittance providers: what gases and aerosol let through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.paths import Path
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.common import Declares


@dataclass(frozen=True)
class AtmosphereInputs:
    """What a transmittance provider is built from.

    Attributes
    ----------
    profile : Profile
        The air at its levels; ``Profile.airmass(path)`` sums slant over vertical thickness of each layer over legs.
    catalog : Catalog
        Reader of data files.
    """

    profile: Profile
    catalog: Catalog


@runtime_checkable
class TransmittanceProvider(Protocol):
    """Gas (and aerosol) transmittance of composite paths."""

    declares: Declares

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) in [0, 1] of each composite path; 1 for a path without legs."""
        ...


class TransmittanceOptions(Protocol):
    """What a transmittance provider may have beside ``TransmittanceProvider``."""

    def path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return its own thermal emission (P, V) of single legs to space, W m-2 sr-1 (cm-1)-1, 0 or more.

        Seen from space. Without it the engine derives path radiance from transmittances and the profile's
        temperatures.
        """
        ...

    def solar_path_radiance(
        self, wavenumber_cm1: Array, paths: Sequence[Path], sun_zenith_deg: float, relative_azimuth_deg: float
    ) -> Array:
        """Return sunlight scattered once into single legs to space, over the sun's irradiance: (P, V) in sr-1.

        Seen from space; 0 or more, and not less for a leg that begins lower (what seems less by discretisation
        counts as no more). ``relative_azimuth_deg`` in [0, 180] is
        0 with the sensor on the sun's side. The engine asks for suns up to 88 degrees from the zenith and multiplies by
        the irradiance (per wavenumber, on a surface facing the sun). Without it no sunlight is scattered in the air.
        """
        ...

    def absorber_amounts(self, paths: Sequence[Path]) -> Array:
        """Return amounts (P, K) that say all of a path and add over its legs; zeros for a path without legs.

        With ``transmittance_of_amounts`` it lets the engine follow many paths without naming their legs again.
        """
        ...

    def transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        """Return what ``transmittance`` does for paths with these amounts (P, K): (P, V) in [0, 1]."""
        ...

    @staticmethod
    def bound_profile(parameters: Any, catalog: Catalog) -> Profile:
        """Return the one profile to which the provider's data belong.

        Asked of the class before the provider is made, with its parameters and the scenario's catalog: a scenario that
        names no profile gets this one, and one that scales its water vapour is refused. Without it the provider accepts
        any profile.
        """
        ...
