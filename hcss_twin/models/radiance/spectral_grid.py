"""A spectral band with its response.

Extraterrestrial solar irradiance from the catalog.

The dense spectral grid: where spectra are evaluated and how they sum to bands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.planck import wavenumber_from_um


@dataclass(frozen=True)
class SpectralBand:
    """A band with its response.

    Attributes
    ----------
    name : str
        Name in the cube.
    wavelength_um : ndarray (N,)
        Ascending wavelengths at which the response is known; linear between, 0 outside.
    response : ndarray (N,)
        Relative response, 0 to 1.
    """

    name: str
    wavelength_um: Array
    response: Array

    @property
    def lower_um(self) -> float:
        """Shortest wavelength."""
        return float(self.wavelength_um[0])

    @property
    def upper_um(self) -> float:
        """Longest wavelength."""
        return float(self.wavelength_um[-1])

    @property
    def width_cm1(self) -> float:
        """Distance of its limits in wavenumber."""
        return 1e4 / self.lower_um - 1e4 / self.upper_um

    @property
    def central_um(self) -> float:
        """Centroid over wavelength of the response, which is linear between its nodes."""
        step, left, right = np.diff(self.wavelength_um), self.response[:-1], self.response[1:]
        # From the shortest wavelength: relative to it the moments of narrow bands keep their digits.
        start = self.wavelength_um[:-1] - self.wavelength_um[0]
        area = step * (left + right) / 2.0
        moment = start * area + step**2 * (left + 2.0 * right) / 6.0
        return self.lower_um + float(np.sum(moment) / np.sum(area))


class SolarSpectrum:
    """Spectral irradiance at 1 au, ASTM E490-00a by default.

    Interpolated log-log between tabulated wavelengths, which follows the steep tail beyond 10 um.
    """

    def __init__(self, catalog: Catalog, name: str = "astm-e490") -> None:
        columns = catalog.columns(catalog.find(name, "solar", ".csv"))
        self._ln_wavelength = np.log(columns["wavelength_um"])
        self._ln_irradiance = np.log(columns["irradiance_W_m2_um"])

    def __call__(self, wavenumber_cm1: Array) -> Array:
        """Return W m-2 (cm-1)-1.

        Raises
        ------
        ValueError
            If a wavenumber lies outside the spectrum.
        """
        ln_wavelength = np.log(1e4 / wavenumber_cm1)
        low, high = self._ln_wavelength[0], self._ln_wavelength[-1]
        if np.any(ln_wavelength < low) or np.any(ln_wavelength > high):
            raise ValueError(
                f"solar spectrum: wavenumbers {wavenumber_cm1.min():.6g} to {wavenumber_cm1.max():.6g} cm-1; allowed "
                f"{1e4 / np.exp(high):.6g} to {1e4 / np.exp(low):.6g} cm-1"
            )
        per_um = np.exp(np.interp(ln_wavelength, self._ln_wavelength, self._ln_irradiance))
        # E per cm-1 = E per um x |d lambda / d nu| with lambda in um and nu in cm-1.
        result: Array = per_um * 1e4 / wavenumber_cm1**2
        return result


DEFAULT_STEP_CM1 = 5.0
"""Step where no provider has a grid of its own: that of LOWTRAN7."""


@dataclass(frozen=True)
class SpectralGrid:
    """Wavenumbers shared by all bands and trapezoidal weights of each band.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
        Ascending.
    weights_cm1 : ndarray (B, V)
        Band radiance = spectral radiance (V,) @ weights; includes the spectral response.
    nodes : tuple of ndarray
        Indices of each band's own wavenumbers.
    response : tuple of ndarray
        Response at those wavenumbers.
    """

    wavenumber_cm1: Array
    weights_cm1: Array
    nodes: tuple[NDArray[np.intp], ...]
    response: tuple[Array, ...]


def dense_grid(bands: Sequence[SpectralBand], native_cm1: Array | None) -> SpectralGrid:
    """Return every native wavenumber inside the bands, their edges, and their response's own nodes.

    Parameters
    ----------
    bands : sequence of SpectralBand (B,)
        Resolved bands.
    native_cm1 : ndarray or None
        Grid of the transmittance provider; a regular 5 cm-1 grid where it has none.
    """
    per_band = [_band_nodes(band, native_cm1) for band in bands]
    wavenumber = np.unique(np.concatenate(per_band))
    weights = np.zeros((len(bands), wavenumber.size))
    nodes, responses = [], []
    for row, (band, own) in enumerate(zip(bands, per_band, strict=True)):
        index = np.searchsorted(wavenumber, own)
        response = np.interp(1e4 / own, band.wavelength_um, band.response)
        weights[row, index] = _trapezoid_weights(own) * response
        nodes.append(index)
        responses.append(response)
    return SpectralGrid(wavenumber, weights, tuple(nodes), tuple(responses))


def _band_nodes(band: SpectralBand, native_cm1: Array | None) -> Array:
    edges = np.sort(wavenumber_from_um(band.wavelength_um))
    low, high = edges[0], edges[-1]
    if native_cm1 is None:
        first = np.ceil(low / DEFAULT_STEP_CM1) * DEFAULT_STEP_CM1
        native_cm1 = np.arange(first, high, DEFAULT_STEP_CM1)
    inside = native_cm1[(native_cm1 > low) & (native_cm1 < high)]
    nodes = np.unique(np.concatenate((edges, inside)))
    # A native node that rounding puts beside an edge would make a panel of no width.
    keep = np.concatenate(([True], np.diff(nodes) > 1e-9 * high))
    result: Array = nodes[keep]
    return result


def _trapezoid_weights(nodes: Array) -> Array:
    weights = np.zeros_like(nodes)
    step = np.diff(nodes)
    weights[:-1] += 0.5 * step
    weights[1:] += 0.5 * step
    return weights
