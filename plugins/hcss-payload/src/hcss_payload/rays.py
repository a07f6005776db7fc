"""Rays: where lines of sight meet the ellipsoid or the surface at a height above it."""

from __future__ import annotations

import numpy as np

from hcss_payload.earth import ECCENTRICITY_SQUARED, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_twin.providers import Array

_ITERATIONS = 8
"""Each reduces the error of the latitude by more than a factor of 100."""


def meet(origin_m: Array, direction: Array, altitude_m: float = 0.0) -> Array:
    """Return the first points (..., 3) that rays meet at an altitude; NaN for rays that miss it.

    The surface is the ellipsoid with both semi-axes longer by the altitude. It is exact for altitude 0; its altitude
    differs by less than altitude x flattening^2 / 2, 0.1 m at 15 km. Light is not refracted and not aberrated: this is
    the geometric line of sight.

    Parameters
    ----------
    origin_m : ndarray (3,) or (..., 3)
        Earth-fixed start of the rays, above the surface.
    direction : ndarray (..., 3)
        Earth-fixed unit vectors.
    """
    axes = np.array([SEMI_MAJOR_AXIS_M, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M]) + altitude_m
    start, step = origin_m / axes, direction / axes
    square = np.sum(step * step, axis=-1)
    half = -(step @ start) if start.ndim == 1 else -np.sum(step * start, axis=-1)
    # |start + s step|^2 = 1; the point closest to the centre decides, so that no difference of large squares does.
    closest = start + (half / square)[..., None] * step
    inside = (1.0 - np.sum(closest * closest, axis=-1)) / square
    distance = np.where(inside >= 0.0, half / square - np.sqrt(np.maximum(inside, 0.0)), np.nan)
    met: Array = origin_m + np.where(distance > 0.0, distance, np.nan)[..., None] * direction
    return met


def geographic(position_m: Array) -> tuple[Array, Array, Array]:
    """Return geodetic latitude and longitude in deg, and altitude in m, of positions (..., 3) outside the Earth.

    Bowring's iteration, as in :func:`hcss_twin.physics.geodesy.altitude_m`, for arrays.
    """
    x, y, z = np.moveaxis(position_m, -1, 0)
    across, ratio = np.hypot(x, y), SEMI_MINOR_AXIS_M / SEMI_MAJOR_AXIS_M
    second = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED)
    phi = np.arctan2(z, across * ratio**2)
    for _ in range(_ITERATIONS):
        reduced = np.arctan2(ratio * np.sin(phi), np.cos(phi))
        phi = np.arctan2(
            z + second * SEMI_MINOR_AXIS_M * np.sin(reduced) ** 3,
            across - ECCENTRICITY_SQUARED * SEMI_MAJOR_AXIS_M * np.cos(reduced) ** 3,
        )
    normal = SEMI_MAJOR_AXIS_M * np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(phi) ** 2)
    altitude = across * np.cos(phi) + z * np.sin(phi) - normal
    return np.degrees(phi), np.degrees(np.arctan2(y, x)), altitude
