"""Radiance of voxel clouds by backward Monte Carlo.

Photons start at the sensor. At every collision the Planck radiance counts with the share that is absorbed there, and
sunlight that is scattered toward the sensor with the exact transmission toward the sun (local estimate): only paths
are random. Rays cross voxel by voxel. Nothing is shared with the solvers of hcss_twin.

References
----------
Method: A. Marshak and A. Davis (ed.), "3D Radiative Transfer in Cloudy Atmospheres", Springer 2005, chapter 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_light.sea_surface import RoughSea, glint, mirror
from hcss_light.voxels import LightError, ScatteringTable, Voxels
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

_COLLISION, _TOP, _SURFACE = 0, 1, 2
_FAINT, _SURVIVAL = 1e-3, 0.1
"""Photons below the first weight go on with the second probability, and its inverse as factor (Russian roulette)."""

HORIZONTAL = 1e-4
"""Least cosine of the zenith angle of view and sun."""


@dataclass(frozen=True)
class Sunlight:
    """Direct sunlight.

    Parameters
    ----------
    zenith_deg : float
        Of the sun.
    azimuth_deg : float
        Direction from which it comes, from +x toward +y.
    irradiance : float
        On a surface that faces it.
    """

    zenith_deg: float
    azimuth_deg: float
    irradiance: float


def radiance(
    voxels: Voxels,
    scattering: ScatteringTable | Sequence[ScatteringTable],
    *,
    view_zenith_deg: float | None,
    view_azimuth_deg: float = 0.0,
    sun: Sunlight | None = None,
    photons: int = 10_000,
    seed: int = 0,
    columns: NDArray[np.int64] | None = None,
    displaced_m: tuple[float, float] = (0.0, 0.0),
    sea: RoughSea | None = None,
) -> tuple[Array, Array]:
    """Return the radiance that leaves the top of each column, and its standard error, (X, Y) or (N,).

    Parameters
    ----------
    scattering : ScatteringTable or sequence of ScatteringTable
        By the kind of the voxels' levels, all with as many points.
    view_zenith_deg : float or None
        Of the sensor, seen from the clouds. None: random directions by Lambert's law, whose mean times pi is the flux.
    view_azimuth_deg : float
        Direction toward the sensor, from +x toward +y.
    photons : int
        For each column, evenly over its area.
    columns : ndarray of int (N, 2), optional
        Which columns; all by default.
    displaced_m : (float, float)
        By how much the areas at the top are displaced along x and y from the columns of the highest level.
    sea : RoughSea, optional
        Below, instead of the Lambertian surface; it has the same Planck radiance.

    Raises
    ------
    LightError
        If the view or the sun is not above the horizon, or a number is out of range.
    """
    toward = (
        np.array([0.0, 0.0, 0.0]) if view_zenith_deg is None else _direction("view", view_zenith_deg, view_azimuth_deg)
    )
    to_sun, irradiance = np.array([0.0, 0.0, 1.0]), 0.0
    if sun is not None:
        to_sun, irradiance = _direction("sun", sun.zenith_deg, sun.azimuth_deg), sun.irradiance
    if not 2 <= photons <= 10**9:
        raise LightError(f"photons: {photons}; allowed: 2 to 1e9; closest is {min(max(photons, 2), 10**9)}")
    if not 0 <= seed < 2**32:
        raise LightError(f"seed: {seed}; allowed: 0 to 2^32 - 1")
    shape = voxels.extinction.shape[:2]
    places = np.stack(np.unravel_index(np.arange(shape[0] * shape[1]), shape), axis=1) if columns is None else columns
    mean, error = np.empty(len(places)), np.empty(len(places))
    tables = [scattering] if isinstance(scattering, ScatteringTable) else list(scattering)
    assert voxels.kind is not None
    if len(tables) <= np.max(voxels.kind) or len({table.cosine.size for table in tables}) > 1:
        raise LightError(f"scattering: {len(tables)} tables; allowed: one for each kind, all of the same size")
    air = (
        voxels.extinction,
        voxels.per,
        voxels.gas,
        voxels.source,
        voxels.edges_m,
        voxels.moved_m,
        *voxels.size_m,
        voxels.albedo,
    )
    borders = voxels.surface_albedo, voxels.surface_source, voxels.sky_source
    of_kinds = zip(*((table.cosine, table.phase, table.cumulative) for table in tables), strict=True)
    angles = voxels.kind, *(np.stack(kind) for kind in of_kinds)
    light = toward, view_zenith_deg is None, to_sun, float(irradiance)
    waves = (0.0, 2.0, 0.0) if sea is None else (0.5 * sea.mean_square_slope, sea.index, sea.strength)
    # In one order of memory: another one is another compilation.
    starts = (places + np.array(displaced_m) / np.array(voxels.size_m)).astype(np.float64, order="C")
    _trace_all(mean, error, starts, *air, *borders, *waves, *angles, *light, photons, np.random.default_rng(seed))
    return (mean.reshape(shape), error.reshape(shape)) if columns is None else (mean, error)


def _direction(name: str, zenith_deg: float, azimuth_deg: float) -> Array:
    zenith, azimuth = np.radians(zenith_deg), np.radians(azimuth_deg)
    up = np.cos(zenith)
    if not (np.isfinite(azimuth) and up >= HORIZONTAL):
        raise LightError(f"{name}: zenith {zenith_deg} deg, azimuth {azimuth_deg} deg; allowed: above the horizon")
    return np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), up])


@kernel(inner=True)
def _cross(
    at: Any, along: Any, depth: float, extinction: Any, per: Any, gas: Any, edges: Any, moved: Any, side_x: float,
    side_y: float,
) -> Any:  # fmt: skip
    """Move ``at``, counted from the columns of its level, until an optical thickness is reached or the layer ends.

    Returns which of both, the level, its extinction by particles, and the optical thickness on the way.
    """
    count_x, count_y, levels = extinction.shape
    i, j = int(np.floor(at[0] / side_x)), int(np.floor(at[1] / side_y))
    k = min(max(np.searchsorted(edges, at[2], side="right") - 1, 0), levels - 1)
    if at[2] == edges[k] and along[2] < 0.0 and k > 0:
        k -= 1
    passed = 0.0
    while True:
        to_x = to_y = to_z = np.inf
        if along[0] > 0.0:
            to_x = ((i + 1) * side_x - at[0]) / along[0]
        elif along[0] < 0.0:
            to_x = (i * side_x - at[0]) / along[0]
        if along[1] > 0.0:
            to_y = ((j + 1) * side_y - at[1]) / along[1]
        elif along[1] < 0.0:
            to_y = (j * side_y - at[1]) / along[1]
        if along[2] > 0.0:
            to_z = (edges[k + 1] - at[2]) / along[2]
        elif along[2] < 0.0:
            to_z = (edges[k] - at[2]) / along[2]
        step = max(min(to_x, to_y, to_z), 0.0)
        cloud_extinction = extinction[i % count_x, j % count_y, k] * per[k]
        total = cloud_extinction + gas[k]
        if passed + total * step >= depth:
            for axis in range(3):
                at[axis] += along[axis] * (depth - passed) / total
            return _COLLISION, k, cloud_extinction, depth
        passed += total * step
        for axis in range(3):
            at[axis] += along[axis] * step
        if to_z <= to_x and to_z <= to_y:
            k += 1 if along[2] > 0.0 else -1
            if k < 0 or k >= levels:
                at[2] = edges[0] if k < 0 else edges[levels]
                return (_SURFACE if k < 0 else _TOP), k, cloud_extinction, passed
            at[2] = edges[k] if along[2] > 0.0 else edges[k + 1]
            left = k - 1 if along[2] > 0.0 else k + 1
            if moved[k, 0] != moved[left, 0] or moved[k, 1] != moved[left, 1]:
                at[0] += moved[left, 0] - moved[k, 0]
                at[1] += moved[left, 1] - moved[k, 1]
                i, j = int(np.floor(at[0] / side_x)), int(np.floor(at[1] / side_y))
        elif to_x <= to_y:
            i += 1 if along[0] > 0.0 else -1
            at[0] = i * side_x if along[0] > 0.0 else (i + 1) * side_x
        else:
            j += 1 if along[1] > 0.0 else -1
            at[1] = j * side_y if along[1] > 0.0 else (j + 1) * side_y


@kernel(inner=True)
def _turn(along: Any, cosine: float, draw: Any) -> None:
    """Turn a direction by a scattering angle into a random plane."""
    azimuth, sine = 2.0 * np.pi * draw.random(), np.sqrt(max(0.0, 1.0 - cosine * cosine))
    x, y, z = along[0], along[1], along[2]
    # An orthonormal frame without a pole.
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    p, q = sine * np.cos(azimuth), sine * np.sin(azimuth)
    along[0] = p * (1.0 + sign * x * x * a) + q * b + cosine * x
    along[1] = p * sign * b + q * (sign + y * y * a) + cosine * y
    along[2] = -p * sign * x - q * y + cosine * z
    norm = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
    for axis in range(3):
        along[axis] /= norm


@kernel(inner=True)
def _draw_cosine(cosine: Any, phase: Any, cumulative: Any, draw: Any) -> float:
    """Return a random cosine by a phase function that is linear between its points."""
    share = draw.random()
    n = min(np.searchsorted(cumulative, share, side="right") - 1, cosine.size - 2)
    width, low, high = cosine[n + 1] - cosine[n], phase[n], phase[n + 1]
    part = (share - cumulative[n]) / (cumulative[n + 1] - cumulative[n])
    # Root of low s + (high - low) s^2 / 2 = part (low + high) / 2.
    root = part * (low + high) / (low + np.sqrt(low * low + part * (high * high - low * low)))
    drawn: float = min(max(cosine[n] + width * root, -1.0), 1.0)
    return drawn


@kernel()
def _trace_all(
    mean: Any, error: Any, starts: Any, extinction: Any, per: Any, gas: Any, source: Any, edges: Any, moved: Any,
    side_x: float, side_y: float, albedo: Any, surface_albedo: float, surface_source: float, sky_source: float,
    slopes: float, index: float, strengthened: float, kind: Any, cosine: Any, phase: Any, cumulative: Any,
    toward: Any, by_lambert: bool, to_sun: Any, irradiance: float, photons: int, draw: Any,
) -> None:  # fmt: skip
    at, along, shadow = np.empty(3), np.empty(3), np.empty(3)
    air = extinction, per, gas, edges, moved, side_x, side_y
    for n in range(mean.size):
        total = squares = 0.0
        for _ in range(photons):
            at[0], at[1] = (starts[n, 0] + draw.random()) * side_x, (starts[n, 1] + draw.random()) * side_y
            at[2], seen, weight = edges[-1], 0.0, 1.0
            if by_lambert:
                up, turned = np.sqrt(draw.random()), 2.0 * np.pi * draw.random()
                across = np.sqrt(1.0 - up * up)
                along[0], along[1], along[2] = across * np.cos(turned), across * np.sin(turned), -max(up, 1e-9)
            else:
                along[:] = -toward
            while True:
                depth = -np.log(1.0 - draw.random())
                event, k, cloud_extinction, _ = _cross(at, along, depth, *air)
                if event == _TOP:
                    seen += weight * sky_source
                    break
                if event == _SURFACE and slopes > 0.0:
                    if irradiance > 0.0:
                        sunlit = weight * strengthened * irradiance * glint(-along, to_sun, slopes, index)
                        shadow[:] = at
                        _, _, _, depth = _cross(shadow, to_sun, np.inf, *air)
                        seen += sunlit * np.exp(-depth)
                    area, reflected = mirror(along, slopes, index, draw)
                    if along[2] <= 1e-6:
                        reflected = 0.0
                    seen += weight * area * (1.0 - reflected) * surface_source
                    weight *= area * reflected
                    strength = 0.0
                elif event == _SURFACE:
                    seen += weight * (1.0 - surface_albedo) * surface_source
                    weight *= surface_albedo
                    strength = to_sun[2] / np.pi
                else:
                    scattered = albedo[k] * cloud_extinction / (cloud_extinction + gas[k])
                    seen += weight * (1.0 - scattered) * source[k]
                    weight *= scattered
                    # Backward: the angle between the photon's way to the sensor and the sun's rays.
                    angle = along[0] * to_sun[0] + along[1] * to_sun[1] + along[2] * to_sun[2]
                    strength = np.interp(angle, cosine[kind[k]], phase[kind[k]]) / (4.0 * np.pi)
                if weight <= 0.0:
                    break
                if irradiance > 0.0 and strength > 0.0:
                    shadow[:] = at
                    _, _, _, depth = _cross(shadow, to_sun, np.inf, *air)
                    seen += weight * strength * irradiance * np.exp(-depth)
                if weight < _FAINT:
                    if draw.random() >= _SURVIVAL:
                        break
                    weight /= _SURVIVAL
                if event == _SURFACE and slopes > 0.0:
                    continue
                if event == _SURFACE:
                    up, turned = np.sqrt(1.0 - draw.random()), 2.0 * np.pi * draw.random()
                    across = np.sqrt(max(0.0, 1.0 - up * up))
                    along[0], along[1], along[2] = across * np.cos(turned), across * np.sin(turned), max(up, 1e-9)
                else:
                    _turn(along, _draw_cosine(cosine[kind[k]], phase[kind[k]], cumulative[kind[k]], draw), draw)
            total += seen
            squares += seen * seen
        mean[n] = total / photons
        error[n] = np.sqrt(max(squares / photons - mean[n] ** 2, 0.0) / (photons - 1))
