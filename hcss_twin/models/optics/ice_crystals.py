"""Ice crystals: properties relative to spheres of the same volume and projected area, and their phase function.

The table (recipe ``ice_yang_2013.py``) has the band averages of Yang et al. (2013) as used in RRTMGP, divided by those
of Mie spheres. The spheres provide the spectral detail within and between bands.

The phase function is one of diffraction, reflection and rays from inside, with a given albedo and asymmetry. A crystal
much larger than the wavelength diffracts as much light as it covers, whatever its shape and substance. It
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

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import open_format
from hcss_twin.models.optics.size_distribution import quadrature
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import Microphysics

FORMAT, VERSION = "hcss-ice-optics", 1
_RATIOS = ("extinction_ratio", "absorption_ratio", "asymmetry_ratio")


@dataclass(frozen=True, eq=False)
class CrystalRatios:
    """Ratios of crystal to sphere properties.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (B,)
        Logarithmic centres of the bands, ascending.
    effective_diameter_um : ndarray (D,)
        3/2 of volume over projected area, ascending.
    ratios : ndarray (3, B, D)
        Of extinction, of absorption, and of one minus the asymmetry parameter.
    """

    wavenumber_cm1: Array
    effective_diameter_um: Array
    ratios: Array

    def at(self, effective_diameter_um: float, wavenumber_cm1: Array) -> Array:
        """Return ratios (3, V): linear in diameter and ln wavenumber, constant beyond the outermost band centres.

        Raises
        ------
        ValueError
            If the diameter lies outside the table.
        """
        sizes = self.effective_diameter_um
        low, high = float(sizes[0]), float(sizes[-1])
        if not low <= effective_diameter_um <= high:
            closest = low if effective_diameter_um < low else high
            raise ValueError(
                f"effective radius {effective_diameter_um / 2:.4g} um of ice: the table of crystals allows "
                f"{low / 2:.4g} to {high / 2:.4g}; closest is {closest / 2:.4g}"
            )
        upper = int(np.clip(np.searchsorted(sizes, effective_diameter_um), 1, sizes.size - 1))
        share = (effective_diameter_um - sizes[upper - 1]) / (sizes[upper] - sizes[upper - 1])
        of_size = (1.0 - share) * self.ratios[:, :, upper - 1] + share * self.ratios[:, :, upper]
        position, centres = np.log(wavenumber_cm1), np.log(self.wavenumber_cm1)
        return np.stack([np.interp(position, centres, ratio) for ratio in of_size])


def load_crystals(catalog: Catalog, name: str, roughness: str) -> CrystalRatios:
    """Read a table from ``optics/<name>.nc`` or a user file in that format.

    Raises
    ------
    CatalogError
        If the table is missing, is damaged, has another format, or lacks the roughness.
    """
    path = catalog.find(name, "optics", ".nc")
    with open_format(path, FORMAT, VERSION) as dataset:
        try:
            names = [str(label) for label in dataset["roughness"][:]]
            if roughness not in names:
                raise CatalogError(f"{path}: no roughness '{roughness}'; it has {', '.join(names)}")
            row = names.index(roughness)
            limits = np.asarray(dataset["band_limits"][:], dtype=np.float64)
            diameter = np.asarray(dataset["effective_diameter"][:], dtype=np.float64)
            ratios = np.stack([np.asarray(dataset[ratio][row], dtype=np.float64) for ratio in _RATIOS])
        except (IndexError, OSError, RuntimeError) as error:
            raise CatalogError(f"{path}: damaged: {error}") from error
    _check(path, limits, diameter, ratios)
    return CrystalRatios(np.sqrt(limits[:, 0] * limits[:, 1]), diameter, ratios)


def _check(path: Path, limits: Array, diameter: Array, ratios: Array) -> None:
    if ratios.shape != (3, limits.shape[0], diameter.size) or diameter.size < 2 or limits.shape[1:] != (2,):
        raise CatalogError(f"{path}: ratios of shape {ratios.shape} do not fit bands and diameters")
    if not (np.all(np.diff(diameter) > 0.0) and np.all(np.diff(limits[:, 0] * limits[:, 1]) > 0.0)):
        raise CatalogError(f"{path}: effective_diameter and band_limits must increase")
    ascending = np.all((limits[:, 0] > 0.0) & (limits[:, 1] > limits[:, 0]))
    if not (ascending and np.all(np.isfinite(limits)) and diameter[0] > 0.0 and np.isfinite(diameter[-1])):
        raise CatalogError(f"{path}: effective_diameter and band_limits must be finite, above 0, and limits ascend")
    if not (np.all(np.isfinite(ratios)) and np.all(ratios > 0.0)):
        raise CatalogError(f"{path}: ratios must be above 0")


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
    from hcss_twin.physics.multiple_scattering.phase_function import extended_moments  # not for masks alone

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
