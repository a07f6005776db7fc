"""Soft particles: anomalous diffraction (van de Hulst 1957, section 11.2) with one refractive index."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.integrate import trapezoid

from hcss_twin.providers import OpticsDeclaration, SingleScattering


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    n: float = Field(1.25, gt=1, le=1.5, description="Real part of the refractive index.")
    k: float = Field(0.05, gt=0, le=0.5, description="Imaginary part of the refractive index.")
    asymmetry: float = Field(0.85, ge=-1, le=1, description="Asymmetry parameter.")


class SoftParticles:
    declares = OpticsDeclaration(notes=("one refractive index and asymmetry at all wavelengths",))

    def __init__(self, inputs, parameters):
        self._p = parameters

    def single_scattering(self, cloud, wavenumber_cm1):
        radius = np.geomspace(*cloud.radius_range_um, 400)
        density = radius**cloud.alpha * np.exp(-cloud.b * radius**cloud.nu)
        area = np.pi * (radius * 1e-6) ** 2 * density / trapezoid(density, radius)
        size = 2e-4 * np.pi * radius * wavenumber_cm1[:, None]
        lag = 2.0 * size * (self._p.n - 1.0)
        beta = np.arctan(self._p.k / (self._p.n - 1.0))
        fringe, fade = np.cos(beta) / lag, np.exp(-lag * np.tan(beta))
        extinction = 2.0 + 4.0 * fringe**2 * np.cos(2 * beta)
        extinction -= 4.0 * fade * (fringe * np.sin(lag - beta) + fringe**2 * np.cos(lag - 2 * beta))
        depth = 4.0 * size * self._p.k
        absorption = 1.0 + 2.0 * np.exp(-depth) / depth + 2.0 * np.expm1(-depth) / depth**2
        cross_section = trapezoid(area * extinction, radius, axis=1)
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(
            extinction_m1=cloud.number_density_m3 * cross_section,
            albedo=1.0 - trapezoid(area * absorption, radius, axis=1) / cross_section,
            moments=np.stack((ones, self._p.asymmetry * ones)),
        )
