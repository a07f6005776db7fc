"""At which wavenumbers the columns of a scene are computed: chosen on some of its columns, tried on others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Sun
from hcss_twin.radiance.spectral_nodes import SpectralNodes, all_nodes, choose_nodes
from hcss_twin.scene.plan import Plan

Array = NDArray[np.float64]

FIRST_COLUMNS = 4
"""Thicknesses of each layer, from the thinnest to the thickest, on which wavenumbers are chosen first."""

TRIED_COLUMNS = 3
"""Other thicknesses of each layer, and of both, on which each choice is tried."""

MOST_TRIALS = 6
"""Choices before all wavenumbers are taken."""

_PLASTIC = 1.32471795724474602596
"""Real root of x^3 = x + 1, whose powers spread points evenly over a square (M. Roberts' R2 sequence)."""


@dataclass(frozen=True)
class Spectrum:
    """The wavenumbers behind each column of the radiance tables.

    Attributes
    ----------
    nodes : SpectralNodes
    dense : int
        Wavenumbers of the grid they were chosen from.
    estimated_error : float
        Of the total of any band, relative; twice the largest found in columns the choice did not know, 0 where
        nothing was left out.
    """

    nodes: SpectralNodes
    dense: int
    estimated_error: float


def choose_spectrum(plan: Plan, suns: Sequence[Sun | None], tolerance: float) -> Spectrum:
    """Choose weighted wavenumbers for all columns of a scene.

    Columns at the given positions of the sun, clear and with clouds from the thinnest to the thickest, are computed
    at every wavenumber of the dense grid. The choice is tried on clouds of other thickness; those that it fails are
    added to what it is made from, and it is tried again on yet others.

    Parameters
    ----------
    suns : sequence of Sun or None (S,)
        Positions that span the scene's; None where the sun is down.
    tolerance : float
        Relative to the total of each band.
    """
    grid = plan.spectral_grid
    known = np.concatenate([_spectra(plan, _first_columns(plan), sun, clear=True) for sun in suns])
    trials = _trials(plan)
    for _ in range(MOST_TRIALS):
        nodes = choose_nodes(grid, known, 0.25 * tolerance)
        if nodes.wavenumber_cm1.size == grid.wavenumber_cm1.size:
            break
        thickness = next(trials)
        if not thickness.size:
            tried = known
        else:
            tried = np.concatenate([_spectra(plan, thickness, sun, clear=False) for sun in suns])
        kept = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
        total = np.sum(tried, axis=1)
        exact = total @ grid.weights_cm1.T
        error = float(np.max(np.abs(total[:, kept] @ nodes.weights_cm1.T / exact - 1.0), initial=0.0))
        if error <= 0.5 * tolerance:
            return Spectrum(nodes, grid.wavenumber_cm1.size, 2.0 * error)
        known = np.concatenate((known, tried))
    return Spectrum(all_nodes(grid), grid.wavenumber_cm1.size, 0.0)


def _spectra(plan: Plan, thickness_m: Array, sun: Sun | None, *, clear: bool) -> Array:
    """Terms of cloudy columns (N, L), after those of the clear one if wanted: (N, K, V)."""
    wavenumber = plan.spectral_grid.wavenumber_cm1
    model = plan.model
    parts = []
    if clear:
        found = model.clear(wavenumber, sun)
        parts.append(np.stack([np.asarray(found[name]) for name in model.terms])[None])
    if thickness_m.size:
        found = model.cloudy(wavenumber, thickness_m, sun)
        parts.append(np.stack([np.asarray(found[name]) for name in model.terms], axis=1))
    return np.concatenate(parts)


def _first_columns(plan: Plan) -> Array:
    """Thicknesses (N, L): each layer alone from its thinnest to its thickest, and the corners of two."""
    share = np.linspace(0.0, 1.0, FIRST_COLUMNS)
    return _columns(plan, share, np.array([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]]))


def _trials(plan: Plan) -> Iterator[Array]:
    """Yield thicknesses (N, L) that were not there before, without end."""
    start = 1
    while True:
        number = np.arange(start, start + TRIED_COLUMNS)
        square = np.mod(0.5 + number[:, None] * _PLASTIC ** -np.array([1.0, 2.0]), 1.0)
        yield _columns(plan, square[:, 0], square)
        start += TRIED_COLUMNS


def _columns(plan: Plan, alone: Array, both: Array) -> Array:
    """Columns (N, L) from shares (N,) of the logarithmic range of each layer alone, and (M, 2) of two layers."""
    layers = [layer for layer, cloudy in enumerate(plan.cloudy_layers) if cloudy]
    rows = []
    for layer in layers:
        some = np.zeros((alone.size, len(plan.layers)))
        some[:, layer] = _thickness(plan, layer, alone)
        rows.append(some)
    if len(layers) > 1:
        rows.append(np.stack([_thickness(plan, layer, both[:, layer]) for layer in layers], axis=1))
    return np.concatenate(rows) if rows else np.empty((0, len(plan.layers)))


def _thickness(plan: Plan, layer: int, share: Array) -> Array:
    low, high = plan.layers[layer].thickness_min_m, plan.layers[layer].thickness_max_m
    result: Array = np.minimum(low * (high / low) ** share, high)
    return result
