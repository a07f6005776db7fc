"""Choice between resolved waves and the mean sea in clear pixels, with a bound on the difference."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sea.wave_field import MOST, MOST_SIGMAS, SIGMAS, thermal_contrast_bound, tilted_glint_bound
from hcss_twin.physics.geometry import relative_azimuth_rad, wind_sense
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.plan.combinations import Excluded, NotComputed, why_not
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.few_columns import SKIP_SHARE, Omission, omitted
from hcss_twin.plan.sunlight import toward_glint
from hcss_twin.plan.windows import length, whole_image
from hcss_twin.providers import Grid, Sun, View, WaveShapes
from hcss_twin.scenario.scenario import Scenario

WAVENUMBERS = 24
"""Number of wavenumbers per band."""

LEVEL_FACTOR = 1.1
"""Safety factor for the level of drawn waves, which keeps the mean radiance of the sea: it moves by up to 6 % of what
the waves change."""


def wave_bound(
    assembly: Assembly, rms: tuple[float, float], wind_from_deg: float, suns: Sequence[Sun | None], any_pixel: bool
) -> float:
    """Return the greatest relative change of clear radiance in any band, toward the views of a scene.

    Parameters
    ----------
    assembly : Assembly
        With a sea that has ``mean_square_slope``.
    rms : (float, float)
        Standard deviations of the resolved slope, upwind and crosswind.
    wind_from_deg : float
        Bearing the wind comes from.
    suns : sequence of Sun or None
        Sun positions to evaluate.
    any_pixel : bool
        Whether to cover the tilts of any pixel, rather than those within three standard deviations.
    """
    scenes = toward_glint(assembly, suns)
    return max(_bound_toward(scene, rms, wind_from_deg, suns, any_pixel) for scene in scenes)


def _bound_toward(
    assembly: Assembly, rms: tuple[float, float], wind_from_deg: float, suns: Sequence[Sun | None], any_pixel: bool
) -> float:
    """Return the greatest relative change toward one view.

    Thermal radiance of the sea changes with its emissivity under a sky without emission, and reflected sunlight
    changes with the glint that reaches the sensor through the air, at most all sunlight of clear sky. Both are upper
    limits.
    """
    grid = assembly.spectral_grid
    places = np.unique(np.concatenate([_sample(weights) for weights in grid.weights_cm1]))
    wavenumber, weights = grid.wavenumber_cm1[places], grid.weights_cm1[:, places]
    view = assembly.view
    mu = np.array([math.cos(math.radians(view.zenith_deg))])
    toward_view = _horizontal(view.zenith_deg, view.azimuth_deg - wind_from_deg)
    emissivity = assembly.sea.emissivity(wavenumber, mu)[0]
    thermal = emissivity * planck(wavenumber, assembly.sea_temperature_K)
    turn = math.radians(view.azimuth_deg - wind_from_deg)
    along = math.hypot(rms[0] * math.cos(turn), rms[1] * math.sin(turn))
    steepest = (math.hypot(*rms), MOST_SIGMAS) if any_pixel else (along, SIGMAS)
    thermal *= thermal_contrast_bound(assembly.sea, wavenumber, mu, steepest[0], sigmas=steepest[1])[0]
    path = to_space(0.0, view.zenith_deg)
    seen = assembly.transmittance.transmittance(wavenumber, [path])[0]
    greatest = 0.0
    for sun in suns:
        terms = assembly.clear(wavenumber, sun)
        change = weights @ (seen * thermal)
        if sun is not None:
            toward_sun = _horizontal(sun.zenith_deg, sun.azimuth_deg - wind_from_deg)
            vertical = float(mu[0]) + math.cos(math.radians(sun.zenith_deg))
            mirror = (-(toward_view[0] + toward_sun[0]) / vertical, -(toward_view[1] + toward_sun[1]) / vertical)
            slope = float(assembly.sea.mean_square_slope)  # type: ignore[attr-defined]
            sunlight = np.sum([terms[name] for name in assembly.model.solar_terms], axis=0)
            sunlight = np.minimum(sunlight, seen * _glint(assembly, wavenumber, mu, sun))
            change = change + tilted_glint_bound(mirror, slope, rms, toward_view, any_pixel) * (weights @ sunlight)
        total = weights @ np.sum(list(terms.values()), axis=0)
        greatest = max(greatest, float(np.max(change[total > 0] / total[total > 0], initial=0.0)))
    return LEVEL_FACTOR * greatest


def _horizontal(zenith_deg: float, azimuth_deg: float) -> tuple[float, float]:
    """Horizontal components of a direction, along the reference bearing of its azimuth and clockwise from it."""
    sine, azimuth = math.sin(math.radians(zenith_deg)), math.radians(azimuth_deg)
    return sine * math.cos(azimuth), sine * math.sin(azimuth)


def _sample(weights: Array) -> NDArray[np.intp]:
    """Indices of evenly spaced wavenumbers at which a band has weight."""
    inside = np.flatnonzero(weights)
    return inside[np.unique(np.linspace(0, inside.size - 1, WAVENUMBERS).round().astype(np.intp))]


def _glint(assembly: Assembly, wavenumber_cm1: Array, mu: Array, sun: Sun) -> Array:
    """Sunlight reflected by the sea (V,), at the surface, without an atmosphere."""
    mu_sun = np.array([math.cos(math.radians(sun.zenith_deg))])
    azimuth = np.array([relative_azimuth_rad(assembly.view.azimuth_deg, sun.azimuth_deg)])
    irradiance = assembly.solar_irradiance(wavenumber_cm1) / sun.distance_au**2
    brdf = assembly.sea.brdf(wavenumber_cm1, mu, mu_sun, azimuth)[0]
    return np.asarray(brdf * mu_sun[0] * irradiance, dtype=np.float64)


WAVES = "waves as shapes"
NOTE = "sea: waves are drawn in clear sky only; under clouds the sea is the mean one"

_SEED_KEY = 2**16
"""Distinguishes the seed of the waves from those of the cloud layers, numbered from 0."""


@dataclass(frozen=True)
class PlannedWaves(Effect):
    """Resolved waves of a scene.

    Attributes
    ----------
    shapes : WaveShapes
        Slopes at the points of the image.
    rms : (float, float)
        Standard deviations of slope, upwind and crosswind.
    point_size_m : float
        Distance between points.
    """

    kind = "waves"

    shapes: WaveShapes
    rms: tuple[float, float]
    point_size_m: float

    @property
    def reach(self) -> tuple[float, float]:
        """Largest slopes, upwind and crosswind: steeper waves are clipped to them."""
        return MOST_SIGMAS * self.rms[0], MOST_SIGMAS * self.rms[1]

    def tilted(self, assembly: Assembly, slope: tuple[float, float]) -> Assembly:
        """Return a scene over the sea that a wave tilts, upwind and, in the sense of a view and a sun, crosswind."""
        return assembly.over_sea(assembly.sea.tilted(*slope, self.point_size_m))  # type: ignore[attr-defined]

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return the image, whose windows use the tables of the whole."""
        return {"image": whole_image(scenario)}


FLAT = 1e-9
"""Standard deviation of slopes below which the sea is flat: single precision does not hold places between them."""


class Calm:
    """Waves without slopes."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x) of 0."""
        return np.zeros((2, length(rows), length(columns)), np.float32)


class MeanSea(PlannedWaves):
    """The sea averaged over its waves."""

    varies = False


MEAN_SEA = MeanSea(Calm(), (0.0, 0.0), 0.0)


def excluded_beside_waves(scenario: Scenario, assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with resolved waves, beside maps of the ground without sea."""
    sea = assembly.sea
    able = hasattr(sea, "wave_slope_rms") and hasattr(sea, "wave_field") and hasattr(sea, "tilted")
    return (
        Excluded(
            "sea.model", not able, f"the sea model '{scenario.sea.model}', without waves as shapes,", "'rough-sea'"
        ),
        Excluded("image", assembly.own_suns, "a full disk, whose places have suns of their own,", "a part"),
    )


def wants_waves(scenario: Scenario) -> bool:
    """Whether a scenario asks for resolved waves, rather than leaving them to the plan."""
    return scenario.sea.waves == "on" or not {"sea_slope_x", "sea_slope_y"}.isdisjoint(scenario.output.variables)


def choose_waves(
    scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None], accuracy: float, why: NotComputed | None = None
) -> tuple[Omission, ...]:
    """Return the omission if waves are not resolved; none if they are.

    Parameters
    ----------
    suns : sequence of Sun or None
        Sun positions for the bound; none if no radiance is needed.
    accuracy : float
        Relative to the radiance; waves are negligible below their share of it.
    why : NotComputed, optional
        Why they cannot be resolved, if this is known already.

    Raises
    ------
    ScenarioError
        If the scenario requests resolved waves beside what excludes them.
    """
    sea = assembly.sea
    left_out = why_not("sea.waves", scenario.sea.waves, excluded_beside_waves(scenario, assembly)) or why
    if not hasattr(sea, "wave_slope_rms"):
        return (Omission(WAVES, "the sea model does not know how long its waves are", None),)
    points = _points(scenario, assembly)
    if max(sea.wave_slope_rms(points.pixel_size_m)) < FLAT:
        wind, size = assembly.sea_wind_speed_m_s, points.pixel_size_m
        short = f"a wind of {wind:.3g} m/s raises no waves longer than two points of {size:g} m; slopes are averaged"
        return (Omission(WAVES, short if wind > 0.0 else "no wind raises waves", 0.0),)
    if left_out is None and wants_waves(scenario):
        return ()
    if not assembly.has_clear_sky:
        return (Omission(WAVES, "cloud covers every pixel, and waves are resolved in clear sky only", 0.0),)
    bound: float | None = None if suns else 0.0
    estimate: float | None = None
    if suns and hasattr(sea, "mean_square_slope"):
        rms = sea.wave_slope_rms(assembly.grid.pixel_size_m)
        bound, estimate = (
            wave_bound(assembly, rms, scenario.sea.wind_from, suns, any_pixel) for any_pixel in (True, False)
        )
    omission = Omission(WAVES, "", bound, estimate, "" if estimate is None else MOST)
    if left_out is not None:
        return (omitted(omission, left_out, "every clear pixel is the mean sea"),)
    if bound is not None and bound <= SKIP_SHARE * accuracy:
        return (replace(omission, why="they would change less than their share of the accuracy asked for"),)
    return ()


def crosswind_sense(view: View, sun: Sun | None) -> float:
    """Return the sign of a slope that is crosswind clockwise, as seas are tilted for a view and a sun."""
    sun = view.sun(sun)
    return 1.0 if sun is None else wind_sense(view.azimuth_deg, sun.azimuth_deg)


TiltedSea = Callable[[View, Sun | None], Assembly]
"""Returns a scene over a sea that waves tilt by one slope, for a view and a sun."""

TILT_SIGMAS = 2.0
"""Standard deviations of the slopes at which the nodes of the view are tested."""


def tilted_seas(scenario: Scenario, assembly: Assembly) -> list[TiltedSea]:
    """Return the seas over which the nodes of the view are tested: tilted either way upwind and crosswind."""
    sea: Any = assembly.sea
    size_m = _points(scenario, assembly).pixel_size_m
    upwind, crosswind = (TILT_SIGMAS * rms for rms in sea.wave_slope_rms(size_m))

    @cache
    def scene(along: float, across: float) -> Assembly:
        return assembly.over_sea(sea.tilted(along, across, size_m))

    def tilted(along: float, across: float, view: View, sun: Sun | None) -> Assembly:
        return scene(along, crosswind_sense(view, sun) * across)

    slopes = ((upwind, 0.0), (-upwind, 0.0), (0.0, crosswind), (0.0, -crosswind))
    return [partial(tilted, *slope) for slope in slopes]


def resolve_waves(scenario: Scenario, assembly: Assembly) -> PlannedWaves:
    """Return the waves at the points of the image.

    Raises
    ------
    ScenarioError
        If the facets of the sea cannot be divided into resolved and averaged slopes.
    """
    sea: Any = assembly.sea
    points = _points(scenario, assembly)
    with attribute_to_field("sea.waves", scenario.sea.parameters):
        # Only an attempt shows whether the slopes can be divided.
        sea.tilted(0.0, 0.0, points.pixel_size_m)
        shapes = sea.wave_field(points, assembly.motion, wave_seed(scenario.seed))
    return PlannedWaves(shapes, sea.wave_slope_rms(points.pixel_size_m), points.pixel_size_m)


def _points(scenario: Scenario, assembly: Assembly) -> Grid:
    grid, samples = assembly.grid, scenario.image.samples_per_pixel
    return Grid(grid.rows * samples, grid.columns * samples, grid.pixel_size_m / samples)


def to_wind(wind_from_deg: float) -> Array:
    """Return the matrix (2, 2) that turns slopes along x (east) and y (north) into slopes upwind and crosswind.

    Upwind points toward the origin of the wind; crosswind is clockwise from it.
    """
    bearing = math.radians(wind_from_deg)
    return np.array([[math.sin(bearing), math.cos(bearing)], [math.cos(bearing), -math.sin(bearing)]])


def wave_seed(seed: int) -> int:
    """Seed of the waves of a scene, independent of those of its clouds."""
    return int(np.random.SeedSequence(seed, spawn_key=(_SEED_KEY,)).generate_state(1, np.uint64)[0] >> 1)
