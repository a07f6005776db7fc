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
from collections.abc import Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.certificate.reference_columns import References
from hcss_twin.engine.stages.scene_stages import SceneTables
from hcss_twin.engine.stages.shadows import ShadowStage
from hcss_twin.engine.stages.waves import slopes_of
from hcss_twin.engine.tables.radiance_tables import interval
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.engine.tables.view_states import point_states
from hcss_twin.physics import quadrature
from hcss_twin.plan.numerics import reference_level
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import sea_sun_terms
from hcss_twin.plan.waves import crosswind_sense, to_wind
from hcss_twin.plan.windows import Window
from hcss_twin.providers import Sun, View
from hcss_twin.providers.column_states import ColumnSetting, spectra_of

ORDER, REACH = 6, 2.4
"""Order of the polynomial of the mean clear column in the sea's temperature, up to so many steps from the scene: four
standard deviations."""

SETTINGS_AT_ONCE = 32
"""Columns computed in one call; the memory grows with their number."""


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
        slopes = slopes_of(plan, plan.waves.shapes, time_s, pixel).reshape(2, -1).astype(np.float64)
        reach = np.array(plan.waves.reach)[:, None]
        clipped: Array = np.clip(to_wind(plan.scenario.sea.wind_from) @ slopes, -reach, reach)
        return clipped

    def _paths_m(self, time_s: float, pixel: Window) -> Array:
        """Return the lengths (L, P) of the sun's path in the cloud of each layer."""
        plan, shape = self._plan, (len(self._plan.layers), self._plan.samples_per_pixel**2)
        mu0 = math.cos(math.radians(plan.sun_track.at(time_s).zenith_deg))
        cast = filter(None, [shadows.at(time_s) for shadows in self._shadows])
        return next((of.in_cloud(pixel).reshape(shape).astype(np.float64) / mu0 for of in cast), np.zeros(shape))

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
    suns, views = [point.sun for point in points], [point.view for point in points]
    values = [np.concatenate((point.slope, point.path_m, point.level.ravel(), point.perturbation)) for point in points]
    compute = partial(_changes, plan, points, references)
    return references.recalled(plan, compute, np.array(values), suns, views, "clear points")


def _changes(plan: Plan, points: Sequence[ClearPoint], references: References) -> Array:
    fine = plan.assembly.at_level(reference_level(plan.assembly))
    grid = plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)
    in_sky = cache(partial(plan.texture.perturbed, fine))
    skies = [in_sky(point.perturbation) if any(point.perturbation) else fine for point in points]
    mean = [sky.setting(point.sun, point.view) for sky, point in zip(skies, points, strict=True)]
    seen, level = mean, np.ones((len(points), len(fine.model.terms), len(plan.bands)))
    if plan.waves.varies:
        senses = [(1.0, crosswind_sense(point.view, point.sun)) for point in points]
        slopes = [tuple(np.multiply(point.slope, sense)) for point, sense in zip(points, senses, strict=True)]
        tilted = [plan.waves.tilted(sky, slope) for sky, slope in zip(skies, slopes, strict=True)]
        seen = [scene.setting(point.sun, point.view) for scene, point in zip(tilted, points, strict=True)]
        level = np.array([point.level for point in points])
    shaded: dict[ColumnSetting, list[int]] = {}
    for number, point in enumerate(points):
        if np.any(point.path_m):
            shaded.setdefault(seen[number], []).append(number)
    extinction_m1 = _extinction_m1(plan, grid.wavenumber_cm1) if shaded else np.empty(0)
    direct = [list(fine.model.terms).index(name) for name in sea_sun_terms(fine.model)]
    whole, lost = dict[ColumnSetting, Array](), np.zeros_like(level)
    # Scenes of a sweep have mean columns over seas of the same temperatures in common, but not their waves.
    of_sea_alone = plan.texture.temperature_K > 0.0 and plan.texture.water_vapour == 0.0
    on_curve = references.from_curves and plan.waves.varies and of_sea_alone
    different = list(dict.fromkeys(seen if on_curve else (*mean, *seen)))
    cloudless = np.zeros((1, len(plan.layers)))
    for first in range(0, len(different), SETTINGS_AT_ONCE):
        settings = different[first : first + SETTINGS_AT_ONCE]
        spectra = spectra_of(fine.model, settings, grid.wavenumber_cm1, cloudless)[:, 0]
        for setting, spectrum in zip(settings, spectra, strict=True):
            whole[setting] = spectrum @ grid.weights_cm1.T
            for number in shaded.get(setting, ()):
                kept_back = -np.expm1(-(points[number].path_m @ extinction_m1))
                lost[number, direct] = (spectrum[direct] * kept_back) @ grid.weights_cm1.T
    of_seen = np.array([whole[setting] for setting in seen])
    of_mean = _on_curve(plan, points, references) if on_curve else np.array([whole[setting] for setting in mean])
    changed: Array = level * (of_seen - lost) - of_mean
    return changed


def _on_curve(plan: Plan, points: Sequence[ClearPoint], references: References) -> Array:
    """Return the mean clear columns (N, K, B) of points, from columns over seas of a few temperatures."""
    fine = plan.assembly.at_level(reference_level(plan.assembly))
    grid = plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)
    warmer = REACH * quadrature.nodes(ORDER)
    result = np.empty((len(points), len(fine.model.terms), len(plan.bands)))
    for sun, view in dict.fromkeys((point.sun, point.view) for point in points):

        def compute(sun: Sun | None = sun, view: View = view) -> Array:
            skies = [plan.texture.perturbed(fine, (step, 0.0)) for step in warmer.tolist()]
            settings, cloudless = [sky.setting(sun, view) for sky in skies], np.zeros((1, len(plan.layers)))
            spectra = spectra_of(fine.model, settings, grid.wavenumber_cm1, cloudless)[:, 0]
            return np.asarray(spectra @ grid.weights_cm1.T)

        suns, views = warmer.size * [sun], warmer.size * [view]
        known = references.shared(plan, compute, warmer, suns, views, "mean clear columns")
        rows = [row for row, point in enumerate(points) if (point.sun, point.view) == (sun, view)]
        places = np.array([points[row].perturbation[0] for row in rows]) / REACH
        result[rows] = np.tensordot(quadrature.weights(ORDER, places), known, 1)
    return result


def _extinction_m1(plan: Plan, wavenumber_cm1: Array) -> Array:
    """Return the extinction (L, V) of the particles of each layer, which scenes of a sweep share."""
    optics = plan.assembly.optics

    def compute() -> Array:
        return np.array(
            [optics.single_scattering(layer.microphysics, wavenumber_cm1).extinction_m1 for layer in plan.layers]
        )

    key = "extinction", table_key(plan), wavenumber_cm1.tobytes()
    return plan.catalog.shelf.get_or_compute(key, compute)
