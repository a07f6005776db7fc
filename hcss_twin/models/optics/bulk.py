"""Optical properties of a volume of particles: Mie efficiencies summed over the size distribution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.optics.size_distribution import projected_area_m1, quadrature
from hcss_twin.models.optics.spheres import MomentSums, mie_efficiencies
from hcss_twin.models.refractive_index import RefractiveIndex
from hcss_twin.providers import Microphysics

RESONANCES = ((0.0015, 16), (0.005, 8), (0.02, 4), (np.inf, 1))
"""Imaginary index below which so many times the radii are used: absorption is what widens resonances."""

_SPHERES_AT_ONCE = 65536

MAX_MOMENT_RADII = 2
"""Times the radii at most for the phase function, whose resonances a wavelength's neighbours average out."""


@dataclass(frozen=True, eq=False)
class BulkProperties:
    """Coefficients of a cloud volume.

    Attributes
    ----------
    extinction_m1, scattering_m1 : ndarray (V,)
        Volume coefficients, m-1.
    asymmetry : ndarray (V,)
        Scattering-weighted asymmetry parameter.
    """

    extinction_m1: Array
    scattering_m1: Array
    asymmetry: Array

    @property
    def absorption_m1(self) -> Array:
        """Volume absorption coefficient (V,), m-1."""
        return self.extinction_m1 - self.scattering_m1

    @property
    def albedo(self) -> Array:
        """Single-scattering albedo (V,), eq 11 of the HCSS paper."""
        return self.scattering_m1 / self.extinction_m1


def bulk_properties(
    cloud: Microphysics, index: RefractiveIndex, wavelength_um: Array, radius_nodes: int
) -> BulkProperties:
    """Integrate Mie efficiencies over the particles at each wavelength, without spectral interpolation.

    Parameters
    ----------
    cloud : Microphysics
        Particles, with a number density above 0.
    index : RefractiveIndex
        Of their substance.
    wavelength_um : ndarray (V,)
        Wavelengths within the table of ``index``.
    radius_nodes : int
        Number of radii of the quadrature; more where k is small, see ``RESONANCES``.

    Returns
    -------
    BulkProperties
        For ``wavelength_um`` (V,).

    Notes
    -----
    Eq 9 of the HCSS paper, pi * integral of r^2 Q n(r) dr, for absorption and extinction alike. Eq 10
    multiplies 1 - albedo with a bare efficiency; a coefficient per length needs the number density
    too, so ice is integrated as eq 9 is.
    """
    wavelength = np.asarray(wavelength_um, dtype=np.float64)
    refractive = index.at(1e4 / wavelength)
    factor = _times(refractive)
    sums = np.empty((3, wavelength.size))
    for many in np.unique(factor):
        chosen = factor == many
        sums[:, chosen] = _integrate(cloud, refractive[chosen], wavelength[chosen], int(many) * radius_nodes)
    extinction, scattering, forward = sums
    return BulkProperties(extinction, scattering, forward / scattering)


def bulk_moments(
    cloud: Microphysics, index: RefractiveIndex, wavelength_um: Array, radius_nodes: int, count: int
) -> Array:
    """Legendre moments of the phase function of the particles together, without spectral interpolation.

    Parameters
    ----------
    cloud, index, wavelength_um, radius_nodes
        As of :func:`bulk_properties`; of the radii no more than ``MAX_MOMENT_RADII`` times as many are used.
    count : int
        Number K of moments.

    Returns
    -------
    ndarray (K, V)
        ``moments[0]`` is 1 and ``moments[1]`` the asymmetry parameter.
    """
    wavelength = np.asarray(wavelength_um, dtype=np.float64)
    refractive = index.at(1e4 / wavelength)
    sums = MomentSums(count)
    result = np.empty((count, wavelength.size))
    for column, many in enumerate(np.minimum(_times(refractive), MAX_MOMENT_RADII)):
        radius, number = quadrature(cloud, int(many) * radius_nodes)
        size = 2.0 * np.pi * radius / wavelength[column]
        result[:, column] = sums(complex(refractive[column]), size, number)
    return result


def _times(refractive: NDArray[np.complex128]) -> NDArray[np.int64]:
    """How many times the radii each wavelength (V,) takes."""
    below = [refractive.imag < limit for limit, _ in RESONANCES]
    return np.asarray(np.select(below, [many for _, many in RESONANCES]), dtype=np.int64)


def _integrate(cloud: Microphysics, refractive: NDArray[np.complex128], wavelength_um: Array, nodes: int) -> Array:
    """Extinction, scattering and asymmetry-weighted scattering coefficients (3, V), m-1."""
    radius, number = quadrature(cloud, nodes)
    area = np.pi * (radius * 1e-6) ** 2 * number
    result = np.empty((3, wavelength_um.size))
    step = max(1, _SPHERES_AT_ONCE // radius.size)
    for start in range(0, wavelength_um.size, step):
        part = slice(start, start + step)
        size = 2.0 * np.pi * radius / wavelength_um[part, np.newaxis]
        substance = np.broadcast_to(refractive[part, np.newaxis], size.shape)
        q_ext, q_sca, g = (q.reshape(size.shape) for q in mie_efficiencies(substance.ravel(), size.ravel()))
        result[:, part] = q_ext @ area, q_sca @ area, (q_sca * g) @ area
    return result


def bulk_efficiencies(
    cloud: Microphysics, index: RefractiveIndex, wavelength_um: Array, radius_nodes: int
) -> tuple[Array, Array, Array]:
    """Extinction, scattering and absorption efficiencies (V,) of the particles together.

    Fig 6 of the HCSS paper shows them. They are the volume coefficients divided by the
    geometric cross section per volume.
    """
    bulk = bulk_properties(cloud, index, wavelength_um, radius_nodes)
    area = projected_area_m1(cloud)
    return bulk.extinction_m1 / area, bulk.scattering_m1 / area, bulk.absorption_m1 / area
