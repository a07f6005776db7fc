"""What clear points of the certificate show beyond the mean clear column: the wave at each, less what clouds keep back.

A wave tilts the sea of its point: the column over the tilted sea takes the place of that over the mean sea, each of its
terms scaled by the level that keeps the mean over all waves that of the mean sea. This level alone is read from the
tables, between their instants and views; it is within a few percent of 1. Clouds on the path of the sun keep back the
share 1 - exp(-k s) of the direct sunlight that this sea reflects, at each wavenumber (Bouguer's law), with the
extinction k and the length s of the path in each layer. Where clear sky has texture, both are solved in the air and
over the sea of the point. Columns are solved at the reference level, on the next finer spectral grid. Slopes and paths
are those of the scene, as its frames have them: steeper waves are clipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.certificate.reference_columns import CURVE_SHARE, References
from hcss_twin.engine.stages.scene_stages import SceneTables
from hcss_twin.engine.stages.shadows import ShadowStage
from hcss_twin.engine.stages.waves import slopes_of
from hcss_twin.engine.tables.radiance_tables import interval
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.engine.tables.view_states import point_states
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics import quadrature
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.numerics import reference_level
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.waves import crosswind_sense, to_wind
from hcss_twin.plan.windows import Window, points_of
from hcss_twin.providers import Sun, View
from hcss_twin.providers.column_states import ColumnSetting, spectra_of

Values = NDArray[np.float32]

REACH = 2.4
"""Steps of the sea's temperature to which curves of clear columns go: four standard deviations."""

TILTS, FEW_TILTS = 8, 4
"""Orders of the polynomials of clear columns in both slopes of a wave, within the reach of waves: over the sea of the
scene, and of how they change over warmer and colder ones, a few percent."""

OPAQUE = 1.0 - 1e-9
"""Share of direct sunlight from which on clouds keep back all."""

AT_ONCE = 2**14
"""Pixels of an image whose fields are computed at once."""

SETTINGS_AT_ONCE = 32
"""Columns computed in one call; the memory grows with their number."""


def computed_at_once(plan: Plan) -> bool:
    """Whether fields of the whole image take less time than those of the pixels of a certificate one by one."""
    return plan.is_grid and plan.pixels[0] * plan.pixels[1] <= AT_ONCE


class ClearPoint(NamedTuple):
    """A clear point.

    Attributes
    ----------
    slope : (float, float)
        Upwind, and crosswind clockwise from upwind; 0 without waves.
    path_m : ndarray (L,)
        Length of the sun's path in the cloud of each layer.
    level : ndarray (K, B)
        Factor of each term over a tilted sea.
    perturbation : (float, float)
        By the texture of clear sky, in steps.
    """

    sun: Sun | None
    view: View
    slope: tuple[float, float]
    path_m: Array
    level: Array
    perturbation: tuple[float, float]


class ClearPoints:
    """Finds waves and shadows at the points of pixels."""

    def __init__(self, scene: SceneTables) -> None:
        self._plan, self._tables, self._effects = scene.plan, scene.of_sea, scene.point_effects
        self._shadows = [ShadowStage(scene.plan, [])] * scene.plan.has_shadows
        self._whole: dict[tuple[str, float], Values] = {}

    def of_pixel(
        self, time_s: float, row: int, column: int, view: View, perturbation: Array
    ) -> list[ClearPoint] | None:
        """Return the points of a pixel of the image as if all were clear; None if that changes nothing."""
        plan, pixel = self._plan, (slice(row, row + 1), slice(column, column + 1))
        if not plan.waves.varies and not plan.has_shadows:
            return None
        slopes, paths_m = self._slopes(time_s, pixel), self._paths_m(time_s, pixel)
        level, sun = self._level(time_s, pixel), plan.sun_up_at(time_s)
        warmer, drier = perturbation.tolist()
        return [
            ClearPoint(sun, view, (upwind, crosswind), path, level, (warmer, drier))
            for upwind, crosswind, path in zip(*slopes.tolist(), paths_m.T, strict=True)
        ]

    def _slopes(self, time_s: float, pixel: Window) -> Array:
        """Return the slopes (2, P), upwind and crosswind."""
        plan = self._plan
        of_window = partial(slopes_of, plan, plan.waves.shapes, time_s)
        slopes = self._at_points(of_window, "slopes", time_s, pixel).reshape(2, -1).astype(np.float64)
        reach = np.array(plan.waves.reach)[:, None]
        clipped: Array = np.clip(to_wind(plan.scenario.sea.wind_from) @ slopes, -reach, reach)
        return clipped

    def _paths_m(self, time_s: float, pixel: Window) -> Array:
        """Return the lengths (L, P) of the sun's path in the cloud of each layer."""
        plan, shape = self._plan, (len(self._plan.layers), self._plan.samples_per_pixel**2)
        mu0 = math.cos(math.radians(plan.sun_track.at(time_s).zenith_deg))
        cast = filter(None, [shadows.at(time_s) for shadows in self._shadows])
        of_pixel = (self._at_points(of.in_cloud, "paths", time_s, pixel).reshape(shape) for of in cast)
        return next((heights_m.astype(np.float64) / mu0 for heights_m in of_pixel), np.zeros(shape))

    def _at_points(self, of_window: Callable[[Window], Values], name: str, time_s: float, pixel: Window) -> Values:
        """Return a field (..., y, x) at the points of a pixel; of a small image all are computed at once."""
        plan = self._plan
        if not computed_at_once(plan):
            return of_window(pixel)
        whole = self._whole.get((name, time_s))
        if whole is None:
            whole = self._whole[name, time_s] = of_window(plan.extent)
        places = zip(pixel, plan.extent, strict=True)
        rows, columns = (slice(of.start - first.start, of.stop - first.start) for of, first in places)
        return whole[..., points_of(rows, plan.samples_per_pixel), points_of(columns, plan.samples_per_pixel)]

    def _level(self, time_s: float, pixel: Window) -> Array:
        """Return the level (K, B) of a pixel; 1 without waves."""
        if not self._plan.waves.varies:
            return np.ones((len(self._plan.assembly.model.terms), len(self._plan.bands)))
        of_views = []
        for tables in self._tables:
            (index, weight), levels = interval(tables.time_s, time_s), tables.waves.level
            of_views.append((1.0 - weight) * levels[index] + weight * levels[min(index + 1, len(levels) - 1)])
        states = point_states(self._plan, self._effects, np.array(of_views), time_s)
        level: Array = np.tensordot(states.weights(pixel)[0, 0], states.values, 1)
        return level


def changes(plan: Plan, points: Sequence[ClearPoint], references: References) -> Array:
    """Return what waves and shadows change in the terms (N, K, B) of the mean clear column, at each point.

    Parameters
    ----------
    plan : Plan
        In the state of the points: without waves on any surface but the scenario's sea.
    """
    on_curve = _on_curve(plan, points, references)
    compute = partial(_changes, plan, points, on_curve)
    if on_curve is not None:
        return compute()  # no other scene has these points
    suns, views = [point.sun for point in points], [point.view for point in points]
    values = [np.concatenate((point.slope, point.path_m, point.level.ravel(), point.perturbation)) for point in points]
    return references.recalled(plan, compute, np.array(values), suns, views, "clear points")


def _changes(plan: Plan, points: Sequence[ClearPoint], on_curve: tuple[Array, Array] | None) -> Array:
    """Return the changes; columns over the tilted and over the mean sea are solved that are not on curves.

    Of those, points behind thin clouds need spectra all the same.
    """
    fine, grid = _finest(plan)
    in_sky = cache(partial(plan.texture.perturbed, fine))
    cast = [number for number, point in enumerate(points) if np.any(point.path_m)]
    extinction_m1 = _extinction_m1(plan, grid.wavenumber_cm1) if cast else np.empty(0)
    kept_back = {number: -np.expm1(-(points[number].path_m @ extinction_m1)) for number in cast}
    thin = [number for number, share in kept_back.items() if np.min(share) < OPAQUE]
    mean, seen = dict[int, ColumnSetting](), dict[int, ColumnSetting]()
    for number in range(len(points)) if on_curve is None else thin:
        point = points[number]
        sky = in_sky(point.perturbation) if any(point.perturbation) else fine
        mean[number] = seen[number] = sky.setting(point.sun, point.view)
        if plan.waves.varies:
            seen[number] = _tilted(plan, sky, point.slope, point).setting(point.sun, point.view)
    shape = len(points), len(fine.model.terms), len(plan.bands)
    of_seen, of_mean = on_curve or (np.empty(shape), np.empty(shape))
    direct = [list(fine.model.terms).index(name) for name in sea_sun_terms(fine.model)]
    whole, lost = dict[ColumnSetting, Array](), np.zeros(shape)
    for number in kept_back.keys() - seen.keys():
        lost[number, direct] = of_seen[number, direct]
    shaded: dict[ColumnSetting, list[int]] = {}
    for number in seen.keys() & kept_back.keys():
        shaded.setdefault(seen[number], []).append(number)
    for setting, spectrum in _spectra(plan, (*(mean.values() if on_curve is None else ()), *seen.values())):
        whole[setting] = spectrum @ grid.weights_cm1.T
        for number in shaded.get(setting, ()):
            lost[number, direct] = (spectrum[direct] * kept_back[number]) @ grid.weights_cm1.T
    for number, setting in seen.items():
        of_seen[number], of_mean[number] = whole[setting], whole.get(mean[number], of_mean[number])
    level = np.array([point.level for point in points]) if plan.waves.varies else np.ones(shape)
    changed: Array = level * (of_seen - lost) - of_mean
    return changed


def _finest(plan: Plan) -> tuple[Assembly, SpectralGrid]:
    """Return the scene at the reference level, and the next finer spectral grid."""
    fine = plan.assembly.at_level(reference_level(plan.assembly))
    return fine, plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)


def _tilted(plan: Plan, sky: Assembly, slope: Sequence[float], seen: ClearPoint) -> Assembly:
    upwind, crosswind = slope
    return plan.waves.tilted(sky, (upwind, crosswind * crosswind_sense(seen.view, seen.sun)))


def _spectra(plan: Plan, every: Sequence[ColumnSetting]) -> Iterator[tuple[ColumnSetting, Array]]:
    """Yield the terms (K, V) of clear sky in different settings."""
    (fine, grid), different, cloudless = _finest(plan), list(dict.fromkeys(every)), np.zeros((1, len(plan.layers)))
    for first in range(0, len(different), SETTINGS_AT_ONCE):
        settings = different[first : first + SETTINGS_AT_ONCE]
        yield from zip(settings, spectra_of(fine.model, settings, grid.wavenumber_cm1, cloudless)[:, 0], strict=True)


def _on_curve(plan: Plan, points: Sequence[ClearPoint], references: References) -> tuple[Array, Array] | None:
    """Return clear columns (N, K, B) over the tilted and the mean seas of points, from a few slopes and temperatures.

    Scenes of a sweep have these in common. None where there are no curves, in scenes that solve columns afresh, and
    where columns between the nodes show that these are too few.
    """
    of_sea_alone = plan.texture.temperature_K > 0.0 and plan.texture.water_vapour == 0.0
    if not (references.from_curves and plan.waves.varies and of_sea_alone) or references.afresh:
        return None
    (fine, grid), reach = _finest(plan), np.array(plan.waves.reach)
    every, few = (list(product(quadrature.nodes(order).tolist(), repeat=2)) for order in (TILTS, FEW_TILTS))
    colder, warmer = ([(step, *slope) for slope in few] for step in (-REACH, REACH))
    proof = [(share * REACH, u, v) for share in (-0.5, 0.5) for u, v in ((-0.71, 0.57), (0.26, -0.83))]
    states = [(0.0, *slope) for slope in every] + colder + warmer + proof
    tilted, mean = (np.empty((len(points), len(fine.model.terms), len(plan.bands))) for _ in range(2))
    for sun, view in dict.fromkeys((point.sun, point.view) for point in points):
        rows = [row for row, point in enumerate(points) if (point.sun, point.view) == (sun, view)]
        seen = points[rows[0]]

        def compute(seen: ClearPoint = seen) -> Array:
            skies = {step: plan.texture.perturbed(fine, (step, 0.0)) for step in {state[0] for state in states}}
            seas = [_tilted(plan, skies[step], (reach * slope).tolist(), seen) for step, *slope in states]
            seas += [skies[step] for step in (-REACH, 0.0, REACH)]
            settings = [sea.setting(seen.sun, seen.view) for sea in seas]
            found = {setting: spectrum @ grid.weights_cm1.T for setting, spectrum in _spectra(plan, settings)}
            return np.array([found[setting] for setting in settings])

        key = np.array(states)
        known = references.shared(plan, compute, key, [sun] * len(key), [view] * len(key), "tilted clear columns")
        nodes, exact = known[: -len(proof) - 3], known[-len(proof) - 3 : -3]
        error = largest_error(np.sum(_between_tilts(nodes, key[-len(proof) :]), axis=-2), np.sum(exact, axis=-2))
        if error > CURVE_SHARE * plan.accuracy.relative:
            return None
        at = np.array([(points[row].perturbation[0], *np.divide(points[row].slope, reach)) for row in rows])
        tilted[rows] = _between_tilts(nodes, at)
        mean[rows] = np.tensordot(quadrature.weights(2, at[:, 0] / REACH), known[-3:], 1)
        references.read, references.curve_columns = references.read + len(rows), references.curve_columns + len(nodes)
        references.curve_error = max(references.curve_error, error)
    return tilted, mean


def _between_tilts(known: Array, at: Array) -> Array:
    """Return columns (N, K, B) at temperatures in steps and slopes in units of their reach (N, 3), from known ones."""
    every, few = TILTS + 1, FEW_TILTS + 1
    even = known[: every**2].reshape(every, every, *known.shape[1:])
    same = even[:: TILTS // FEW_TILTS, :: TILTS // FEW_TILTS]
    change = known[every**2 :].reshape(2, few, few, *known.shape[1:]) - same
    warmer = quadrature.weights(2, at[:, 0] / REACH)[:, [0, 2]]
    slopes = [np.ascontiguousarray(slope) for slope in at[:, 1:].T]
    fine, coarse = ([quadrature.weights(order, slope) for slope in slopes] for order in (TILTS, FEW_TILTS))
    found = np.einsum("ni,nj,ij...->n...", *fine, even, optimize=True)
    return np.asarray(found + np.einsum("nt,ni,nj,tij...->n...", warmer, *coarse, change, optimize=True))


def _extinction_m1(plan: Plan, wavenumber_cm1: Array) -> Array:
    """Return the extinction (L, V) of the particles of each layer, which scenes of a sweep share."""
    optics = plan.assembly.optics

    def compute() -> Array:
        return np.array(
            [optics.single_scattering(layer.microphysics, wavenumber_cm1).extinction_m1 for layer in plan.layers]
        )

    key = "extinction", table_key(plan), wavenumber_cm1.tobytes()
    return plan.catalog.shelf.get_or_compute(key, compute)
