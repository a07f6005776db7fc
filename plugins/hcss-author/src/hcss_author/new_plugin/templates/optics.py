"""Particles much larger than the wavelength: the extinction cross-section is twice the geometric one."""

import numpy as np
from hcss_twin.providers import Array, OpticsDeclaration, Microphysics, OpticsInputs, SingleScattering
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    albedo: float = Field(default=0.5, ge=0, le=1, description="Single-scattering albedo at all wavelengths.")
    asymmetry: float = Field(default=0.85, gt=-1, lt=1, description="Asymmetry parameter (Henyey-Greenstein).")


class Provider:
    """Extinction 2 pi r^2 of every particle, grey."""

    declares = OpticsDeclaration(notes=("particles much larger than the wavelength, grey",))

    def __init__(self, inputs: OpticsInputs, parameters: Parameters) -> None:
        self._parameters = parameters

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return extinction (V,) in m-1, albedo (V,) and Legendre moments (2, V)."""
        radius_um = np.geomspace(*cloud.radius_range_um, 1000)
        # n(r) = a r^alpha exp(-b r^nu); one more r, because the radii are evenly spaced in their logarithm
        weight = radius_um ** (cloud.alpha + 1.0) * np.exp(-cloud.b * radius_um**cloud.nu)
        area_m2 = np.pi * 1e-12 * (weight @ radius_um**2) / weight.sum()
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(
            extinction_m1=2.0 * area_m2 * cloud.number_density_m3 * ones,
            albedo=self._parameters.albedo * ones,
            moments=np.stack((ones, self._parameters.asymmetry * ones)),
        )
