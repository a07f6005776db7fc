"""Phase function of large crystals with a given albedo and asymmetry: diffraction, reflection and rays from inside.

A crystal much larger than the wavelength diffracts as much light as it covers, whatever its shape and substance. It
reflects from its outside the hemispherical mean of Fresnel's reflectance, in a pattern that is the same for all convex
bodies of random orientation: that of a sphere (H. C. van de Hulst, Light Scattering by Small Particles, 1957, section
8.42). What is left of the scattered light has been inside. Its pattern is Henyey and Greenstein's, with the asymmetry
that makes the whole have the given one, so that smooth crystals have no halos. Where ice absorbs all that enters (2.9
to 3.3 um), nothing is left, and the pattern does not depend on the shape of convex crystals.

From 2.95 to 3.3 um, of spheres of 30 um, it is within 8 % of Mie theory from 40 to 170 deg, and .3 to .8 times as
bright at 5 to 20 deg; Henyey and Greenstein's function with the same asymmetry is .3 to 2.5 times as bright beyond 40
deg.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.optics.size_distribution import quadrature
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.multiple_scattering.phase_function import extended_moments
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import Microphysics

REFLECTION_MOMENTS = 256
"""The reflected light has a cusp forward; its moments decrease with the cube of the degree."""

INSIDE = (0.5, 0.95)
"""Asymmetry of light that has been inside: of strongly refracting rough crystals, and of light that hardly bends."""

SHARPER = 4.0
"""Peaks may be this many times as sharp as Fraunhofer's."""

_HALVINGS = 40
_RADII, _NODES = 400, 4096


def crystal_moments(
    peaks: DiffractionPeaks, efficiency: Array, asymmetry: Array, index: NDArray[np.complex128], wavelength_um: Array
) -> Array:
    """Return the Legendre moments (K, V) of the phase function; ``moments[1]`` is ``asymmetry``.

    Parameters
    ----------
    peaks : DiffractionPeaks
        Of spheres with the projected areas of the crystals.
    efficiency : ndarray (V,)
        Scattering cross-section over projected area.
    asymmetry : ndarray (V,)
    index : ndarray (V,)
        Refractive index n + ik of the substance.
    wavelength_um : ndarray (V,)

    Notes
    -----
    The asymmetry of the tails of diffraction peaks is not known to better than some percent of 1 - g; where ``INSIDE``
    limits the light from inside, peaks are made sharper or wider so that the whole keeps its asymmetry. If even peaks
    ``SHARPER`` times as sharp do not suffice, there is less light beside them. K grows with the largest crystals.
    """
    reflected, reflectance = _reflected(index)
    inside = np.maximum(efficiency - 1.0 - reflectance, 0.0)
    beyond_peak = 1.0 - peaks.moments(wavelength_um, 2)[1]
    # 1 - asymmetry, of the whole and of its parts, is free of cancellation.
    whole, outside = (1.0 - asymmetry) * (1.0 + reflectance + inside), reflectance * (1.0 - reflected[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        wanted = 1.0 - (whole - beyond_peak - outside) / inside
    g_inside = np.clip(np.where(inside > 0.0, wanted, INSIDE[1]), *INSIDE)
    aside = outside + inside * (1.0 - g_inside)
    sharpest = beyond_peak / SHARPER
    excess = aside - (1.0 - asymmetry) * (reflectance + inside)
    share = np.clip((1.0 - asymmetry - sharpest) / np.maximum(excess, np.finfo(np.float64).tiny), 0.0, 1.0)
    reflectance, inside, aside = share * reflectance, share * inside, share * aside
    peak = 1.0 - ((1.0 - asymmetry) * (1.0 + reflectance + inside) - aside)
    widened = wavelength_um * peaks.width(wavelength_um, peak)
    count = max(peaks.count(widened), REFLECTION_MOMENTS)
    moments = peaks.moments(widened, count)
    moments[:REFLECTION_MOMENTS] += reflectance * reflected
    moments += inside * extended_moments(np.stack([np.ones_like(g_inside), g_inside]), count)
    result: Array = moments / moments[0]
    return result


def _reflected(index: NDArray[np.complex128]) -> tuple[Array, Array]:
    """Return the moments (K, V) of light reflected outside, and the hemispherical mean reflectance (V,)."""
    cosine, weight = gauss_legendre(2 * REFLECTION_MOMENTS)
    # A ray that is turned by Theta met the surface at (pi - Theta) / 2.
    pattern = unpolarised_reflectance(index, np.sqrt(0.5 * (1.0 - cosine))[:, np.newaxis])
    sums = np.polynomial.legendre.legvander(cosine, REFLECTION_MOMENTS - 1).T @ (weight[:, np.newaxis] * pattern)
    return sums / sums[0], 0.5 * sums[0]


class DiffractionPeaks:
    """Diffraction by the shadows of particles: Fraunhofer's for discs, times Kirchhoff's factor cos^4(theta / 2).

    The moments of Fraunhofer's are the overlap of two discs that are sqrt(l (l + 1)) wavelengths / (2 pi) apart, with
    radii in the same unit.

    Parameters
    ----------
    cloud : Microphysics
        Spheres with the projected areas.
    """

    def __init__(self, cloud: Microphysics) -> None:
        radius, number = quadrature(cloud, _RADII)
        self._apart_um = np.linspace(0.0, 2.0 * radius[-1], _NODES)
        u = np.minimum(0.5 * self._apart_um[:, np.newaxis] / radius, 1.0)
        overlap = (2.0 / np.pi) * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
        area = number * radius**2
        self._overlap = overlap @ (area / area.sum())

    def count(self, wavelength_um: Array) -> int:
        """Return the number of moments after which all are 0 at these wavelengths (V,)."""
        return int(2.0 * np.pi * self._apart_um[-1] / float(np.min(wavelength_um))) + 4

    def moments(self, wavelength_um: Array, count: int) -> Array:
        """Return the moments (K, V) at wavelengths (V,); the first is 1."""
        degree = np.arange(count + 2.0)[:, np.newaxis]
        apart = np.sqrt(degree * (degree + 1.0)) * (wavelength_um / (2.0 * np.pi))
        moments = np.interp(apart, self._apart_um, self._overlap, right=0.0)
        for _ in range(2):  # times (1 + mu) / 2
            below, above = np.concatenate((np.zeros_like(moments[:1]), moments[:-2])), moments[1:]
            of_cosine = ((degree[:-1] + 1.0) * above + degree[:-1] * below) / (2.0 * degree[:-1] + 1.0)
            moments, degree = 0.5 * (moments[:-1] + of_cosine), degree[:-1]
        result: Array = moments / moments[0]
        return result

    def width(self, wavelength_um: Array, asymmetry: Array) -> Array:
        """Return the factor (V,) by which peaks must be wider to have an asymmetry (V,)."""
        low, high = np.full(asymmetry.shape, -12.0), np.full(asymmetry.shape, 6.0)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            sharp = self.moments(wavelength_um * np.exp(middle), 2)[1] > asymmetry
            low, high = np.where(sharp, middle, low), np.where(sharp, high, middle)
        result: Array = np.exp(low)
        return result
