"""The numerical level of the radiance model and the spectral grid, chosen by the error of a few columns.

The error of a level is estimated as 1.5 times its difference from the next one, which has 1.3 to 1.5 times as many
streams. Two levels may agree by chance (for 500 m of cloud at 1.8 um, 6 and 8 streams are both 1.3 % off), so the
estimate is at least a sixteenth of the difference between the previous and the next level, and where errors seem to
fall too fast the second next level is asked, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from math import floor, log2

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import SAFETY_FACTOR, FewColumns, few_columns
from hcss_twin.providers import CloudLayer, Sun, View

PER_BAND = 3
"""Number of wavenumbers per band."""

FASTEST_CONVERGENCE = 16.0
"""Largest factor by which the error is assumed to fall from one level to the next."""

SUSPICIOUS_CONVERGENCE = 8.0
"""Factor between the changes to a level from the previous but one and from the previous, beyond which chance is likely;
2 to 6 are usual."""

SPECTRAL_LEVELS = 3
"""Levels from that of the spectra at all wavenumbers to that of the tables."""

FIRST_LEVELS = ((1e-2, 0), (1e-3, 1), (1e-4, 3), (0.0, 4))
"""Where the search starts, for tolerances above each limit: coarser ones may agree with the next by chance.

Most scenes end at the third or beyond: each level that the search passes costs two solutions.
"""

FIRST_OF_SIMPLE = ((1e-4, 0), (0.0, 4))
"""The same for clear sky, and for one layer at night: sunlight and light between clouds may agree by chance."""

FEW_STREAMS = 1
"""Level at which the search for all but sunlight starts by day."""

MANY_STREAMS = 4
"""Level of sunlight from which on columns with few streams pay."""

SUNLIGHT_STEPS = 3
"""How many levels finer sunlight is where its error toward some view is too large; fewer hardly help at rainbows."""

FINEST_GRID = 3
"""Finest grid of a scene; the next one is a reference only."""

NARROW_BAND = 100
"""Bands with fewer wavenumbers than this are narrow."""

COARSE_GRID_TOLERANCE = 5e-4
"""Coarser grids are tried for larger tolerances only."""


@dataclass(frozen=True)
class NumericalLevel:
    """Level of the radiance model.

    Attributes
    ----------
    level : int
        From 0, the coarsest.
    error : float
        Largest relative difference of a few columns from the reference level in any band; 0 without other levels.
    enough : bool
        Whether the error is within the tolerance; no finer level exists otherwise.
    sunlight_steps : int
        How many levels finer sunlight that clouds scatter toward the sensor is.
    """

    level: int
    error: float
    enough: bool
    sunlight_steps: int = 0


def finest(levels: Sequence[NumericalLevel]) -> NumericalLevel:
    """Return a level that is as fine as each of several."""
    level, sunlight = (
        max(chosen.level for chosen in levels),
        max(chosen.level + chosen.sunlight_steps for chosen in levels),
    )
    return NumericalLevel(
        level, max(chosen.error for chosen in levels), all(chosen.enough for chosen in levels), sunlight - level
    )


def reference_level(assembly: Assembly) -> int:
    """Return the level against which that of a scene is verified."""
    return min(assembly.numerical_level + 1, assembly.model.declares.numerical_levels - 1)


def for_spectra(assembly: Assembly) -> Assembly:
    """Return the scene at the level for spectra at all wavenumbers, whose shapes hardly depend on it."""
    sizes = assembly.numerical_level, assembly.numerical_level + assembly.sunlight_steps
    level, sunlight = (max(size - SPECTRAL_LEVELS, 0) for size in sizes)
    return assembly.at_level(level).with_finer_sunlight(sunlight - level)


def choose_level(assembly: Assembly, suns: Sequence[Sun | None], tolerance: float) -> NumericalLevel:
    """Return the coarsest level whose few columns are within the tolerance of finer ones.

    By day, sharply peaked phase functions need many streams for sunlight toward the sensor, which is solved apart. All
    else starts with few, and has more where that alone changes the columns by more than the tolerance. Where no level
    meets it, the one with the least error is chosen.

    Parameters
    ----------
    suns : sequence of Sun or None
        Positions that bound the frames.
    tolerance : float
        Of the total radiance of each band, relative.
    """
    count = assembly.model.declares.numerical_levels
    if count == 1 or not suns:
        return NumericalLevel(0, 0.0, True)
    last = max(count - 2, 0)
    columns = _columns(assembly)

    @cache
    def at(level: int, sunlight: int) -> list[Array]:
        scene = assembly.at_level(level).with_finer_sunlight(sunlight - level)
        return columns.totals_in(scene.model, [scene.setting(sun) for sun in dict.fromkeys(suns)])

    def change(one: tuple[int, int], other: tuple[int, int]) -> float:
        return SAFETY_FACTOR * max(largest_error(a, b) for a, b in zip(at(*one), at(*other), strict=True))

    @cache
    def error(level: int, sunlight: int) -> float:
        sizes = {step: (level + step, sunlight + step) for step in (COARSER, HERE, FINER)}
        sizes[SECOND] = level + 1, sunlight + 2

        def between(one: int, other: int) -> Array:
            return np.array([change(sizes[one], sizes[other])])

        return float(_estimate(between, tolerance, min(sizes[COARSER]) >= 0, any(suns) and sunlight < last)[0])

    def error_but_of_sunlight(level: int, sunlight: int) -> float:
        # By columns that are needed for the next error, too: this one hardly depends on the level of sunlight.
        next_change = change((level, sunlight + 1), (level + 1, sunlight + 1))
        if next_change > tolerance or level == 0:
            return next_change
        return max(next_change, change((level - 1, sunlight), (level, sunlight)) / FASTEST_CONVERGENCE)

    firsts = FIRST_LEVELS if assembly.has_cloud and (any(suns) or len(assembly.layers) > 1) else FIRST_OF_SIMPLE
    sunlight = min(next(level for limit, level in firsts if tolerance > limit), last)
    level = min(FEW_STREAMS, sunlight) if any(suns) else sunlight
    tried, coarsest, finest = [(level, sunlight)], (0, 0), (level + 1, sunlight + 1)
    if sunlight == 1 and change(coarsest, finest) <= tolerance:  # the coarsest agrees with the second next finer one
        return NumericalLevel(0, change(coarsest, finest), True)
    while error(level, sunlight) > tolerance:
        if level < sunlight and error_but_of_sunlight(level, sunlight) > tolerance:
            level += 1
        elif sunlight < last:
            level, sunlight = (level if any(suns) else level + 1), sunlight + 1
        else:
            break
        tried.append((level, sunlight))
    finest, coarser = (level + 1, sunlight + 1), (min(level, sunlight - 1), sunlight - 1)
    while len(tried) == 1 and coarser[1] >= 0 and change(coarser, finest) <= tolerance:
        if error(*coarser) > tolerance:
            break
        (level, sunlight), coarser = coarser, (min(level, coarser[1] - 1), coarser[1] - 1)
    enough = error(level, sunlight) <= tolerance
    if not enough:
        level, sunlight = min(tried, key=lambda sizes: error(*sizes))
    return NumericalLevel(level, error(level, sunlight), enough, sunlight - level)


def refine_toward(
    assembly: Assembly, chosen: NumericalLevel, views: Sequence[View], suns: Sequence[Sun | None], tolerance: float
) -> NumericalLevel:
    """Return a level, chosen toward the image centre, that is fine enough toward other views.

    The error of sunlight oscillates with the scattering angle: toward the image centre it may vanish by chance.
    Sunlight alone is made finer first, because many views share its solution.
    """
    last = assembly.model.declares.numerical_levels - 2
    if last < 0 or not suns or not chosen.enough:
        return chosen
    columns, worst, error = _columns(assembly), list(views[:1]), chosen.error
    sunlight = chosen.level + chosen.sunlight_steps

    def errors_toward(views: Sequence[View], level: int, steps: int) -> Array:
        sizes = {COARSER: (level - 1, steps), HERE: (level, steps), FINER: (level + 1, steps)}
        sizes[SECOND] = level + 1, steps + 1

        @cache
        def at(step: int) -> list[Array]:
            level, finer_sunlight = sizes[step]
            of_views = columns.toward(assembly.with_finer_sunlight(finer_sunlight).at_level(level), views, suns)
            return [np.concatenate([sum(terms.values()) for terms in of_view]) for of_view in of_views]

        def between(one: int, other: int) -> Array:
            changes = [largest_error(*of_view) for of_view in zip(at(one), at(other), strict=True)]
            return SAFETY_FACTOR * np.array(changes)

        return _estimate(between, tolerance, level > 0, any(suns) and level + steps < last)

    for level, more in product(range(chosen.level, last + 1), (0, SUNLIGHT_STEPS) if any(suns) else (0,)):
        steps = max(sunlight - level, 0) + more
        # The view that failed last is tried first, alone.
        for tried in (worst, views):
            errors = errors_toward(tried, level, steps)
            if np.max(errors) > tolerance:
                error, worst = float(np.max(errors)), [tried[int(np.argmax(errors))]]
                break
        else:
            return NumericalLevel(level, max(float(np.max(errors)), chosen.error), True, steps)
    return NumericalLevel(last, error, False)


COARSER, HERE, FINER, SECOND = -1, 0, 1, 2
"""A level, its neighbours, and the finer one with sunlight of the second next."""


def _estimate(change: Callable[[int, int], Array], tolerance: float, has_coarser: bool, has_second: bool) -> Array:
    """Return the estimated error of a level toward each of several views.

    Parameters
    ----------
    change : callable
        Change of the columns toward each view, with its safety factor, from one of ``COARSER``, ``HERE``, ``FINER`` and
        ``SECOND`` to another.
    tolerance : float
        Estimates beyond it are lower limits: finer levels could only add to them.
    has_coarser, has_second : bool
        Whether the coarser level exists, and the second next of sunlight.
    """
    next_change = change(HERE, FINER)
    if not has_coarser or np.max(next_change) > tolerance:
        return next_change
    before = change(COARSER, FINER)
    found: Array = np.maximum(next_change, before / FASTEST_CONVERGENCE)
    suspicious = before > np.maximum(tolerance, SUSPICIOUS_CONVERGENCE * next_change)
    if has_second and np.max(found) <= tolerance and np.any(suspicious):
        found = np.where(suspicious, np.maximum(found, change(HERE, SECOND)), found)
    return found


@dataclass(frozen=True)
class GridRefinement:
    """Refinement of the spectral grid, as of ``SpectralGrid.dense``.

    Attributes
    ----------
    refinement : int
    error : float
        Largest relative difference of a few columns from the next finer grid, in any band.
    """

    refinement: int
    error: float


def choose_refinement(assembly: Assembly, suns: Sequence[Sun | None], tolerance: float) -> GridRefinement:
    """Return the coarsest spectral grid whose columns are within the tolerance of the next finer one.

    The test columns are clear sky, where there is any, and the thickest cloud of each layer, at the coarsest numerical
    level: above high clouds, lines are as strong as the window is dark. In narrow bands they include clouds of medium
    thickness: variations of the optical properties of particles with wavenumber average out over wide bands only.
    """
    if not suns:
        return GridRefinement(0, 0.0)
    none, narrow = np.zeros(0), np.array([len(node) < NARROW_BAND for node in assembly.spectral_grid.nodes])
    columns = FewColumns(none, none, assembly.extreme_thicknesses_m, assembly.has_clear_sky)
    columns = columns.only(columns.ends)
    bounding = int(columns.clear) + len(columns.thickness_m)
    if np.any(narrow):
        columns = replace(columns, thickness_m=np.concatenate((columns.thickness_m, _medium_clouds(assembly))))
    spectra = _spectra(columns, assembly.at_level(0), suns[0])

    @cache
    def at(refinement: int) -> Array:
        grid = assembly.refined_grid(refinement)
        total: Array = spectra(grid.wavenumber_cm1, grid.ends_cm1) @ grid.weights_cm1.T
        total[bounding:, ~narrow] = 1.0
        return total

    def error(refinement: int) -> float:
        return largest_error(at(refinement), at(refinement + 1))

    at(0)  # whose wavenumbers include those of the coarser grid
    refinement = -1 if tolerance > COARSE_GRID_TOLERANCE else 0
    while error(refinement) > tolerance and refinement < FINEST_GRID:
        refinement += 1
    return GridRefinement(refinement, error(refinement))


def _spectra(columns: FewColumns, scene: Assembly, sun: Sun | None) -> Callable[[Array, Array], Array]:
    """Return a function from wavenumbers (V,) to the radiance (C, V) of columns, which solves each wavenumber once.

    Its second argument are the ends of bands among them: models that interpolate in a band need both.
    """
    known: dict[float, Array] = {}

    def at(wavenumber_cm1: Array, ends_cm1: Array) -> Array:
        new = np.array([wavenumber for wavenumber in wavenumber_cm1.tolist() if wavenumber not in known])
        if new.size:
            new = np.union1d(new, ends_cm1)
            new_columns = replace(columns, wavenumber_cm1=new, weights_cm1=np.eye(new.size))
            known.update(zip(new.tolist(), new_columns.total(scene, sun).T, strict=True))
        return np.stack([known[wavenumber] for wavenumber in wavenumber_cm1.tolist()], axis=1)

    return at


def _columns(assembly: Assembly) -> FewColumns:
    """Return few columns: those that bound the scene, and medium clouds of each layer alone.

    The thinnest is the thickest, halved as often as the range allows: one sequence of doublings solves all clouds of a
    layer.
    """
    columns, layers = few_columns(assembly, PER_BAND), assembly.layers
    thinnest = [layer.thickness_min_m for layer in layers]
    halved = [layer.thickness_max_m * 0.5 ** floor(_octaves(layer)) for layer in layers]
    thickness = np.where(columns.thickness_m == thinnest, halved, columns.thickness_m)
    return replace(columns, thickness_m=np.concatenate((thickness, _medium_clouds(assembly))))


def _medium_clouds(assembly: Assembly) -> Array:
    """Return thicknesses (N, L) of columns with a medium cloud in one layer only."""
    medium = [layer.thickness_max_m * 0.5 ** round(0.5 * _octaves(layer)) for layer in assembly.layers]
    alone: Array = np.diag(medium)[np.flatnonzero(assembly.cloudy_layers)]
    return alone


def _octaves(layer: CloudLayer) -> float:
    return log2(layer.thickness_max_m / layer.thickness_min_m)
