"""Selection of the wavenumbers for the columns of a scene: fitted to some of its columns, tested on others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.error_norm import largest_error
from hcss_twin.engine.tables.thickness_axis import breakpoints
from hcss_twin.models.radiance.spectral_grid import SpectralNodes, all_nodes, choose_nodes
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun, View
from hcss_twin.providers.column_states import spectra_of

_SEED = 2**17


def checked_frames(parts: int, frames: int) -> list[int]:
    """Return one random frame from each of several equal parts of a sequence.

    The frames do not depend on the scenario's seed, so that the certificate can reuse solutions of the tables for the
    sun of a checked frame.

    Parameters
    ----------
    parts, frames : int
        1 to ``frames`` parts.
    """
    ends = np.arange(parts + 1) * frames // parts
    chosen: list[int] = np.random.default_rng(_SEED).integers(ends[:-1], ends[1:]).tolist()
    return chosen


FIRST_COLUMNS = 5
"""Number of thicknesses of each layer, in geometric progression, for the fit; one between any two levels is added."""

TRIED_COLUMNS = 8
"""Number of other thicknesses of each layer, and of both, for each test."""

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

_PLASTIC = 1.32471795724474602596
"""Real root of x^3 = x + 1."""


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
    plans = [plan]
    if plan.texture is not None and (plan.texture.water_vapour or not plan.texture.sea_is_proportional(plan.assembly)):
        states = ((1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
        plans += [replace(plan, assembly=plan.texture.perturbed(plan.assembly, state)) for state in states]
    first = _first_columns(plan)
    known = np.concatenate([_spectra(in_state, views, first, suns, skies) for in_state in plans])
    trials, heights = _trials(plan), CLEAR_SKIES if moves else 1
    for trial in range(MAX_TRIALS):
        nodes = choose_nodes(grid, known, CHOICE_SHARE * tolerance)
        if nodes.wavenumber_cm1.size == grid.wavenumber_cm1.size:
            break
        thickness = next(trials)
        count = TRIED_SUNS + trial
        between = _suns_over_time(plan, (np.arange(count) + 0.5) / count) if moves else suns
        skies = _suns(plan, heights + 1 + trial)
        tried = _spectra(plan, tested, thickness, between, skies)
        places = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
        total = np.sum(tried, axis=1)
        error = largest_error(total[:, places] @ nodes.weights_cm1.T, total @ grid.weights_cm1.T)
        if error <= TRIAL_SHARE * tolerance:
            return Spectrum(nodes, grid.wavenumber_cm1.size, tolerance)
        known = np.concatenate((known, tried))
    return Spectrum(all_nodes(grid), grid.wavenumber_cm1.size, 0.0)


def _spectra(
    plan: Plan, views: Sequence[View], thickness_m: Array, suns: Sequence[Sun | None], skies: Sequence[Sun | None]
) -> Array:
    """Terms (N, K, V) of cloudy columns under some suns, and of clear sky under others, toward each view."""
    scene, wavenumber = plan.assembly, plan.spectral_grid.wavenumber_cm1
    cloudless, spectra = np.zeros((1, len(plan.layers))), []
    for rows, under in ((thickness_m, suns), (cloudless, skies)):
        for some in scene.together(views or (plan.view,)):
            settings = [setting for view in some for sun in under for setting in scene.spanning(sun, view)]
            found = spectra_of(scene.model, settings, wavenumber, rows)
            spectra.append(found.reshape(-1, *found.shape[2:]))
    return np.concatenate(spectra)


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


def _first_columns(plan: Plan) -> Array:
    """Thicknesses (N, L): each layer alone from its thinnest to its thickest, and some with both."""
    share = np.linspace(0.0, 1.0, FIRST_COLUMNS)
    rows = []
    for layer in _cloudy(plan):
        low, high = _range(plan, layer)
        ends = np.array(breakpoints(plan.layers[layer], plan.assembly.profile.altitude_m))
        between = 0.5 * (ends[:-1] + ends[1:])
        rows.append(_alone(plan, layer, np.concatenate((low * (high / low) ** share, between))))
    if len(rows) > 1:
        rows.append(_both(plan, np.array([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0], [0.3, 0.7]])))
    return _stack(plan, rows)


def _trials(plan: Plan) -> Iterator[Array]:
    """Yield new thicknesses (N, L) without end."""
    start = 1
    while True:
        number = np.arange(start, start + TRIED_COLUMNS)
        # Kronecker sequence of powers of the plastic number: evenly distributed, without repetition.
        square = np.mod(0.5 + number[:, None] * _PLASTIC ** -np.array([1.0, 2.0]), 1.0)
        rows = [_alone(plan, layer, _within(plan, layer, square[:, 0])) for layer in _cloudy(plan)]
        if len(rows) > 1:
            rows.append(_both(plan, square))
        yield _stack(plan, rows)
        start += TRIED_COLUMNS


def _cloudy(plan: Plan) -> list[int]:
    return [layer for layer, cloudy in enumerate(plan.assembly.cloudy_layers) if cloudy]


def _range(plan: Plan, layer: int) -> tuple[float, float]:
    return plan.layers[layer].thickness_min_m, plan.layers[layer].thickness_max_m


def _alone(plan: Plan, layer: int, thickness_m: Array) -> Array:
    rows = np.zeros((thickness_m.size, len(plan.layers)))
    rows[:, layer] = thickness_m
    return rows


def _both(plan: Plan, share: Array) -> Array:
    """Columns (N, L) of two layers from fractions (N, 2) of their ranges."""
    return np.stack([_within(plan, layer, share[:, layer]) for layer in range(len(plan.layers))], axis=1)


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
