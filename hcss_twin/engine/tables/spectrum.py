"""Selection of the wavenumbers for the columns of a scene: fitted to some of its columns, tested on others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.tensor_train import evenly
from hcss_twin.engine.tables.thickness_axis import axis_of
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sunlight import checked_frames
from hcss_twin.providers import ColumnStates, Sun, View

FIRST_COLUMNS, FEWER_FIRST = 5, 3
"""Number of thicknesses of each layer, in geometric progression, for the fit; one between any two levels is added.
The second is for loose tolerances, as below."""

TRIED_COLUMNS, FEWER_TRIED = 8, 4
"""Number of other thicknesses of each layer, and of all, for each test."""

LOOSE_TOLERANCE = 1e-3
"""Tolerance from which on fewer columns are fitted and tried: spectra differ from a line between three thicknesses by
less."""

CHOICE_SHARE, TRIAL_SHARE = 0.2, 0.4
"""Shares of the tolerance for fitted columns and for test columns."""

CLEAR_SKIES = 5
"""Number of sun elevations over clear sky for the fit; one if the sun hardly moves."""

SUN_DEG_PER_TOLERANCE = 330.0
"""At rainbow scattering angles, weights fitted for one sun position gain errors of up to 3e-3 per degree."""

TRIED_SUNS = 2
"""Number of sun positions between those of the fit, for tests if the sun moves."""

MAX_TRIALS = 6
"""Maximum number of fits; after that all wavenumbers are used."""


@dataclass(frozen=True)
class Spectrum:
    """Wavenumbers of the columns of the radiance tables.

    Attributes
    ----------
    dense : int
        Number of wavenumbers of the full grid.
    estimated_error : float
        Relative error of the total of any band: the tolerance, of which test columns used less than ``TRIAL_SHARE``;
        0 if all wavenumbers are used.
    """

    nodes: SpectralNodes
    dense: int
    estimated_error: float


def choose_spectrum(plan: Plan, tolerance: float, views: Sequence[View] = (), tested: Sequence[View] = ()) -> Spectrum:
    """Choose weighted wavenumbers for all columns of a scene.

    The fit uses columns at every wavenumber of the dense grid, clear and with clouds from the thinnest to the
    thickest, for the first, middle and last sun (or, if the sun hardly moves, that of a frame in the certificate). If
    the sun moves, clear sky for more suns is added. The fit is tested on clouds of other thickness for suns in
    between, if the sun moves, and on clear sky for other suns, including the highest and the lowest. Columns that
    fail are added to the fit, which is tested again on further columns.

    Parameters
    ----------
    tolerance : float
        Relative to the total of each band.
    views, tested : sequence of View
        Those of the fit and of the test, if the view varies over the image.
    """
    family, level = plan.assembly.family, (plan.assembly.numerical_level, plan.assembly.sunlight_steps)
    if family is None:
        return _choose(plan, tolerance, views, tested)
    name = "spectrum", plan.spectral_grid.wavenumber_cm1.tobytes(), level, tolerance, *views, *tested
    return family.keep(name, lambda: _choose(plan, tolerance, views, tested))


def _choose(plan: Plan, tolerance: float, views: Sequence[View], tested: Sequence[View]) -> Spectrum:
    grid = plan.spectral_grid
    moves = any(_sun_moves(plan, view, tolerance) for view in views or (plan.view,))
    suns = _suns_over_time(plan, np.linspace(0.0, 1.0, 3)) if moves else _suns_that_hardly_move(plan)
    skies = _suns(plan, CLEAR_SKIES) if moves else suns
    # The difference of a perturbed state needs its own wavenumbers.
    perturbed = [replace(plan, assembly=scene) for scene in plan.texture.with_own_spectra(plan.assembly)]
    loose, heights = tolerance >= LOOSE_TOLERANCE, CLEAR_SKIES if moves else 1
    first = _first_columns(plan, FEWER_FIRST if loose else FIRST_COLUMNS)
    trials = _trials(plan, FEWER_TRIED if loose else TRIED_COLUMNS)

    def trial(number: int) -> tuple[Array, list[Sun | None], list[Sun | None]]:
        count = TRIED_SUNS + number
        between = _suns_over_time(plan, (np.arange(count) + 0.5) / count) if moves else suns
        return next(trials), between, _suns(plan, heights + 1 + number)

    # With those of the first trial: all suns together cost a model little more than some.
    tried_first = (tested, *trial(0))
    known, tried = _spectra(plan, (views, first, suns, skies), tried_first)
    others = [_spectra(in_state, (views, first, suns, skies))[0] for in_state in perturbed]
    known = np.concatenate((known, *others))
    for number in range(1, MAX_TRIALS + 1):
        nodes = grid.choose_nodes(known, CHOICE_SHARE * tolerance)
        if nodes.wavenumber_cm1.size == grid.wavenumber_cm1.size:
            break
        places = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
        total = np.sum(tried, axis=1)
        error = largest_error(total[:, places] @ nodes.weights_cm1.T, total @ grid.weights_cm1.T)
        if error <= TRIAL_SHARE * tolerance:
            return Spectrum(nodes, grid.wavenumber_cm1.size, tolerance)
        known = np.concatenate((known, tried))
        if number < MAX_TRIALS:
            (tried,) = _spectra(plan, (tested, *trial(number)))
    return Spectrum(grid.all_nodes(), grid.wavenumber_cm1.size, 0.0)


_Part = tuple[Sequence[View], Array, Sequence[Sun | None], Sequence[Sun | None]]


def _spectra(plan: Plan, *parts: _Part) -> list[Array]:
    """Terms (N, K, V) of each part: cloudy columns toward each view under some suns, and clear sky under others."""
    scene, cloudless = plan.assembly, np.zeros((1, len(plan.layers)))
    wanted = [
        (part, setting, rows)
        for part, (views, thickness_m, suns, skies) in enumerate(parts)
        for rows, under in ((thickness_m, suns), (cloudless, skies))
        for view in views or (plan.view,)
        for sun in under
        for setting in scene.spanning(sun, view)
        if len(rows)
    ]
    spectra: list[list[Array]] = [[] for _ in parts]
    for some in scene.air_over_field.together(wanted):
        settings = [setting for _, setting, rows in some for _ in rows]
        states = ColumnStates.of(settings, np.concatenate([rows for *_, rows in some]))
        terms = scene.model.columns(states, plan.spectral_grid.wavenumber_cm1)
        found = np.stack([np.asarray(terms[name]) for name in scene.model.terms], axis=1)
        ends = np.cumsum([len(rows) for *_, rows in some])
        for (part, *_), values in zip(some, np.split(found, ends[:-1]), strict=True):
            spectra[part].append(values)
    return [np.concatenate(of_part) for of_part in spectra]


def _sun_moves(plan: Plan, toward: View, tolerance: float) -> bool:
    """Whether the sun's elevation or the scattering angle changes more than the tolerance allows."""
    up = plan.sun_zenith_deg < 90.0
    if not plan.sun_matters or not np.any(up):
        return False
    sun, turn = (np.radians(plan.sun_zenith_deg[up]), np.radians(plan.sun_azimuth_deg[up] - toward.azimuth_deg))
    view = np.radians(toward.zenith_deg)
    toward_sun = np.cos(view) * np.cos(sun) + np.sin(view) * np.sin(sun) * np.cos(turn)
    scattered = np.arccos(np.clip(-toward_sun, -1.0, 1.0))
    return bool(np.degrees(max(np.ptp(sun), np.ptp(scattered))) > SUN_DEG_PER_TOLERANCE * tolerance)


def _suns_over_time(plan: Plan, shares: Array) -> list[Sun | None]:
    """Return the sun at fractions of the sunlit frames, in order; None is added if frames have no sun."""
    up = np.flatnonzero(plan.sun_zenith_deg < 90.0)
    frames = np.unique(up[(shares * (up.size - 1)).round().astype(np.intp)])
    suns = [plan.sun_at(float(plan.frame_times_s[frame])) for frame in frames]
    return suns if up.size == plan.sun_zenith_deg.size else [*suns, None]


def _suns(plan: Plan, count: int) -> list[Sun | None]:
    """Return the sun at ``count`` elevations, the highest first; None is added if frames have no sun."""
    up = np.flatnonzero(plan.sun_zenith_deg < 90.0)
    by_height = up[np.argsort(plan.sun_zenith_deg[up], kind="stable")]
    places = np.linspace(0, max(up.size - 1, 0), min(count, up.size)).round().astype(int)
    suns = [plan.sun_at(float(plan.frame_times_s[frame])) for frame in by_height[np.unique(places)]]
    return suns if up.size == plan.sun_zenith_deg.size else [*suns, None]


def _suns_that_hardly_move(plan: Plan) -> list[Sun | None]:
    """Return the sun of a frame in the certificate; None is added if other frames have no sun."""
    others = _suns(plan, 1)
    frame = checked_frames(1, plan.frame_times_s.size)[0]
    if plan.sun_zenith_deg[frame] >= 90.0:
        return others
    return [plan.sun_at(float(plan.frame_times_s[frame])), *(sun for sun in others if sun is None)]


def _first_columns(plan: Plan, count: int) -> Array:
    """Thicknesses (N, L): each layer alone from its thinnest to its thickest, and some with all."""
    share = np.linspace(0.0, 1.0, count)
    rows = []
    for layer in _cloudy(plan):
        low, high = _range(plan, layer)
        ends = axis_of(plan.layers[layer], plan.assembly.profile.altitude_m).ends
        between = 0.5 * (ends[:-1] + ends[1:])
        rows.append(_alone(plan, layer, np.concatenate((low * (high / low) ** share, between))))
    if len(rows) > 1:
        pattern = np.array([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0], [0.3, 0.7]])
        rows.append(_together(plan, np.resize(pattern.T, (len(plan.layers), len(pattern))).T))
    return _stack(plan, rows)


def _trials(plan: Plan, count: int) -> Iterator[Array]:
    """Yield new thicknesses (N, L) without end."""
    start = 1
    while True:
        share = evenly(max(len(plan.layers), 2), start - 1, count)
        rows = [_alone(plan, layer, _within(plan, layer, share[:, 0])) for layer in _cloudy(plan)]
        if len(rows) > 1:
            rows.append(_together(plan, share))
        yield _stack(plan, rows)
        start += count


def _cloudy(plan: Plan) -> list[int]:
    return [layer for layer, cloudy in enumerate(plan.assembly.cloudy_layers) if cloudy]


def _range(plan: Plan, layer: int) -> tuple[float, float]:
    return plan.layers[layer].thickness_min_m, plan.layers[layer].thickness_max_m


def _alone(plan: Plan, layer: int, thickness_m: Array) -> Array:
    rows = np.zeros((thickness_m.size, len(plan.layers)))
    rows[:, layer] = thickness_m
    return rows


def _together(plan: Plan, share: Array) -> Array:
    """Columns (N, L) of all layers that can have cloud, from fractions (N, L) of their ranges."""
    columns: Array = np.sum([_alone(plan, n, _within(plan, n, share[:, n])) for n in _cloudy(plan)], axis=0)
    return columns


def _within(plan: Plan, layer: int, share: Array) -> Array:
    """Thicknesses between the layer's limits, partly logarithmic (opacity) and partly linear (cloud-top altitude)."""
    low, high = _range(plan, layer)
    by_factors = low * (high / low) ** share
    by_metres = low + (high - low) * share
    odd = np.arange(share.size) % 2 == 1
    result: Array = np.clip(np.where(odd, by_metres, by_factors), low, high)
    return result


def _stack(plan: Plan, rows: list[Array]) -> Array:
    return np.concatenate(rows) if rows else np.empty((0, len(plan.layers)))
