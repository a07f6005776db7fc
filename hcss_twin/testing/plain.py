"""Providers in closed form: partners for trying one provider without depending on the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcss_twin.physics.paths import Path
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import Array, Declares, Microphysics, SingleScattering


class PlainSea:
    """A grey Lambertian sea: BRDF (1 - emissivity) / pi."""

    def __init__(self, emissivity: float = 0.98) -> None:
        self._emissivity = emissivity
        self.declares = Declares()

    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array:
        """Return the same emissivity (M, V) everywhere."""
        return np.full((mu.size, wavenumber_cm1.size), self._emissivity)

    def brdf(self, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, relative_azimuth: Array) -> Array:
        """Return the same BRDF (M, V) in sr-1 everywhere."""
        return np.full((mu_out.size, wavenumber_cm1.size), (1.0 - self._emissivity) / np.pi)


class PlainOptics:
    """Grey particles of a given extinction cross-section, albedo and asymmetry (Henyey-Greenstein)."""

    def __init__(self, cross_section_m2: float = 1e-10, albedo: float = 0.6, asymmetry: float = 0.8) -> None:
        self._cross_section_m2 = cross_section_m2
        self._albedo = albedo
        self._asymmetry = asymmetry
        self.declares = Declares()

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return extinction in proportion to the number of particles, the same at all wavenumbers."""
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(
            extinction_m1=cloud.number_density_m3 * self._cross_section_m2 * ones,
            albedo=self._albedo * ones,
            moments=np.stack((ones, self._asymmetry * ones)),
        )


class PlainGas:
    """A grey gas, well mixed: T = exp(-depth m) with the pressure-weighted air mass m of the whole path."""

    def __init__(self, profile: Profile, vertical_depth: float = 0.3) -> None:
        self._profile = profile
        self._weights = -np.diff(profile.pressure_Pa) / (profile.pressure_Pa[0] - profile.pressure_Pa[-1])
        self._vertical_depth = vertical_depth
        self.declares = Declares(depends_on=frozenset({"view_zenith", "sun_zenith"}))

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V), the same at all wavenumbers."""
        mass = np.array([self._profile.airmass(path) @ self._weights for path in paths])
        return np.repeat(np.exp(-self._vertical_depth * mass)[:, None], wavenumber_cm1.size, axis=1)
