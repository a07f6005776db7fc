"""Fast way from Earth-fixed positions to the plane of the scene: a polynomial over the region of a pass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError
from hcss_payload.earth import SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_payload.rays import geographic
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import Array

_DEGREES = (5, 7, 9, 11, 13)
_POINTS = 40


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """Polynomials that give x and y in the plane of the scene, for positions at one altitude.

    Attributes
    ----------
    axes : ndarray (3,)
        Semi-axes of the ellipsoid at the altitude.
    frame : ndarray (3, 3)
        Centre of the region, and the directions east and north over half the size of the region.
    powers : ndarray of int64 (K, 2)
        Exponents of east and north.
    coefficients : ndarray (K, 2)
        Of x and y, m.
    error_m : float
        Largest error at points between those of the fit.
    """

    axes: Array
    frame: Array
    powers: NDArray[np.int64]
    coefficients: Array
    error_m: float


def fit_plane(
    position_m: Array, altitude_m: float, latitude: float, longitude: float, allowed_m: float, margin_m: float
) -> PlaneFit:
    """Fit the plane of a scene over the region of positions.

    Parameters
    ----------
    position_m : ndarray (N, 3)
        Earth-fixed, at the altitude.
    latitude, longitude : float
        Centre of the scene.
    allowed_m : float
        Largest error.
    margin_m : float
        What is added all around at least; a third of the size of the region if that is more.

    Raises
    ------
    PayloadError
        If no polynomial is accurate, because the region is too large.
    """
    axes = np.array([SEMI_MAJOR_AXIS_M, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M]) + altitude_m
    middle = 0.5 * (position_m.min(axis=0) + position_m.max(axis=0))
    middle = _on_surface(middle, axes)
    at_latitude, at_longitude, _ = geographic(middle)
    east, north, up = Ellipsoid.east_north_up(at_latitude, at_longitude)
    away = position_m - middle
    size = float(max(np.abs(away @ east).max(), np.abs(away @ north).max()))
    half = size + max(size / 3.0, margin_m)
    frame = np.stack((middle, east / half, north / half))

    def sampled(count: int) -> tuple[Array, Array, Array]:
        nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        x, y = (coordinate.ravel() for coordinate in np.meshgrid(nodes, nodes))
        flat = middle + half * (x[:, None] * east + y[:, None] * north)
        # Down to the surface along the local vertical; a few steps, since it is curved.
        for _ in range(20):
            height = np.linalg.norm(flat / axes, axis=-1) - 1.0
            flat = flat - (height * SEMI_MAJOR_AXIS_M)[:, None] * up
        place_latitude, place_longitude, _ = geographic(flat)
        try:
            position = np.stack(Ellipsoid.to_plane(place_latitude, place_longitude, latitude, longitude), axis=-1)
        except ValueError as error:
            raise PayloadError(f"trajectory: the pass sees {error}") from error
        away = flat - middle
        return away @ (east / half), away @ (north / half), position

    known, others = sampled(_POINTS), sampled(_POINTS - 3)
    error_m = np.inf
    for degree in _DEGREES:
        powers = np.array([(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)], dtype=np.int64)
        fit = np.linalg.lstsq(_terms(known[0], known[1], powers), known[2], rcond=None)[0]
        error_m = float(np.abs(_terms(others[0], others[1], powers) @ fit - others[2]).max())
        if error_m <= allowed_m:
            return PlaneFit(axes, frame, powers, np.ascontiguousarray(fit), error_m)
    raise PayloadError(
        f"start_s, end_s: the camera sees {2e-3 * half:.4g} km of the Earth, for which places err by {error_m:.2g} m; "
        f"allowed: {allowed_m:.2g} m, with shorter passes"
    )


def _on_surface(position_m: Array, axes: Array) -> Array:
    scaled: Array = position_m / np.linalg.norm(position_m / axes)
    return scaled


def _terms(east: Array, north: Array, powers: NDArray[np.int64]) -> Array:
    terms: Array = east[:, None] ** powers[:, 0] * north[:, None] ** powers[:, 1]
    return terms
