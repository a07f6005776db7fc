"""Combine runs at several heights and zenith angles into one atmosphere table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_modtran.spectral_path import SpectralPath, sine_deg
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.providers import EARTH_RADIUS_M, Array, CatalogError, Profile, planck

SPACE_FROM_M = 80_000.0
"""Altitude from which the upper end of a path counts as space."""

HEIGHT_TOLERANCE_M = 1.0
ZENITH_TOLERANCE_DEG = 0.05
"""Angles closer than this share a node: 0.2 % of the air mass at 60 deg."""

REFRACTIVITY = 2.726e-4
"""Of air at 15 degC and 1013.25 hPa in the infrared: B. Edlen, Metrologia 2, 71 (1966), long-wave limit."""

_ROUNDING = 2e-4
"""Maximum violation of monotonicity that rounding transmittance to four decimals can cause."""


@dataclass(frozen=True)
class Combined:
    """An atmosphere table and the checks that it passed, one line each for the terminal."""

    table: AtmosphereTable
    checks: tuple[str, ...]


@dataclass(frozen=True)
class _Placed:
    path: SpectralPath
    target_m: float
    zenith_deg: float
    seen_from_space: bool


def surface_zenith_deg(path: SpectralPath, profile: Profile) -> tuple[float, float]:
    """Return the target altitude of a path and its zenith angle where the straight path meets the surface.

    A ray that starts at the target already has the angle that the table uses. A ray that starts in space is traced down
    with the invariant n r sin(zenith) of a spherically layered atmosphere, where n = 1 in space and the refractivity at
    the target is proportional to pressure over temperature.

    Returns
    -------
    target_m, zenith_deg : float

    Raises
    ------
    CatalogError
        If the geometry is unknown or the path does not join a target and space.
    """
    geometry = path.geometry
    if geometry is None:
        raise CatalogError(
            f"{path.source}: the file does not give its line of sight; give --geometry H1_km,H2_km,ANGLE_deg"
        )
    if geometry.kind not in ("up", "down"):
        what = "is horizontal" if geometry.horizontal else "passes a tangent point or contradicts its own ends"
        raise CatalogError(f"{path.source} (line {path.line}): the path {what} ({geometry}); needed: target to space")
    if geometry.upper_m < SPACE_FROM_M:
        raise CatalogError(
            f"{path.source} (line {path.line}): the path ends at {geometry.upper_m / 1e3:g} km ({geometry}); it "
            f"must reach space: at least {SPACE_FROM_M / 1e3:g} km, usually 100"
        )
    target = geometry.lower_m
    at_target = EARTH_RADIUS_M + target
    if geometry.kind == "up" or not geometry.refracted:
        angle = geometry.angle_deg if geometry.kind == "up" else 180.0 - geometry.angle_deg
        sine = sine_deg(angle)
    else:
        density = float(profile.pressure_at(target)) / 101_325.0
        density *= 288.15 / float(profile.temperature_at(target))
        index = 1.0 + REFRACTIVITY * density
        sine = sine_deg(geometry.angle_deg) * (EARTH_RADIUS_M + geometry.upper_m) / (at_target * index)
    sine *= at_target / EARTH_RADIUS_M
    if sine >= 1.0:
        raise CatalogError(
            f"{path.source} (line {path.line}): the straight path ({geometry}) does not meet the surface"
        )
    return target, math.degrees(math.asin(sine))


def combine(paths: Sequence[SpectralPath], profile: Profile, resolution_cm1: float | None = None) -> Combined:
    """Combine runs; every height must have every zenith angle.

    Transmittance may come from runs in either direction, path radiance only from runs seen from space. The
    transmittance and the radiance of a node may come from different runs.

    Parameters
    ----------
    paths : sequence of SpectralPath
        As returned by the readers.
    profile : Profile
        Atmospheric profile of the runs.
    resolution_cm1 : float, optional
        Spectral resolution, where the files do not give it.

    Raises
    ------
    CatalogError
        If a path does not join a target and space, grids differ, nodes are missing or contradict each other, or the
        values are not physically possible for clear air.
    """
    if not paths:
        raise CatalogError("no runs to combine")
    wavenumber = _common_grid(paths)
    placed = [
        _Placed(path, *surface_zenith_deg(path, profile), path.geometry is not None and path.geometry.kind == "down")
        for path in paths
    ]
    heights = _nodes([path.target_m for path in placed], HEIGHT_TOLERANCE_M, 1)
    angles = _nodes([path.zenith_deg for path in placed], ZENITH_TOLERANCE_DEG, 3)
    spread = max(float(np.min(np.abs(angles - path.zenith_deg))) for path in placed)
    cells: dict[tuple[int, int], list[_Placed]] = {}
    for path in placed:
        key = (int(np.argmin(np.abs(heights - path.target_m))), int(np.argmin(np.abs(angles - path.zenith_deg))))
        cells.setdefault(key, []).append(path)
    _require_rectangle(cells, heights, angles)
    shape = (heights.size, angles.size, wavenumber.size)
    transmittance, radiance = np.zeros(shape), np.zeros(shape)
    for (row, column), runs in cells.items():
        transmittance[row, column] = _transmittance(runs)
        radiance[row, column] = _radiance(runs, transmittance[row, column], heights[row], angles[column])
    checks = [
        f"{len(paths)} runs: {heights.size} heights ({_listed(heights / 1e3)} km) x {angles.size} zenith angles "
        f"({_listed(angles)} deg) x {wavenumber.size} wavenumbers ({wavenumber[0]:g} to {wavenumber[-1]:g} cm-1)",
        f"angles snapped to common nodes: shifted by at most {spread:.3f} deg (allowed {ZENITH_TOLERANCE_DEG:g})",
        *_physical(wavenumber, transmittance, radiance, profile),
    ]
    resolutions = {path.resolution_cm1 for path in paths if path.resolution_cm1 is not None}
    if resolution_cm1 is None:
        if len(resolutions) > 1:
            raise CatalogError(f"the runs have different resolutions: {_listed(sorted(resolutions))} cm-1")
        step = float(np.max(np.diff(wavenumber)))
        resolution_cm1 = resolutions.pop() if resolutions else step
        checks.append(f"resolution {resolution_cm1:g} cm-1")
    codes = ", ".join(dict.fromkeys(path.code for path in paths))
    table = AtmosphereTable(
        heights, angles, wavenumber, transmittance, radiance, profile, resolution_cm1, f"imported: {codes}"
    )
    return Combined(table, tuple(checks))


def _common_grid(paths: Sequence[SpectralPath]) -> Array:
    first = paths[0]
    for path in paths[1:]:
        same = path.wavenumber_cm1.shape == first.wavenumber_cm1.shape
        if not same or not np.allclose(path.wavenumber_cm1, first.wavenumber_cm1, rtol=1e-6, atol=0):
            raise CatalogError(
                f"the runs have different wavenumbers: {first.source} {_extent(first)}, "
                f"{path.source} {_extent(path)}; run them on one grid"
            )
    return first.wavenumber_cm1


def _extent(path: SpectralPath) -> str:
    grid = path.wavenumber_cm1
    return f"{grid[0]:g} to {grid[-1]:g} cm-1 in {grid.size} points"


def _nodes(values: list[float], tolerance: float, digits: int) -> Array:
    """Group values within a tolerance; return the rounded mean of each group."""
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value - groups[-1][0] <= 2 * tolerance:
            groups[-1].append(value)
        else:
            groups.append([value])
    return np.array([round(float(np.mean(group)), digits) for group in groups])


def _require_rectangle(cells: dict[tuple[int, int], list[_Placed]], heights: Array, angles: Array) -> None:
    missing = [
        f"{heights[row] / 1e3:g} km at {angles[column]:g} deg"
        for row in range(heights.size)
        for column in range(angles.size)
        if (row, column) not in cells
    ]
    if missing:
        shown = "; ".join(missing[:12]) + (f"; and {len(missing) - 12} more" if len(missing) > 12 else "")
        raise CatalogError(
            f"{len(missing)} of {heights.size * angles.size} combinations of height and zenith angle are missing: "
            f"{shown}. Zenith angles apply where the straight path meets the surface: sin(angle at the target) = "
            "sin(zenith) R / (R + height)"
        )


def _transmittance(runs: list[_Placed]) -> Array:
    known = [(run.path, run.path.transmittance) for run in runs]
    given = [(path, tau) for path, tau in known if tau is not None]
    if not given:
        raise CatalogError(f"{runs[0].path.source} ({runs[0].path.geometry}): no run gives the transmittance")
    # Radiance runs print more digits.
    given.sort(key=lambda pair: pair[0].path_radiance is None)
    for path, tau in given[1:]:
        worst = float(np.max(np.abs(tau - given[0][1])))
        if worst > 2e-3:
            raise CatalogError(
                f"{path.source} and {given[0][0].source} are the same path ({path.geometry}) but their "
                f"transmittances differ by up to {worst:.3g}"
            )
    return given[0][1]


def _radiance(runs: list[_Placed], transmittance: Array, height_m: float, zenith_deg: float) -> Array:
    radiances = []
    for run in runs:
        path = run.path
        if not run.seen_from_space:
            continue
        if path.path_radiance is not None:
            radiances.append(path.path_radiance)
        elif path.total_radiance is not None and path.surface_temperature_K is not None:
            surface = transmittance * planck(path.wavenumber_cm1, path.surface_temperature_K)
            # Where the air emits nothing, the difference is rounding error of either sign.
            radiances.append(np.maximum(path.total_radiance - surface, 0.0))
    if not radiances:
        raise CatalogError(
            f"{height_m / 1e3:g} km at {zenith_deg:g} deg: no run gives the thermal path radiance seen from space; "
            "add a radiance run (MODTRAN IEMSCT 1 or 2) with the observer at 100 km looking down"
        )
    if len(radiances) > 1:
        names = " and ".join(run.path.source for run in runs if run.seen_from_space)
        raise CatalogError(f"{height_m / 1e3:g} km at {zenith_deg:g} deg: given twice, by {names}")
    return radiances[0]


def _physical(wavenumber: Array, transmittance: Array, radiance: Array, profile: Profile) -> list[str]:
    """Check the values against the physics of a clear atmosphere; raise an error at the first violation."""
    lines = [f"transmittance {transmittance.min():.4f} to {transmittance.max():.4f}"]
    for axis, text, sign in ((1, "rises with zenith angle", 1.0), (0, "falls with target height", -1.0)):
        change = sign * np.diff(transmittance, axis=axis)
        worst = float(change.max()) if change.size else 0.0
        if worst > _ROUNDING:
            at = wavenumber[np.unravel_index(int(np.argmax(change)), change.shape)[2]]
            raise CatalogError(f"transmittance {text} by {worst:.3g} at {at:g} cm-1; runs are mislabelled")
        if change.size:
            lines.append(f"transmittance never {text} (largest step in the wrong direction {max(worst, 0.0):.1e})")
    warmest = float(profile.temperature_K[profile.altitude_m <= 60_000.0].max())
    black = planck(wavenumber, warmest)
    excess = radiance - (1.0 - transmittance + _ROUNDING) * black * 1.02
    if np.any(excess > 0):
        at = np.unravel_index(int(np.argmax(excess / black)), excess.shape)
        raise CatalogError(
            f"path radiance {radiance[at]:.3g} W m-2 sr-1 (cm-1)-1 at {wavenumber[at[2]]:g} cm-1 is more than "
            f"(1 - T) B({warmest:.1f} K) of the warmest level of profile '{profile.name}' allows; wrong unit or "
            "wrong profile"
        )
    lines.append(f"path radiance never above (1 - T) B({warmest:.1f} K), the warmest level of '{profile.name}'")
    return lines


def _listed(values: Sequence[float] | Array) -> str:
    shown = [f"{value:g}" for value in values]
    return ", ".join(shown) if len(shown) <= 8 else f"{', '.join(shown[:3])} ... {shown[-1]}"
