"""Laws of optics that need no reference: what particles larger than the wavelength do."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, near, range_ends, require
from hcss_twin.providers import Array, Microphysics, Optics

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


def extinction_is_that_of_particles_of_this_size(provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
    """Extinction is one to four times the cross-section of the particles; units and factors show here."""
    area_m1, radius_um = cross_section(cloud)
    bulk = provider.single_scattering(cloud, wavenumber_cm1)
    efficiency = bulk.extinction_m1 / area_m1
    at_most("extinction over the particles' cross-section", efficiency, EFFICIENCY[1])
    absorbed = efficiency * (1.0 - bulk.albedo)
    at_most("absorption over the particles' cross-section", absorbed, MOST_ABSORBED)
    large = _large(radius_um, wavenumber_cm1)
    if np.any(large):
        at_least("extinction of large particles over their cross-section", efficiency[large], EFFICIENCY[0])


def large_particles_scatter_forward(provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
    """Albedo is 0 (no scattering at all) or at least that of diffraction; asymmetry is 0 (isotropic) or forward."""
    radius_um = cross_section(cloud)[1]
    bulk = provider.single_scattering(cloud, wavenumber_cm1)
    large = _large(radius_um, wavenumber_cm1)
    if not np.any(large):
        raise Inapplicable("the particles are small at all wavenumbers")
    albedo, asymmetry = bulk.albedo[large], bulk.moments[1, large]
    at_least("albedo of large particles that scatter", albedo[albedo != 0.0], LEAST_ALBEDO)
    forward = asymmetry[(albedo > 0.0) & (asymmetry != 0.0)]
    at_least("asymmetry of large particles that scatter", forward, LEAST_ASYMMETRY)


def scattering_cosine_has_a_variance(provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
    """Moment 2 is not below P_2 of moment 1: a mean of squares is not below the square of the mean.

    Moments that carry a factor 2k + 1, or are of another kind, show here.
    """
    moments = provider.single_scattering(cloud, wavenumber_cm1).moments
    if moments.shape[0] == 2:
        raise Inapplicable("Henyey-Greenstein: the asymmetry parameter is all there is")
    at_least("moment 2", moments[2], 1.5 * moments[1] ** 2 - 0.5 - 1e-9)


def extinction_is_proportional_to_the_number_of_particles(
    provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
) -> None:
    """Twice the particles: twice the extinction, the same albedo and phase function."""
    once = provider.single_scattering(cloud, wavenumber_cm1)
    double = dataclasses.replace(cloud, number_density_m3=2.0 * cloud.number_density_m3)
    twice = provider.single_scattering(double, wavenumber_cm1)
    near("extinction of twice the particles", twice.extinction_m1, 2.0 * once.extinction_m1, rtol=1e-9)
    near("albedo of twice the particles", twice.albedo, once.albedo, rtol=1e-9)
    near("moments of twice the particles", twice.moments, once.moments, rtol=1e-9, atol=1e-12)


def declared_range_is_usable_to_its_ends(provider: Optics, cloud: Microphysics) -> None:
    """The lowest and highest declared wavenumbers give properties."""
    bulk = provider.single_scattering(cloud, range_ends(provider.declares))
    require(np.isfinite(bulk.extinction_m1), "extinction is not finite")


def _large(radius_um: float, wavenumber_cm1: Array) -> NDArray[np.bool_]:
    return np.asarray(2e-4 * np.pi * radius_um * wavenumber_cm1 >= LARGE)


def cross_section(cloud: Microphysics) -> tuple[float, float]:
    """Return the geometric cross-section of the particles per volume in m-1, and their effective radius in um."""
    radius = np.geomspace(*cloud.radius_range_um, 2000)
    density = radius**cloud.alpha * np.exp(-cloud.b * radius**cloud.nu)
    number, square, cube = (float(np.trapezoid(density * radius**power, radius)) for power in (0, 2, 3))
    return cloud.number_density_m3 * np.pi * 1e-12 * square / number, cube / square


LAWS: tuple[Law, ...] = (
    extinction_is_that_of_particles_of_this_size,
    large_particles_scatter_forward,
    scattering_cosine_has_a_variance,
    extinction_is_proportional_to_the_number_of_particles,
    declared_range_is_usable_to_its_ends,
)
