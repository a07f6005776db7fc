"""Band radiance of pixels, finer than any cube in every numerical level, at a cost that hundreds of scenes can bear.

With L the total radiance at a level of the radiance model and in one band,

    sum over the fine grid of L(moderate) + sum over a few wavenumbers of [L(finest) - L(moderate)]

where the few wavenumbers and their weights reproduce, of the same columns, L(moderate) and its difference from a coarse
level, times polynomials of the wavenumber. Two disjoint sets of wavenumbers are used: the result is their mean, and
half their difference is the error that is stated with it.

Each layer is solved at the thicknesses of the pixels themselves and at every wavenumber, without a table; sunlight is
never too faint to be scattered at all streams; and the finest level has 32 streams for diffuse light in place of 24.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from copy import copy
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from scipy.optimize import nnls

from hcss_twin.models.radiance.physical import slab_solver
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ColumnSetting, Sun, cloudy_columns

COARSE, MODERATE = 1, 3
"""Levels whose spectra are known at every wavenumber."""

RANK = 8
"""Most patterns of the spectra that the few wavenumbers of a band reproduce, and so most wavenumbers of each set."""


def finest_radiance(
    plan: Plan, refinement: int, metres: np.ndarray, sun: Sun | None, composed: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Return the band radiance of columns (N, L) and its error by the choice of few wavenumbers, both (N, B).

    Without ``composed`` the finest level is solved at every wavenumber: slow, for comparison.
    """
    assembly = plan.assembly
    grid = assembly.refined_grid(refinement)
    wavenumber, weights = grid.wavenumber_cm1, band_weights(plan, grid, refined=True)
    last, setting = assembly.model.declares.numerical_levels - 1, assembly.setting(sun)

    def spectra(level: int, places: Any = np.s_[:]) -> np.ndarray:
        # A model of its own: those of the plan keep solved tables. Sunlight is as fine as all else.
        model: Any = copy(assembly.at_level(level).model)
        if last > 0:
            provider = model._provider
            provider = type(provider)(replace(provider._inputs, sunlight_steps=0), provider._parameters)
            model._provider = provider
            provider._numerics = replace(provider._numerics, faint_sun=0.0, between_wavenumbers=0.0)
            if level == last:
                provider._numerics = replace(provider._numerics, streams=32, turned_modes=64)
        return total_spectra(model, setting, wavenumber[places], metres)

    with solved_at_each_thickness():
        if last <= MODERATE or not composed:
            radiance = spectra(last) @ weights.T
            return radiance, np.zeros_like(radiance)
        moderate = spectra(MODERATE)
        patterns = np.concatenate((moderate, moderate - spectra(COARSE)))
        sets = [two_sets(patterns[:, own] * weights[band, own], wavenumber[own]) for band, own in enumerate(grid.nodes)]
        parts = [own[part] for own, (few, _) in zip(grid.nodes, sets, strict=True) for part in few]
        places = np.unique(np.concatenate(parts))
        finest = spectra(last, places)
    radiance = moderate @ weights.T
    change = np.zeros((2, *radiance.shape))
    for band, (own, (few, factors)) in enumerate(zip(grid.nodes, sets, strict=True)):
        for half, (part, factor) in enumerate(zip(few, factors, strict=True)):
            at = own[part]
            away = finest[:, np.searchsorted(places, at)] - moderate[:, at]
            change[half, :, band] = away @ (factor * weights[band, at])
    return radiance + change.mean(axis=0), 0.5 * np.abs(change[1] - change[0])


def band_weights(plan: Plan, grid: SpectralGrid, refined: bool) -> np.ndarray:
    """Return the weights (B, V) of trapezoids between the grid's wavenumbers within each band, times the response.

    On a refined grid those of parabolas: Richardson's extrapolation of trapezoids with every and every second one.
    """
    weights = np.zeros((len(plan.bands), grid.wavenumber_cm1.size))
    for band, own, row in zip(plan.bands, grid.nodes, weights, strict=True):
        # Nodes of other bands lie between; from one of its own to the next the integrand is straight, as documented.
        x = grid.wavenumber_cm1[own]
        if not np.allclose(1e4 / x[[-1, 0]], band.wavelength_um[[0, -1]], rtol=1e-12, atol=0.0):
            raise RuntimeError(f"{band.name}: the grid does not reach the edges of the band")
        every = _trapezoids(x)
        if refined:
            every *= 4.0 / 3.0
            every[::2] -= _trapezoids(x[::2]) / 3.0
        row[own] = every * np.interp(1e4 / x, band.wavelength_um, band.response)
    return weights


def _trapezoids(x: np.ndarray) -> np.ndarray:
    step = np.diff(x)
    return 0.5 * (np.append(step, 0.0) + np.insert(step, 0, 0.0))


def total_spectra(model: Any, setting: ColumnSetting, wavenumber: np.ndarray, metres: np.ndarray) -> np.ndarray:
    """Total radiance (N, V) of columns."""
    terms = cloudy_columns(model, setting, wavenumber, metres)
    return sum((np.asarray(term) for term in terms.values()), np.zeros((len(metres), wavenumber.size)))


def two_sets(summands: np.ndarray, wavenumber: np.ndarray) -> tuple[Sequence[np.ndarray], Sequence[np.ndarray]]:
    """Return two disjoint sets of places (P,) and factors (P,) that reproduce the sums of the summands (F, V)."""
    used = np.flatnonzero(np.any(summands != 0.0, axis=0))
    if used.size <= 2 * RANK:
        return (used, used), (np.ones(used.size),) * 2
    size = np.sum(np.abs(summands), axis=1)
    rows = summands[size > 0] / size[size > 0, None]
    place = 2.0 * (wavenumber - wavenumber[0]) / (wavenumber[-1] - wavenumber[0]) - 1.0
    rows = np.concatenate([rows * place**power for power in range(3)])
    _, strength, patterns = np.linalg.svd(rows, full_matrices=False)
    kept = min(RANK, int(np.sum(strength > 1e-10 * strength[0])))
    patterns = strength[:kept, None] / strength[0] * patterns[:kept]
    target = np.sum(patterns, axis=1)
    few, factors = [], []
    left = used
    for _ in range(2):
        factor, _ = nnls(patterns[:, left], target)
        few.append(left[factor > 0])
        factors.append(factor[factor > 0])
        left = np.setdiff1d(left, few[-1])
    return few, factors


def solved_at_each_thickness() -> AbstractContextManager[Any]:
    """Within it, layers are solved at the thicknesses of the columns themselves, however many."""
    return mock.patch.object(slab_solver, "FEW_THICKNESSES", np.inf)
