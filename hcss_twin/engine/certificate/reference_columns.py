"""Columns of the certificate: finer than the tables in every numerical choice, and never read from them.

A solution that is finer everywhere would take minutes. Its parts are added instead: columns at every wavenumber, at a
coarse level of the radiance model; their difference from the reference level, at wavenumbers chosen for these columns;
and, at the coarsest level, the difference between the next finer spectral grid and that of the scene. The differences
are a few percent at most, so that their own errors hardly matter.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import REFERENCES, recall_or_compute
from hcss_twin.core.error_norm import largest_error
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.engine.certificate.reference_curve import ReferenceCurve, reference_curve
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.models.radiance.spectral_grid import SpectralGrid, SpectralNodes
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.numerics import for_spectra, reference_level
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import ColumnStates, Sun, View
from hcss_twin.scenario.scenario import Scenario

NODES_TOLERANCE = 1e-3
"""Error of the coarse columns at the chosen wavenumbers, of their radiance.

The difference has another spectrum: from 16 to 64 streams it leaves 1.1e-4 in ``cirrus`` in 2.7-3.0 um.
"""

AFRESH_NODES_TOLERANCE = 1e-5
"""The same for a few columns, which choose wavenumbers less well than many: with 1e-4, four columns of ``stratus``
differ by 2e-4 in 2.7-3.0 um from what all 15 of a certificate give, with 1e-5 by 2e-5 to 4e-5."""

SOLVED_AFRESH = 10
"""One in so many points of a sweep, on average, solves columns of its certificate afresh."""

AFRESH_COLUMNS = 4
"""Columns at each time that such a point solves where no curve says which wavenumbers suffice for all."""

CLOUDS_ON_FINER_GRID = 5
"""Clouds of one layer that are computed on the next finer spectral grid."""

CURVE_SHARE = 0.01
"""Largest error of a curve of reference columns, as a share of the accuracy: of those in the states of the texture,
whose differences alone are used, relative to the radiance of each state."""

Suns = Sequence[Sun | None]
Views = Sequence[View]
Nodes = float | SpectralNodes
"""Wavenumbers at which levels are compared, or the tolerance to which they are chosen."""


def columns_afresh(scenario: Scenario) -> int:
    """Return how many columns the certificate of a scene of a sweep solves although others know them; mostly 0.

    Where a curve says which wavenumbers suffice, it solves all.

    The choice depends on the scenario only, so that cubes do not depend on workers, interruptions or kept results.
    """
    drawn = int.from_bytes(hashlib.sha256(scenario.to_json().encode()).digest()[:8], "big") % SOLVED_AFRESH == 0
    return AFRESH_COLUMNS if drawn else 0


@dataclass(frozen=True)
class ReferenceColumns:
    """Terms (N, K, B) of columns, changes of them, or (N, S, K, B) in the states of an expansion."""

    terms: Array


@dataclass(frozen=True)
class KeptCurve:
    """Curve of one layer, None if the columns do not lie on a smooth one, and the wavenumbers of its level change.

    Columns of the curve are (N, 1 + S, K, B): those of the scene, then those in the states of its texture.
    """

    curve: ReferenceCurve | None
    nodes: SpectralNodes


class References:
    """The reference columns of one certificate, cached by the inputs of the tables, the columns and the time.

    Parameters
    ----------
    from_curves : bool
        Whether columns with cloud in one layer are read from a curve through reference columns, which all scenes of a
        sweep share that differ in their clouds only.
    afresh : int
        Number of columns under each sun that are solved although they lie on curves.

    Attributes
    ----------
    calls, solved : int
        How many sets of columns were asked for, and how many of them were solved in this run.
    read, curve_columns : int
        Number of columns read from curves, and of the columns behind these curves.
    curve_error : float
        Largest error of the curves, relative to the total.
    checked, check_error : int, float
        Number of columns solved although others know them, and their largest difference from these, as above.
    """

    def __init__(self, from_curves: bool = False, afresh: int = 0) -> None:
        self.from_curves, self.afresh = from_curves, afresh
        self.calls, self.solved = 0, 0
        self.read, self.curve_columns, self.curve_error = 0, 0, 0.0
        self.checked, self.check_error = 0, 0.0
        self._spectra: dict[bytes, Array] = {}

    def terms(self, plan: Plan, thickness_m: Array, suns: Suns, views: Views = ()) -> Array:
        """Return terms (N, K, B) of columns (N, L) under N suns, if given toward N views.

        Raises
        ------
        ProviderError
            If a provider breaks its contract.
        """
        result, (drawn, nodes) = self._shared(plan, thickness_m, suns, views), self._drawn(plan, thickness_m, suns)
        self.checked += drawn.size

        def exact(some: Array, suns: Suns, views: Views) -> Array:
            return self._columns(plan, some, suns, views, nodes or AFRESH_NODES_TOLERANCE)

        return self._with_afresh(result, drawn, exact, thickness_m, suns, views)

    def perturbed(self, plan: Plan, thickness_m: Array, suns: Suns, views: Views = ()) -> Array:
        """Return terms (S, N, K, B) of columns (N, L) at :attr:`hcss_twin.plan.texture.Texture.expansion_states`.

        They are of a coarse level of the radiance model: only their differences, a percent of the radiance, are used.
        """
        result, (drawn, _) = self._shared(plan, thickness_m, suns, views, True), self._drawn(plan, thickness_m, suns)
        exact = partial(self._states, plan)
        return np.moveaxis(self._with_afresh(result, drawn, exact, thickness_m, suns, views), 1, 0)

    def _drawn(self, plan: Plan, thickness_m: Array, suns: Suns) -> tuple[NDArray[np.intp], SpectralNodes | None]:
        """Return the rows of columns that are solved although others know them, and their wavenumbers on a curve."""
        cloudy = np.flatnonzero(np.any(thickness_m, axis=1))
        if self.afresh == 0 or not cloudy.size:
            return cloudy[:0], None
        seed = int.from_bytes(hashlib.sha256(thickness_m.tobytes()).digest()[:8], "big")
        layers = np.flatnonzero(np.any(thickness_m, axis=0))
        on_curve = self.from_curves and layers.size == 1 and len(set(suns)) == 1
        nodes = self._kept(plan, int(layers[0]), suns[0]).nodes if on_curve else None
        afresh = cloudy.size if nodes is not None else min(self.afresh * len(set(suns)), cloudy.size)
        return np.sort(np.random.default_rng(seed).choice(cloudy, afresh, replace=False)), nodes

    def _with_afresh(
        self,
        result: Array,
        drawn: NDArray[np.intp],
        solve: Callable[[Array, Suns, Views], Array],
        thickness_m: Array,
        suns: Suns,
        views: Views,
    ) -> Array:
        """Return columns (N, ..., K, B) with the drawn ones solved."""
        if drawn.size:
            of_drawn = [suns[row] for row in drawn.tolist()], [views[row] for row in drawn.tolist()] if views else ()
            known, result[drawn] = result[drawn], solve(thickness_m[drawn], *of_drawn)
            away = largest_error(np.sum(known, axis=-2), np.sum(result[drawn], axis=-2))
            self.check_error = max(self.check_error, away)
        return result

    def _shared(self, plan: Plan, thickness_m: Array, suns: Suns, views: Views, in_states: bool = False) -> Array:
        """Return columns (N, K, B), or (N, S, K, B) in the texture's states, whatever of them other scenes know."""
        solved, parts = np.ones(thickness_m.shape[0], dtype=np.bool_), list[tuple[NDArray[np.bool_], Array]]()
        clouds = np.count_nonzero(thickness_m, axis=1)
        for index, sun in product(range(len(plan.layers)), dict.fromkeys(suns)) if self.from_curves else ():
            under = np.array([lit == sun for lit in suns], dtype=np.bool_)
            alone = (clouds == 1) & (thickness_m[:, index] > 0.0) & under
            curve = self._kept(plan, index, sun).curve if np.any(alone) else None
            if curve is None:
                continue
            levels = plan.assembly.profile.altitude_m
            columns = curve.terms(plan.layers[index], levels, thickness_m[alone, index])
            parts.append((alone, columns[:, 1:] if in_states else columns[:, 0]))
            solved &= ~alone
            self.curve_error = max(self.curve_error, curve.error)
            if not in_states:
                self.read += int(np.count_nonzero(alone))
                self.curve_columns += curve.columns
        if np.any(solved) or not parts:
            rows = np.flatnonzero(solved).tolist()
            of_rows = [suns[row] for row in rows], [views[row] for row in rows] if views else ()
            solve = self._states if in_states else self._columns
            parts.append((solved, solve(plan, thickness_m[solved], *of_rows)))
        result = np.empty((solved.size, *parts[-1][1].shape[1:]))
        for rows_of, values in parts:
            result[rows_of] = values
        return result

    def _kept(self, plan: Plan, index: int, sun: Sun | None) -> KeptCurve:
        chosen: list[SpectralNodes] = []

        def columns(thickness_m: Array) -> Array:
            every = np.zeros((thickness_m.size, len(plan.layers)))
            every[:, index] = thickness_m
            suns = [sun] * len(every)
            terms, nodes, spectra = _reference_terms(plan, every, suns, (), NODES_TOLERANCE)
            chosen.append(nodes)
            if not plan.texture.expansion_states:
                return terms[:, None]
            states = _perturbed_terms(plan, every, suns, (), spectra)
            return np.concatenate((terms[:, None], np.moveaxis(states, 0, 1)), axis=1)

        def compute() -> KeptCurve:
            self.solved += 1
            levels, allowed = plan.assembly.profile.altitude_m, CURVE_SHARE * plan.accuracy.relative
            curve = reference_curve(columns, plan.layers[index], levels, allowed)
            return KeptCurve(curve, chosen[-1])

        self.calls += 1
        key = hashlib.sha256(f"curve {table_key(plan)} {index} {sun!r}".encode()).hexdigest()
        return recall_or_compute(REFERENCES, key, plan.catalog, compute, (KeptCurve, ReferenceCurve, SpectralNodes))

    def _columns(
        self, plan: Plan, thickness_m: Array, suns: Suns, views: Views = (), wavenumbers: Nodes = NODES_TOLERANCE
    ) -> Array:
        same = "curve" if isinstance(wavenumbers, SpectralNodes) else wavenumbers

        def compute() -> Array:
            terms, _, spectra = _reference_terms(plan, thickness_m, suns, views, wavenumbers)
            self._spectra = {_digest(plan, thickness_m, suns, views): spectra}
            return terms

        return self.recalled(plan, compute, thickness_m, suns, views, same)

    def _states(self, plan: Plan, thickness_m: Array, suns: Suns, views: Views = ()) -> Array:
        """Return terms (N, S, K, B) in the states of the texture, from spectra of this run where it solved them."""

        def compute() -> Array:
            known = self._spectra.get(_digest(plan, thickness_m, suns, views))
            return np.moveaxis(_perturbed_terms(plan, thickness_m, suns, views, known), 0, 1)

        return self.recalled(plan, compute, thickness_m, suns, views, "texture")

    def recalled(
        self, plan: Plan, compute: Callable[[], Array], values: Array, suns: Suns, views: Views, *more: object
    ) -> Array:
        """Return terms from the cache, or computed: those of values (N, ...) under N suns, toward N views."""

        def counted() -> Array:
            self.solved += 1
            return compute()

        self.calls += 1
        return self.shared(plan, counted, values, suns, views, *more)

    def shared(
        self, plan: Plan, compute: Callable[[], Array], values: Array, suns: Suns, views: Views, *more: object
    ) -> Array:
        """Return terms as :meth:`recalled` does, of columns that belong to no certificate: they are not counted."""
        digest = _digest(plan, values, suns, views, *more).hex()

        def solved() -> ReferenceColumns:
            return ReferenceColumns(compute())

        return recall_or_compute(REFERENCES, digest, plan.catalog, solved, (ReferenceColumns,)).terms

    @property
    def interpolation(self) -> str:
        """What was interpolated between reference columns; empty if nothing was."""
        read = (
            f"the reference of {self.read} columns is interpolated between {self.curve_columns} reference columns, "
            f"with an error of {self.curve_error:.1g} at those between the nodes"
        )
        checked = (
            f"{self.checked} of the columns are solved afresh, which changes them by at most {self.check_error:.1g}"
        )
        return "; ".join(text for text, count in ((read, self.read), (checked, self.checked)) if count)

    @property
    def origin(self) -> str:
        """``solved in this run``, ``reused``, or how many of them were solved."""
        if self.solved == self.calls:
            return "solved in this run"
        return f"{self.solved} of {self.calls} solved in this run, others reused" if self.solved else "reused"


def _digest(plan: Plan, values: Array, suns: Suns, views: Views, *more: object) -> bytes:
    """Return a hash of everything that columns depend on."""
    digest = hashlib.sha256(table_key(plan).encode())
    digest.update(repr((values.shape, *suns, *views, *more)).encode())
    digest.update(np.ascontiguousarray(values).tobytes())
    return digest.digest()


def _spectra(assembly: Assembly, wavenumber_cm1: Array, thickness_m: Array, suns: Suns, views: Views) -> Array:
    """Return terms (N, K, V) of columns (N, L) under N suns, if given toward N views, all in one call."""
    result = np.empty((thickness_m.shape[0], len(assembly.model.terms), wavenumber_cm1.size))
    if not result.size:  # a finer grid of narrow bands may have no new wavenumbers
        return result
    of_rows = [assembly.setting(*row) for row in zip(suns, views or [assembly.view] * len(suns), strict=True)]
    terms = assembly.model.columns(ColumnStates.of(of_rows, thickness_m), wavenumber_cm1)
    for index, name in enumerate(assembly.model.terms):
        result[:, index] = terms[name]
    return result


def _reference_terms(
    plan: Plan, thickness_m: Array, suns: Suns, views: Views, wavenumbers: Nodes
) -> tuple[Array, SpectralNodes, Array]:
    """Return terms (N, K, B), the wavenumbers at which levels are compared, and spectra (N, K, V) of few streams."""
    assembly, grid = plan.assembly, plan.spectral_grid
    few, fine = for_spectra(assembly), reference_level(assembly)
    coarse, coarsest = few.numerical_level, few.at_level(0)
    known = _spectra(few, grid.wavenumber_cm1, thickness_m, suns, views)
    terms: Array = known @ grid.weights_cm1.T
    nodes = wavenumbers if isinstance(wavenumbers, SpectralNodes) else grid.all_nodes()
    if fine != coarse:
        if not isinstance(wavenumbers, SpectralNodes):
            nodes = grid.choose_nodes(known, wavenumbers)
        places, change = level_change(assembly, fine, grid, nodes, known, thickness_m, suns, views)
        if any(spec.name.startswith(TERM_PREFIX) for spec in plan.computed):
            # What counts as direct light, and so how the total is divided into terms, depends on the streams: terms are
            # those of the scene's level, and the change of the total is shared among them in proportion.
            same = _spectra(assembly, nodes.wavenumber_cm1, thickness_m, suns, views)
            total = np.sum(terms + change, axis=1, keepdims=True)
            terms += (same - known[..., places]) @ nodes.weights_cm1.T
            whole = np.sum(terms, axis=1, keepdims=True)
            terms *= np.divide(total, whole, out=np.ones_like(whole), where=whole > 0.0)
        else:
            terms += change
    of_coarsest = known if coarse == 0 else None
    return terms + _grid_change(plan, coarsest, thickness_m, suns, views, of_coarsest, terms), nodes, known


def _grid_change(
    plan: Plan, coarse: Assembly, thickness_m: Array, suns: Suns, views: Views, known: Array | None, terms: Array
) -> Array:
    """Return how terms (N, K, B) change on the next finer spectral grid.

    The share of the total that changes is smooth in thickness: of many clouds of one layer, it is computed for a few
    from the thinnest to the thickest, and interpolated in ln(thickness).

    Parameters
    ----------
    known : ndarray (N, K, V), optional
        Spectra of the columns on the grid of the scene, if they are of this level.
    """
    grid, finer = plan.spectral_grid, plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)
    every = np.arange(thickness_m.shape[0]), np.eye(thickness_m.shape[0])
    some, shares = every if views else _few_clouds(thickness_m, suns)
    settings = [suns[row] for row in some], [views[row] for row in some] if views else ()
    if known is None:
        known = np.empty((thickness_m.shape[0], terms.shape[1], grid.wavenumber_cm1.size))
        known[some] = _spectra(coarse, grid.wavenumber_cm1, thickness_m[some], *settings)
    new = ~np.isin(finer.wavenumber_cm1, grid.wavenumber_cm1)
    weights, share = -grid.weights_cm1, finer.weights_cm1 * new
    weights[:, np.isin(grid.wavenumber_cm1, finer.wavenumber_cm1)] += finer.weights_cm1[:, ~new]
    new |= np.isin(finer.wavenumber_cm1, finer.ends_cm1)
    between = _spectra(coarse, finer.wavenumber_cm1[new], thickness_m[some], *settings)
    change = between @ share[:, new].T + known[some] @ weights.T
    total = np.sum(terms, axis=1, keepdims=True)
    relative = np.divide(change, total[some], out=np.zeros_like(change), where=total[some] > 0.0)
    result: Array = np.tensordot(shares, relative, axes=1) * total
    return result


def _few_clouds(thickness_m: Array, suns: Suns) -> tuple[NDArray[np.intp], Array]:
    """Return rows (S,) of columns (N, L) that represent the others, and the weights (N, S) that interpolate them.

    These are all columns, but of clouds of one layer alone under one sun only a few, evenly spaced in ln(thickness).
    """
    weights, kept = np.eye(thickness_m.shape[0]), np.ones(thickness_m.shape[0], dtype=np.bool_)
    alone = np.count_nonzero(thickness_m, axis=1) == 1
    of_sun = np.array([list(dict.fromkeys(suns)).index(sun) for sun in suns])
    for number, thickness in product(range(len(set(suns))), thickness_m.T):
        rows = np.flatnonzero(alone & (thickness > 0.0) & (of_sun == number))
        rows = rows[np.argsort(thickness[rows])]
        if rows.size <= CLOUDS_ON_FINER_GRID:
            continue
        ln_thickness = np.log(thickness, where=thickness > 0.0, out=np.zeros_like(thickness))
        wanted = np.linspace(ln_thickness[rows[0]], ln_thickness[rows[-1]], CLOUDS_ON_FINER_GRID)
        nodes = rows[np.unique(np.argmin(np.abs(ln_thickness[rows] - wanted[:, None]), axis=1))]
        kept[rows], kept[nodes] = False, True
        weights[rows] = 0.0
        for index, node in enumerate(nodes):
            weights[rows, node] = np.interp(ln_thickness[rows], ln_thickness[nodes], np.eye(nodes.size)[index])
    return np.flatnonzero(kept), weights[:, kept]


def _perturbed_terms(plan: Plan, thickness_m: Array, suns: Suns, views: Views, known: Array | None) -> Array:
    """Return terms (S, N, K, B) in the states of the texture, from spectra (N, K, V) of the scene if they are known."""
    from hcss_twin.plan.texture import sea_factors  # not for scenes without texture

    texture, grid, few = plan.texture, plan.spectral_grid, for_spectra(plan.assembly)
    derived = texture.water_vapour == 0.0 and texture.sea_is_proportional(few)
    known, terms = known if derived else None, dict[tuple[float, float], Array]()
    for state in dict.fromkeys(map(texture.without_flat, texture.expansion_states)):  # that of the scene first
        scene = texture.perturbed(few, state) if any(state) else few
        if known is None:
            spectra = _spectra(scene, grid.wavenumber_cm1, thickness_m, suns, views)
            known = spectra if derived else None
        else:
            factors = {sun: sea_factors(few, scene, grid.wavenumber_cm1, sun) for sun in dict.fromkeys(suns)}
            spectra = known * np.stack([factors[sun] for sun in suns])
        terms[state] = spectra @ grid.weights_cm1.T
    return np.stack([terms[texture.without_flat(state)] for state in texture.expansion_states])


def level_change(
    assembly: Assembly,
    level: int,
    grid: SpectralGrid,
    nodes: SpectralNodes,
    known: Array,
    thickness_m: Array,
    suns: Suns,
    views: Views = (),
) -> tuple[NDArray[np.intp], Array]:
    """Return how terms change from those of known spectra (N, K, V) to another level, from a few wavenumbers.

    Returns
    -------
    places : ndarray (M,)
        Indices of the nodes in the grid.
    change : ndarray (N, K, B)
    """
    places = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
    finer = _spectra(assembly.at_level(level), nodes.wavenumber_cm1, thickness_m, suns, views)
    return places, (finer - known[..., places]) @ nodes.weights_cm1.T
