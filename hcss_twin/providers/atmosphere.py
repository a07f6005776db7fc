"""Transmittance providers: gases and aerosol."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.paths import Path
from hcss_twin.physics.profile import Profile
from hcss_twin.providers.common import RANGES
from hcss_twin.providers.declarations import Declaration, among


@dataclass(frozen=True)
class AtmosphereInputs:
    """Inputs of a transmittance provider.

    Attributes
    ----------
    profile : Profile
        The air at its levels; ``Profile.airmass(path)`` sums slant over vertical thickness per layer over legs.
    catalog : Catalog
        Reader of data files.
    wind_speed_m_s : float or None
        At 10 m above the sea; None where it is unknown.
    """

    profile: Profile
    catalog: Catalog
    wind_speed_m_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class AtmosphereDeclaration(Declaration):
    """What a transmittance provider declares, besides notes and its own errors.

    Attributes
    ----------
    valid : mapping of str to (low, high)
        Ranges of validity, ends included: ``wavenumber_cm1``, ``view_zenith`` (degrees) and
        ``target_altitude_m`` (of the lower ends of legs).
    native_grid_cm1 : ndarray (N,), optional
        Ascending spectral nodes; calls use only these and band edges.
    resolution_cm1 : float
        Spectral resolution of the results; 0: monochromatic.
    legs : {"any", "to_space"}
        Paths: any legs, or only legs from one target to space. The radiance model fits a law to the latter for other
        paths.
    """

    valid: Mapping[str, tuple[float, float]] = field(default_factory=dict, metadata=among(*RANGES))
    native_grid_cm1: Array | None = None
    resolution_cm1: float = 0.0
    legs: Literal["any", "to_space"] = "any"


@runtime_checkable
class TransmittanceProvider(Protocol):
    """Gas (and aerosol) transmittance of composite paths."""

    declares: AtmosphereDeclaration

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) in [0, 1] of each composite path; 1 for a path without legs."""
        ...


class TransmittanceOptions(Protocol):
    """Optional members of a transmittance provider.

    Attributes
    ----------
    thread_safe : bool
        Whether several threads may call ``transmittance`` at once: then each computes a part of the wavenumbers.
    """

    thread_safe: bool

    def path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) of single legs, seen from space, W m-2 sr-1 (cm-1)-1, 0 or more.

        Without it the engine computes path radiance from transmittances and temperatures. A radiance model may do so
        in any case, as ``physical`` does; plan and cube then say how much clear radiance would change.
        """
        ...

    def solar_path_radiance(
        self, wavenumber_cm1: Array, paths: Sequence[Path], sun_zenith_deg: float, relative_azimuth_deg: float
    ) -> Array:
        """Return sunlight scattered once into single legs, seen from space, over the sun's irradiance: (P, V) in sr-1.

        0 or more, and not less for a leg that begins lower. ``relative_azimuth_deg`` in [0, 180] is 0 with the sensor
        on the sun's side; the sun is up to 88 degrees from the zenith. The engine multiplies by the irradiance (per
        wavenumber, on a surface facing the sun). Without this method the air scatters no sunlight.
        """
        ...

    def absorber_amounts(self, paths: Sequence[Path]) -> Array:
        """Return absorber amounts (P, K) that determine the transmittance of a path and add over its legs.

        0 for a path without legs. With ``transmittance_of_amounts`` the engine combines paths faster.
        """
        ...

    def transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        """Return the transmittance (P, V) in [0, 1] of paths with these amounts (P, K)."""
        ...

    def scattering_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        """Return the optical depth of scattering by particles (2, P, V), and the same times its mean cosine; 0 or more.

        It adds over legs. Without this method all extinction emits in the sky too.
        """
        ...

    def vapour_kinks(self, low: float, high: float) -> Sequence[float]:
        """Return at which factors on all water vapour, in (low, high), optical depths have kinks, ascending.

        Where water vapour has texture, tables are joined there. Without this method there are no kinks.
        """
        ...

    @staticmethod
    def bound_profile(parameters: Any, catalog: Catalog) -> Profile:
        """Return the only profile for which the provider's data are valid.

        Called before construction. It is the default profile of scenarios, which may not scale its water vapour.
        Without this method the provider accepts any profile.
        """
        ...
