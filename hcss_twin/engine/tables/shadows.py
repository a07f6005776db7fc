"""Tables of the direct sunlight that clouds transmit to the clear sea, and of what the sea reflects of it.

The direct transmission of a band is the mean of exp(-k s) over it (Bouguer's law), with the extinction k of the
optics provider and the length s of the sun's path in the cloud, thickness / mu0, weighted by the spectrum of the
clear column's solar terms. Tables contain its negative logarithm, the effective optical thickness as a function of s:
a straight line for grey clouds, otherwise a curve between the lines of the largest and smallest k.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import TOTAL
from hcss_twin.engine.tables.radiance_tables import Quantities, ShadowTables
from hcss_twin.plan.hanging_levels import spanning
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms

FIRST_INTERVALS = 16


def compile_shadows(plan: Plan, quantities: Quantities, time_s: Sequence[float], clear: Array) -> ShadowTables:
    """Compute the shadow tables at the time nodes of the radiance tables.

    Parameters
    ----------
    clear : ndarray (T, K, B)
        Terms of the clear column as in the radiance tables.
    """
    names = sea_sun_terms(plan.assembly.model)
    suns = [plan.sun_at(time) for time in time_s]
    loss = np.stack([_loss(terms, quantities, names) for terms in clear])
    wavenumber, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1
    spectra = [
        weights * np.sum([np.asarray(terms[name]) for name in names], axis=0)
        for terms in (plan.assembly.clear(wavenumber, sun) for sun in suns)
    ]
    # Without sunlight there are no weights, and no loss.
    spectra = [
        np.where(np.sum(spectrum, axis=1, keepdims=True) > 0.0, spectrum, np.abs(weights)) for spectrum in spectra
    ]
    extinction = [
        plan.assembly.optics.single_scattering(layer.microphysics, wavenumber).extinction_m1 for layer in plan.layers
    ]
    mu0 = math.cos(math.radians(float(np.max(plan.assembly.slant.sun_zenith_deg))))
    # Where tops vary, a path may cross several columns.
    spans = map(spanning, plan.layers, plan.assembly.generators)
    longest = np.array([span.thickness_max_m / mu0 for span in spans])

    def depth(part: Array) -> Array:
        """Effective optical thickness (T, L, N, B) at parts (N,) of the longest paths."""
        return np.array(
            [
                [
                    np.stack([_depth(k, band_spectrum, part * length) for band_spectrum in spectrum], axis=1)
                    for k, length in zip(extinction, longest, strict=True)
                ]
                for spectrum in spectra
            ]
        )

    return ShadowTables(tuple(time_s), longest, loss, _tabulated(depth, plan.budget.shadows))


def _loss(terms: Array, quantities: Quantities, names: Sequence[str]) -> Array:
    """Sea-reflected direct sunlight in each quantity of the clear column (Q, B), from its terms (K, B)."""
    places = {name: quantities.terms.index(name) for name in names}
    nothing = np.zeros(terms.shape[1])
    return np.stack(
        [
            np.sum([terms[index] for index in places.values()], axis=0)
            if name == TOTAL
            else terms[places[name]]
            if name in places
            else nothing
            for name in quantities.names
        ]
    )


def _depth(extinction_m1: Array, weights: Array, path_m: Array) -> Array:
    """Negative logarithm (N,) of the weighted mean of exp(-k s) over the wavenumbers (V,)."""
    from scipy.special import logsumexp  # takes 0.1 s to import

    seen = weights > 0.0
    k, w = extinction_m1[seen], weights[seen]
    least = float(np.min(k))
    # Relative to the smallest extinction, to avoid underflow behind the thickest cloud.
    excess = logsumexp(-(k - least) * path_m[:, None], b=w / np.sum(w), axis=1)
    result: Array = least * path_m - excess
    return result


def _tabulated(depth: Callable[[Array], Array], tolerance: float) -> Array:
    """Halve the intervals of a table over [0, 1], uniform in the root, until its transmission is linear enough."""
    intervals = FIRST_INTERVALS
    table = depth(np.linspace(0.0, 1.0, intervals + 1) ** 2)
    while True:
        finer = depth(np.linspace(0.0, 1.0, 2 * intervals + 1) ** 2)
        # The middle of an interval in the root is not the middle in the square.
        low, high = np.arange(intervals) ** 2.0, np.arange(1, intervals + 1) ** 2.0
        share = (((np.arange(intervals) + 0.5) ** 2 - low) / (high - low))[:, None]
        guess = (1.0 - share) * table[..., :-1, :] + share * table[..., 1:, :]
        error = np.max(np.abs(np.exp(-guess) - np.exp(-finer[..., 1::2, :])))
        table, intervals = finer, 2 * intervals
        if not error > tolerance:
            return table
