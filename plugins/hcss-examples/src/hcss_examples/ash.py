"""Volcanic ash: absorbing spheres by anomalous diffraction, for a layer above clouds of water."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import Array, Microphysics, OpticsDeclaration, OpticsInputs, SingleScattering


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    index: float = Field(1.5, gt=1, le=2.5, description="Real part of the refractive index, at all wavelengths.")
    absorption: float = Field(0.1, gt=0, le=2, description="Imaginary part of the refractive index.")
    asymmetry: float = Field(0.7, gt=-1, lt=1, description="Asymmetry parameter (Henyey-Greenstein).")


class Ash:
    """Spheres of one refractive index."""

    declares = OpticsDeclaration(
        materials=frozenset({"ash"}), notes=("ash: grey refractive index, anomalous diffraction",)
    )

    def __init__(self, inputs: OpticsInputs, parameters: Parameters) -> None:
        self._of = parameters

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return extinction (V,) in m-1, albedo (V,) and Legendre moments (2, V)."""
        radius_um = np.geomspace(*cloud.radius_range_um, 500)
        # n(r) = a r^alpha exp(-b r^nu); one more r, because the radii are evenly spaced in their logarithm
        number = radius_um ** (cloud.alpha + 1.0) * np.exp(-cloud.b * radius_um**cloud.nu)
        area = number / number.sum() * cloud.number_density_m3 * np.pi * 1e-12 * radius_um**2
        extinction, absorption = efficiencies(
            2e-4 * np.pi * wavenumber_cm1[:, None] * radius_um, self._of.index, self._of.absorption
        )
        total, absorbed = extinction @ area, absorption @ area
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(total, 1.0 - absorbed / total, np.stack((ones, self._of.asymmetry * ones)))


def efficiencies(size: Array, index: float, absorption: float) -> tuple[Array, Array]:
    """Return the efficiencies of extinction and absorption at size parameters 2 pi r / wavelength.

    Anomalous diffraction (H. C. van de Hulst, "Light Scattering by Small Particles", 1957, section 11.23), which is
    that of optically soft spheres: both are K of a complex path, with K(w) = 1/2 + exp(-w) / w + (exp(-w) - 1) / w^2.
    """

    def k(w: NDArray[Any]) -> NDArray[Any]:
        small = np.abs(w) < 1e-2  # the series avoids the difference of nearly equal numbers
        safe = np.where(small, 1.0, w)
        result: NDArray[Any] = np.where(
            small, w / 3.0 - w**2 / 8.0, 0.5 + np.exp(-safe) / safe + (np.exp(-safe) - 1.0) / safe**2
        )
        return result

    phase = 2.0 * size * complex(absorption, index - 1.0)
    return 4.0 * np.real(k(phase)), 2.0 * np.real(k(4.0 * size * absorption + 0j))
