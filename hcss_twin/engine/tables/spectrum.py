"""The wavenumbers at which columns of a scene are computed: chosen on some of its columns, tried on others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.thickness_axis import breakpoints
from hcss_twin.models.radiance.spectral_grid import SpectralNodes, all_nodes, choose_nodes
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun

_SEED = 2**17


def checked_frames(parts: int, frames: int) -> list[int]:
    """Return one frame at random of each of equal parts of a sequence.

    They do not depend on the scenario's seed, so that what the tables solve for the sun of a checked frame serves the
    certificate as well.

    Parameters
    ----------
    parts, frames : int
        1 to ``frames`` parts.
    """
    ends = np.arange(parts + 1) * frames // parts
    chosen: list[int] = np.random.default_rng(_SEED).integers(ends[:-1], ends[1:]).tolist()
    return chosen


FIRST_COLUMNS = 5
"""Thicknesses of each layer, by factors, on which wavenumbers are chosen beside one between any two levels."""

TRIED_COLUMNS = 8
"""Other thicknesses of each layer, and of both, on which each choice is tried."""

CHOICE_SHARE, TRIAL_SHARE = 0.2, 0.4
"""Shares of the tolerance that columns known to the choice, and those it is tried on, may use."""

CLEAR_SKIES = 5
"""Heights of the sun over clear skies on which wavenumbers are chosen; one where it hardly moves."""

SUN_DEG_PER_TOLERANCE = 200.0
"""Where light is scattered by an angle of a rainbow, weights fitted for one sun lose up to 3e-3 per degree."""

TRIED_SUNS = 2
"""Suns between those of the choice, on which it is tried where the sun moves."""

MAX_TRIALS = 6
"""Choices before all wavenumbers are taken."""

_PLASTIC = 1.32471795724474602596
"""Real root of x^3 = x + 1."""


@dataclass(frozen=True)
class Spectrum:
    """The wavenumbers behind each column of the radiance tables.

    Attributes
    ----------
    dense : int
        Wavenumbers of the grid they were chosen from.
    estimated_error : float
        Of the total of any band, relative: the tolerance, of which columns that the choice did not know used less
        than ``TRIAL_SHARE``; 0 where nothing was left out.
    """

    nodes: SpectralNodes
    dense: int
    estimated_error: float


def choose_spectrum(plan: Plan, tolerance: float) -> Spectrum:
    """Choose weighted wavenumbers for all columns of a scene.

    Columns under the first, middle and last sun, or that of a frame which the certificate checks if it hardly moves,
    clear and with clouds from the thinnest to the thickest, are computed at every wavenumber of the dense grid; clear
    skies under more suns, if it moves. The choice is tried on clouds of other thickness under suns between, if it
    moves, and on clear skies under other suns, among them the highest and the lowest; those that it fails are added to
    what it is made from, and it is tried again on yet others.

    Parameters
    ----------
    tolerance : float
        Relative to the total of each band.
    """
    grid = plan.spectral_grid
    moves = _sun_moves(plan, tolerance)
    suns = _suns_over_time(plan, np.linspace(0.0, 1.0, 3)) if moves else _suns_that_hardly_move(plan)
    known = np.concatenate(
        [
            *(_cloudy_spectra(plan, _first_columns(plan), sun) for sun in suns),
            *(_clear_spectra(plan, sun) for sun in (_suns(plan, CLEAR_SKIES) if moves else suns)),
        ]
    )
    trials, heights = _trials(plan), CLEAR_SKIES if moves else 1
    for trial in range(MAX_TRIALS):
        nodes = choose_nodes(grid, known, CHOICE_SHARE * tolerance)
        if nodes.wavenumber_cm1.size == grid.wavenumber_cm1.size:
            break
        thickness = next(trials)
        count = TRIED_SUNS + trial
        others = _suns_over_time(plan, (np.arange(count) + 0.5) / count) if moves else suns
        tried = np.concatenate(
            [
                *(_cloudy_spectra(plan, thickness, sun) for sun in others),
                *(_clear_spectra(plan, sun) for sun in _suns(plan, heights + 1 + trial)),
            ]
        )
        places = np.searchsorted(grid.wavenumber_cm1, nodes.wavenumber_cm1)
        total = np.sum(tried, axis=1)
        exact = total @ grid.weights_cm1.T
        away, lit = np.abs(total[:, places] @ nodes.weights_cm1.T - exact), exact > 0.0
        error = float(np.max(away[lit] / exact[lit], initial=0.0)) if np.all(away[~lit] == 0.0) else np.inf
        if error <= TRIAL_SHARE * tolerance:
            return Spectrum(nodes, grid.wavenumber_cm1.size, tolerance)
        known = np.concatenate((known, tried))
    return Spectrum(all_nodes(grid), grid.wavenumber_cm1.size, 0.0)


def _sun_moves(plan: Plan, tolerance: float) -> bool:
    """Whether its height, or the angle by which light is scattered, changes more than the tolerance makes up for."""
    up = plan.sun_zenith_deg < 90.0
    if not plan.sun_matters or not np.any(up):
        return False
    sun, turn = (np.radians(plan.sun_zenith_deg[up]), np.radians(plan.sun_azimuth_deg[up] - plan.view.azimuth_deg))
    view = np.radians(plan.view.zenith_deg)
    toward_sun = np.cos(view) * np.cos(sun) + np.sin(view) * np.sin(sun) * np.cos(turn)
    scattered = np.arccos(np.clip(-toward_sun, -1.0, 1.0))
    return bool(np.degrees(max(np.ptp(sun), np.ptp(scattered))) > SUN_DEG_PER_TOLERANCE * tolerance)


def _suns_over_time(plan: Plan, shares: Array) -> list[Sun | None]:
    """Return the sun at shares of the frames that have it, from the first to the last, and none if frames have none."""
    up = np.flatnonzero(plan.sun_zenith_deg < 90.0)
    frames = np.unique(up[(shares * (up.size - 1)).round().astype(np.intp)])
    suns = [plan.sun_at(float(plan.frame_times_s[frame])) for frame in frames]
    return suns if up.size == plan.sun_zenith_deg.size else [*suns, None]


def _suns(plan: Plan, count: int) -> list[Sun | None]:
    """Return the sun at ``count`` of its heights, the highest first, and none where frames have none."""
    up = np.flatnonzero(plan.sun_zenith_deg < 90.0)
    by_height = up[np.argsort(plan.sun_zenith_deg[up], kind="stable")]
    places = np.linspace(0, max(up.size - 1, 0), min(count, up.size)).round().astype(int)
    suns = [plan.sun_at(float(plan.frame_times_s[frame])) for frame in by_height[np.unique(places)]]
    return suns if up.size == plan.sun_zenith_deg.size else [*suns, None]


def _suns_that_hardly_move(plan: Plan) -> list[Sun | None]:
    """Return that of a frame which the certificate checks, and none beside it where other frames have none."""
    others = _suns(plan, 1)
    frame = checked_frames(1, plan.frame_times_s.size)[0]
    if plan.sun_zenith_deg[frame] >= 90.0:
        return others
    return [plan.sun_at(float(plan.frame_times_s[frame])), *(sun for sun in others if sun is None)]


def _clear_spectra(plan: Plan, sun: Sun | None) -> Array:
    """Terms of the clear column, (1, K, V)."""
    spectra = plan.assembly.model.clear(plan.spectral_grid.wavenumber_cm1, sun)
    return np.stack([np.asarray(spectra[name]) for name in plan.assembly.model.terms])[None]


def _cloudy_spectra(plan: Plan, thickness_m: Array, sun: Sun | None) -> Array:
    """Terms of cloudy columns (N, L), (N, K, V)."""
    wavenumber, terms = plan.spectral_grid.wavenumber_cm1, plan.assembly.model.terms
    if not thickness_m.size:
        return np.empty((0, len(terms), wavenumber.size))
    spectra = plan.assembly.model.cloudy(wavenumber, thickness_m, sun)
    return np.stack([np.asarray(spectra[name]) for name in terms], axis=1)


def _first_columns(plan: Plan) -> Array:
    """Thicknesses (N, L): each layer alone from its thinnest to its thickest, and some of both."""
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
    """Yield thicknesses (N, L) that were not there before, without end."""
    start = 1
    while True:
        number = np.arange(start, start + TRIED_COLUMNS)
        # Kronecker sequence of the plastic number's powers: even, and never the same twice.
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
    """Columns (N, L) of two layers from shares (N, 2) of their ranges."""
    return np.stack([_within(plan, layer, share[:, layer]) for layer in range(len(plan.layers))], axis=1)


def _within(plan: Plan, layer: int, share: Array) -> Array:
    """Thicknesses between the layer's limits: clouds turn opaque by factors, and their tops rise by metres."""
    low, high = _range(plan, layer)
    by_factors = low * (high / low) ** share
    by_metres = low + (high - low) * share
    odd = np.arange(share.size) % 2 == 1
    result: Array = np.clip(np.where(odd, by_metres, by_factors), low, high)
    return result


def _stack(plan: Plan, rows: list[Array]) -> Array:
    return np.concatenate(rows) if rows else np.empty((0, len(plan.layers)))
