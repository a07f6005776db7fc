"""The dense spectral grid: where spectra are evaluated and how they sum to bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.planck import wavenumber_from_um
from hcss_twin.radiance.spectral_band import SpectralBand

Array = NDArray[np.float64]

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
