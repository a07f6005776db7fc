"""Spectral bands: response, wavenumbers of the spectra, and integration over the band.

A band radiance is a weighted sum of spectral radiance over a dense grid, or over a few wavenumbers chosen for the scene
(:meth:`SpectralGrid.choose_nodes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.planck import wavenumber_from_um
from hcss_twin.providers import ColumnSetting, RadianceModel
from hcss_twin.providers.column_states import spectra_of

__all__ = ["SpectralGrid"]


@dataclass(frozen=True)
class SpectralBand:
    """A spectral band.

    Attributes
    ----------
    name : str
        Name in the cube.
    wavelength_um : ndarray (N,)
        Ascending; the response is linear between them and 0 outside.
    response : ndarray (N,)
        Relative response, 0 to 1.
    read_as : str
        How a file of the response was understood, if it could be understood otherwise.
    """

    name: str
    wavelength_um: Array
    response: Array
    read_as: str = ""

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
        """Width of the band in wavenumber."""
        return 1e4 / self.lower_um - 1e4 / self.upper_um

    @property
    def central_um(self) -> float:
        """Centroid wavelength of the response, which is linear between its nodes."""
        step, left, right = np.diff(self.wavelength_um), self.response[:-1], self.response[1:]
        # Relative to the shortest wavelength, to avoid cancellation in the moments of narrow bands.
        start = self.wavelength_um[:-1] - self.wavelength_um[0]
        area = step * (left + right) / 2.0
        moment = start * area + step**2 * (left + 2.0 * right) / 6.0
        return self.lower_um + float(np.sum(moment) / np.sum(area))


class SolarSpectrum:
    """Spectral irradiance at 1 au, ASTM E490-00a by default.

    Log-log interpolation between tabulated wavelengths follows the steep tail beyond 10 um.
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


@dataclass(frozen=True)
class SpectralNodes:
    """Wavenumbers at which spectra are computed, and their weights in each band.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (N,)
        Ascending.
    weights_cm1 : ndarray (B, N)
        Band radiance = spectral radiance (N,) @ weights.
    """

    wavenumber_cm1: Array
    weights_cm1: Array


DEFAULT_STEP_CM1 = 5.0
"""Step if the transmittance provider has no grid of its own: that of LOWTRAN7."""


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

    @property
    def ends_cm1(self) -> Array:
        """First and last wavenumber of each band: models that interpolate in a band need both."""
        result: Array = self.wavenumber_cm1[np.unique([end for node in self.nodes for end in (node[0], node[-1])])]
        return result

    @staticmethod
    def dense(bands: Sequence[SpectralBand], native_cm1: Array | None, refinement: int = 0) -> SpectralGrid:
        """Return the grid of all native wavenumbers inside the bands, the band edges, and the nodes of the responses.

        Weights are those of the trapezoidal rule, or of Simpson's on a refined grid.

        Parameters
        ----------
        bands : sequence of SpectralBand (B,)
            Resolved bands.
        native_cm1 : ndarray or None
            Grid of the transmittance provider; a regular 5 cm-1 grid if it has none.
        refinement : int
            0: these wavenumbers; -1: every second native one; n above 0: divided into 2^n.
        """
        per_band = [_refined(_band_nodes(band, native_cm1, 2 if refinement < 0 else 1), refinement) for band in bands]
        wavenumber = np.unique(np.concatenate(per_band))
        weights = np.zeros((len(bands), wavenumber.size))
        nodes, responses = [], []
        for row, (band, nodes_cm1) in enumerate(zip(bands, per_band, strict=True)):
            index = np.searchsorted(wavenumber, nodes_cm1)
            response = np.interp(1e4 / nodes_cm1, band.wavelength_um, band.response)
            weights[row, index] = (
                _simpson_weights(nodes_cm1) if refinement > 0 else _trapezoid_weights(nodes_cm1)
            ) * response
            nodes.append(index)
            responses.append(response)
        return SpectralGrid(wavenumber, weights, tuple(nodes), tuple(responses))

    def all_nodes(self) -> SpectralNodes:
        """Return all wavenumbers as nodes."""
        return SpectralNodes(self.wavenumber_cm1, self.weights_cm1)

    def choose_nodes(self, spectra: Array, tolerance: float) -> SpectralNodes:
        """Choose a few wavenumbers whose weighted sums reproduce the band radiances of given spectra.

        Spectra of one scene are similar: gas lines, clouds and sun vary with thickness and time in few independent
        ways. A band therefore needs only a few wavenumbers, if they and their weights are chosen for the spectra of the
        scene. Non-negative weights keep radiances positive, and the terms of a spectrum still sum to its total.

        The method is an empirical quadrature: wavenumbers are added greedily, and their weights follow by non-negative
        least squares (C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems*, 1974, chapter 23), until the sum
        of every spectrum is within the tolerance.

        Parameters
        ----------
        spectra : ndarray (S, K, V)
            K terms of S columns.
        tolerance : float
            Maximum error of any term of any column, relative to the column's total in the band.

        Returns
        -------
        SpectralNodes
            A subset of the grid.
        """
        weights = np.zeros_like(self.weights_cm1)
        for band, node in enumerate(self.nodes):
            summands = spectra[:, :, node] * self.weights_cm1[band, node]
            weights[band, node] = self.weights_cm1[band, node] * _factors(summands, tolerance)
        used = np.flatnonzero(weights.any(axis=0))
        return SpectralNodes(self.wavenumber_cm1[used], np.ascontiguousarray(weights[:, used]))

    @staticmethod
    def reference_radiance(
        model: RadianceModel,
        setting: ColumnSetting,
        grid: SpectralGrid,
        thickness_m: Sequence[float] | Array,
        together: int = 1,
    ) -> Array:
        """Return the band radiance of single pixels from dense spectra, without tables or interpolation.

        It is slow and simple; all faster code is tested against it.

        Parameters
        ----------
        thickness_m : sequence of float (N,) or array (N, L)
            Cloud thickness of each pixel, 0 for clear sky, with one column per layer; (N,) is short for a single layer.
        together : int
            Number of columns that the model computes together, which is faster.

        Returns
        -------
        ndarray (N, B)
            W m-2 sr-1.
        """
        thickness = np.asarray(thickness_m, dtype=np.float64)
        columns = thickness[:, None] if thickness.ndim == 1 else thickness
        spectra = SpectralGrid.reference_spectra(model, setting, grid.wavenumber_cm1, columns, together)
        result: Array = np.sum(spectra, axis=1) @ grid.weights_cm1.T
        return result

    @staticmethod
    def reference_spectra(
        model: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array, thickness_m: Array, together: int = 1
    ) -> Array:
        """Return the terms (N, K, V) of columns (N, L) at wavenumbers (V,), in the order of ``model.terms``.

        Parameters
        ----------
        model, setting, together
            As for :meth:`reference_radiance`.
        """
        result = np.empty((thickness_m.shape[0], len(model.terms), wavenumber_cm1.size))
        if not wavenumber_cm1.size:  # a finer grid of narrow bands may have no new ones
            return result
        for start in range(0, thickness_m.shape[0], together):
            rows = slice(start, start + together)
            result[rows] = spectra_of(model, [setting], wavenumber_cm1, thickness_m[rows])[0]
        return result


def _band_nodes(band: SpectralBand, native_cm1: Array | None, every: int) -> Array:
    edges = np.sort(wavenumber_from_um(band.wavelength_um))
    low, high = edges[0], edges[-1]
    if native_cm1 is None:
        first = np.ceil(low / DEFAULT_STEP_CM1) * DEFAULT_STEP_CM1
        native_cm1 = np.arange(first, high, DEFAULT_STEP_CM1)
    inside = native_cm1[(native_cm1 > low) & (native_cm1 < high)][::every]
    nodes = np.unique(np.concatenate((edges, inside)))
    # Rounding may put a native node next to an edge, at zero distance.
    keep = np.concatenate(([True], np.diff(nodes) > 1e-9 * high))
    result: Array = nodes[keep]
    return result


def _refined(nodes: Array, refinement: int) -> Array:
    """Return the nodes, with each interval divided into 2^``refinement`` parts."""
    if refinement <= 0:
        return nodes
    parts = 2**refinement
    between = nodes[:-1, None] + np.diff(nodes)[:, None] * np.arange(parts) / parts
    return np.append(between.ravel(), nodes[-1])


def _simpson_weights(nodes: Array) -> Array:
    """Return Simpson's weights of an odd number of nodes, every second of which is midway between its neighbours."""
    weights = np.zeros_like(nodes)
    sixth = np.diff(nodes[::2]) / 6.0
    weights[:-1:2] += sixth
    weights[2::2] += sixth
    weights[1::2] = 4.0 * sixth
    return weights


def _trapezoid_weights(nodes: Array) -> Array:
    weights = np.zeros_like(nodes)
    step = np.diff(nodes)
    weights[:-1] += 0.5 * step
    weights[1:] += 0.5 * step
    return weights


def _factors(summands: Array, tolerance: float) -> Array:
    """Return factors (V,), mostly 0, that preserve the sums of (S, K, V) within the tolerance."""
    total = np.sum(summands, axis=(1, 2))
    lit = total > 0.0
    rows = (summands[lit] / total[lit, None, None]).reshape(-1, summands.shape[2])
    rows = rows[rows.any(axis=1)]
    target = np.sum(rows, axis=1)
    size = np.linalg.norm(rows, axis=0)
    every = np.ones(summands.shape[2])
    if not rows.size:
        return every
    direction = rows / np.where(size > 0.0, size, 1.0)
    chosen: list[int] = []
    factors, left = np.zeros(0), target
    while np.max(np.abs(left)) > tolerance:
        gain = left @ direction
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        if gain[best] <= 0.0 or len(chosen) >= every.size:
            return every
        chosen, factors = _refit(rows, target, [*chosen, best], np.append(factors, 0.0))
        if chosen[-1] != best:
            return every
        left = target - rows[:, chosen] @ factors
    result = np.zeros_like(every)
    result[chosen] = factors
    return result


def _refit(rows: Array, target: Array, chosen: list[int], factors: Array) -> tuple[list[int], Array]:
    """Return columns and their positive factors that fit a target best, given factors that are not negative.

    As far as factors stay positive, they move toward the least squares, and columns whose factor vanishes are dropped
    (C. L. Lawson and R. J. Hanson, "Solving Least Squares Problems", Prentice-Hall 1974, chapter 23). scipy's function
    would bring the import of all its solvers, .4 s, into every compilation.
    """
    while True:
        fit = np.asarray(np.linalg.lstsq(rows[:, chosen], target, rcond=None)[0], dtype=np.float64)
        falls = np.flatnonzero(fit <= 0.0)
        if not falls.size:
            return chosen, fit
        fall = factors[falls] - fit[falls]
        shares = np.divide(factors[falls], fall, out=np.zeros_like(fall), where=fall > 0.0)  # 0 of 0 vanishes at once
        factors = factors + np.min(shares) * (fit - factors)
        kept = np.delete(np.arange(factors.size), falls[shares == np.min(shares)])
        chosen, factors = [chosen[position] for position in kept], factors[kept]
        if not chosen:
            return [-1], factors
