"""Laws of optics that need no reference: what particles larger than the wavelength do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hcss_twin.providers import Array, Microphysics, Optics
from hcss_twin.testing.samples import range_ends

LARGE = 8.0
"""Size parameter 2 pi r / wavelength, for the effective radius, from which the limits of large particles hold."""

EFFICIENCY = (1.25, 3.6)
"""Extinction over geometric cross-section of large particles: 2 in the limit, at most 3.6 averaged over sizes."""

MOST_ABSORBED = 1.6
"""Absorption over geometric cross-section of any particles: about 1 if large, up to 1.4 near the wavelength."""

LEAST_ALBEDO = 0.42
"""Of large particles that scatter: light diffracted past them, half of the extinction, is not absorbed."""

LEAST_ASYMMETRY = 0.5
"""Of large particles that do not scatter isotropically: light diffracted past them goes forward."""


class OpticsLaws:
    """Laws of an optics provider; part of ``OpticsContract``."""

    def test_extinction_is_that_of_particles_of_this_size(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Extinction is one to four times the cross-section of the particles; units and factors show here."""
        area_m1, radius_um = cross_section(cloud)
        bulk = provider.single_scattering(cloud, wavenumber_cm1)
        efficiency = bulk.extinction_m1 / area_m1
        assert np.all(efficiency <= EFFICIENCY[1]), f"extinction is {efficiency.max():.3g} times the cross-section"
        absorbed = efficiency * (1.0 - bulk.albedo)
        assert np.all(absorbed <= MOST_ABSORBED), f"absorption is {absorbed.max():.3g} times the cross-section"
        large = self._large(radius_um, wavenumber_cm1)
        if np.any(large):
            least = float(efficiency[large].min())
            assert least >= EFFICIENCY[0], f"extinction of large particles is {least:.3g} times the cross-section"

    def test_large_particles_scatter_forward(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Albedo is 0 (no scattering at all) or at least that of diffraction; asymmetry is 0 (isotropic) or forward."""
        radius_um = cross_section(cloud)[1]
        bulk = provider.single_scattering(cloud, wavenumber_cm1)
        large = self._large(radius_um, wavenumber_cm1)
        if not np.any(large):
            pytest.skip("the particles are small at all wavenumbers")
        albedo, asymmetry = bulk.albedo[large], bulk.moments[1, large]
        assert np.all((albedo == 0.0) | (albedo >= LEAST_ALBEDO)), f"albedo {albedo.min():.3g}"
        scatters = albedo > 0.0
        assert np.all((asymmetry == 0.0) | (asymmetry >= LEAST_ASYMMETRY) | ~scatters), f"{asymmetry.min():.3g}"

    def test_declared_range_is_usable_to_its_ends(self, provider: Optics, cloud: Microphysics) -> None:
        """The lowest and highest declared wavenumbers give properties."""
        bulk = provider.single_scattering(cloud, range_ends(provider.declares))
        assert np.all(np.isfinite(bulk.extinction_m1))

    @staticmethod
    def _large(radius_um: float, wavenumber_cm1: Array) -> NDArray[np.bool_]:
        return np.asarray(2e-4 * np.pi * radius_um * wavenumber_cm1 >= LARGE)


def cross_section(cloud: Microphysics) -> tuple[float, float]:
    """Return the geometric cross-section of the particles per volume in m-1, and their effective radius in um."""
    radius = np.geomspace(*cloud.radius_range_um, 2000)
    density = radius**cloud.alpha * np.exp(-cloud.b * radius**cloud.nu)
    number, square, cube = (float(np.trapezoid(density * radius**power, radius)) for power in (0, 2, 3))
    return cloud.number_density_m3 * np.pi * 1e-12 * square / number, cube / square
