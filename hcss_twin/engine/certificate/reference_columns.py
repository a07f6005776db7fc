"""Columns of the certificate: finer than the tables in every numerical choice, and never read from them.

A solution that is finer everywhere would take minutes. Its parts are added instead: columns at every wavenumber, at a
coarse level of the radiance model; their difference from the reference level, at wavenumbers chosen for these columns;
and, at the coarsest level, the difference between the next finer spectral grid and that of the scene. The differences
are a few percent at most, so that their own errors hardly matter.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import REFERENCES, recall_or_compute
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.compile import table_key
from hcss_twin.models.radiance.reference import reference_spectra
from hcss_twin.models.radiance.spectral_grid import SpectralGrid, SpectralNodes, choose_nodes
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.numerics import reference_level, spectral_level
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun

COLUMNS_AT_ONCE = 32
"""Columns per call of the model; its memory grows with their number."""

NODES_TOLERANCE = 1e-3
"""Error of the coarse columns at the chosen wavenumbers, of their radiance.

The difference has another spectrum: from 16 to 64 streams it leaves 1.1e-4 in ``cirrus`` in 2.7-3.0 um.
"""


@dataclass(frozen=True)
class ReferenceColumns:
    """Terms (N, K, B) of columns."""

    terms: Array


class References:
    """The reference columns of one certificate, cached by the inputs of the tables, the columns and the time.

    Attributes
    ----------
    calls, solved : int
        How many sets of columns were asked for, and how many of them were solved in this run.
    """

    def __init__(self) -> None:
        self.calls, self.solved = 0, 0

    def terms(self, plan: Plan, thickness_m: Array, time_s: float) -> Array:
        """Return terms (N, K, B) of columns (N, L) at a time.

        Raises
        ------
        ProviderError
            If a provider breaks its contract.
        """
        digest = hashlib.sha256(table_key(plan).encode())
        digest.update(repr((float(time_s), thickness_m.shape)).encode())
        digest.update(np.ascontiguousarray(thickness_m).tobytes())
        self.calls += 1

        def compute() -> ReferenceColumns:
            self.solved += 1
            return ReferenceColumns(_reference_terms(plan, thickness_m, plan.sun_up_at(time_s)))

        return recall_or_compute(REFERENCES, digest.hexdigest(), plan.catalog, compute, (ReferenceColumns,)).terms

    @property
    def origin(self) -> str:
        """``solved in this run``, ``reused``, or how many of them were solved."""
        if self.solved == self.calls:
            return "solved in this run"
        return f"{self.solved} of {self.calls} solved in this run, others reused" if self.solved else "reused"


def _reference_terms(plan: Plan, thickness_m: Array, sun: Sun | None) -> Array:
    assembly, grid = plan.assembly, plan.spectral_grid
    coarse, fine = spectral_level(assembly), reference_level(assembly)
    known = reference_spectra(assembly.at_level(coarse).model, grid.wavenumber_cm1, thickness_m, sun, COLUMNS_AT_ONCE)
    terms: Array = known @ grid.weights_cm1.T
    if fine != coarse:
        nodes = choose_nodes(grid, known, NODES_TOLERANCE)
        places, change = level_change(assembly, fine, grid, nodes, known, thickness_m, sun)
        if any(spec.name.startswith(TERM_PREFIX) for spec in plan.computed):
            # What counts as direct light, and so how the total is divided into terms, depends on the streams: terms are
            # those of the scene's level, and the change of the total is shared among them in proportion.
            same = reference_spectra(assembly.model, nodes.wavenumber_cm1, thickness_m, sun, COLUMNS_AT_ONCE)
            total = np.sum(terms + change, axis=1, keepdims=True)
            terms += (same - known[..., places]) @ nodes.weights_cm1.T
            whole = np.sum(terms, axis=1, keepdims=True)
            terms *= np.divide(total, whole, out=np.ones_like(whole), where=whole > 0.0)
        else:
            terms += change
    coarsest = assembly.at_level(0).model
    first = (
        known if coarse == 0 else reference_spectra(coarsest, grid.wavenumber_cm1, thickness_m, sun, COLUMNS_AT_ONCE)
    )
    finer_grid = assembly.refined_grid(plan.grid_refinement.refinement + 1)
    new = ~np.isin(finer_grid.wavenumber_cm1, grid.wavenumber_cm1)
    between = reference_spectra(coarsest, finer_grid.wavenumber_cm1[new], thickness_m, sun, COLUMNS_AT_ONCE)
    weights = -grid.weights_cm1
    weights[:, np.isin(grid.wavenumber_cm1, finer_grid.wavenumber_cm1)] += finer_grid.weights_cm1[:, ~new]
    terms += between @ finer_grid.weights_cm1[:, new].T + first @ weights.T
    return terms


def level_change(
    assembly: Assembly,
    level: int,
    grid: SpectralGrid,
    nodes: SpectralNodes,
    known: Array,
    thickness_m: Array,
    sun: Sun | None,
) -> tuple[NDArray[np.intp], Array]:
    """Return how terms change from those of known spectra (N, K, V) to another level, from a few wavenumbers.

    Returns
    -------
    places : ndarray (M,)
        Indices of the nodes in the grid.
    change : ndarray (N, K, B)
    """
    places = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
    model = assembly.at_level(level).model
    finer = reference_spectra(model, nodes.wavenumber_cm1, thickness_m, sun, COLUMNS_AT_ONCE)
    return places, (finer - known[..., places]) @ nodes.weights_cm1.T
