"""Between the Earth and the plane of the scene, in which clouds, surfaces and elements are defined."""

from __future__ import annotations

import numpy as np

from hcss_payload.earth import MEAN_EARTH_RADIUS_M, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import Array

FARTHEST_DEG = 85.0
"""Greatest angle from the centre of the plane, at which it is stretched across by half."""

_PLACED_M, _ITERATIONS = 0.1, 30
"""Largest last step, of which less than one in 500 is wrong, m, and number of steps."""


def surface_place(position_m: Array, altitude_m: float = 0.0) -> tuple[Array, Array]:
    """Return geodetic latitude and longitude (deg) of positions (..., 3) on the ellipsoid, or at an altitude above it.

    Positions are those of :func:`hcss_payload.rays.meet`: on an ellipsoid with both semi-axes longer by the altitude,
    whose normals differ from the vertical by less than 0.1 m at 15 km. With those of the ellipsoid itself, places below
    clouds at 10 km would be up to 33 m too far north.
    """
    x, y, z = np.moveaxis(position_m, -1, 0)
    ratio = (SEMI_MINOR_AXIS_M + altitude_m) / (SEMI_MAJOR_AXIS_M + altitude_m)
    return np.degrees(np.arctan2(z, np.hypot(x, y) * ratio**2)), np.degrees(np.arctan2(y, x))


def to_scene(latitude_deg: Array, longitude_deg: Array, centre: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Return x and y (m) of places in the plane centred on a place, and the bearing (deg) of its y axis there.

    The iteration of :func:`hcss_twin.physics.geodesy.Ellipsoid.to_plane`, begun on the sphere, with steps across as
    long as the plane is stretched there: each reduces the error by about the flattening. Places farther than
    ``FARTHEST_DEG`` from the centre are NaN.
    """
    latitude, longitude = centre
    target = Ellipsoid.to_earth_centred(latitude_deg, longitude_deg)
    east, north, up = (axis for axis in Ellipsoid.east_north_up(np.float64(latitude), np.float64(longitude)))  # type: ignore[arg-type]
    toward = np.stack(Ellipsoid.east_north_up(latitude_deg, longitude_deg)[2:], axis=0)[0]
    right, ahead = toward @ east, toward @ north
    angle = np.arctan2(np.hypot(right, ahead), toward @ up)
    far = angle > np.radians(FARTHEST_DEG)
    scale = MEAN_EARTH_RADIUS_M * angle / np.maximum(np.hypot(right, ahead), 1e-300)
    x, y = np.where(far, 0.0, right * scale), np.where(far, 0.0, ahead * scale)
    for _ in range(_ITERATIONS):
        at_latitude, at_longitude, turn = Ellipsoid.to_geographic_with_turn(x, y, latitude, longitude)
        rest = target - Ellipsoid.to_earth_centred(at_latitude, at_longitude)
        toward_east, toward_north, _ = Ellipsoid.east_north_up(at_latitude, at_longitude)
        right, ahead = np.sum(rest * toward_east, axis=-1), np.sum(rest * toward_north, axis=-1)
        sine, cosine = np.sin(np.radians(turn)), np.cos(np.radians(turn))
        moved = np.where(far, 0.0, np.hypot(right, ahead))
        step_x, step_y = right * cosine - ahead * sine, right * sine + ahead * cosine
        distance = np.maximum(np.hypot(x, y), 1e-9)
        along_x, along_y = x / distance, y / distance
        across = step_y * along_x - step_x * along_y
        stretched = across * (distance / MEAN_EARTH_RADIUS_M / np.sin(distance / MEAN_EARTH_RADIUS_M) - 1.0)
        x, y = x + step_x - stretched * along_y, y + step_y + stretched * along_x
        if np.all(moved < _PLACED_M):
            break
        x, y = np.where(far, 0.0, x), np.where(far, 0.0, y)
    nothing = np.where(far, np.nan, 0.0)
    return x + nothing, y + nothing, turn + nothing


def toward_camera(position_m: Array, camera_m: Array, centre: tuple[float, float]) -> Array:
    """Return directions (..., 3) from positions (..., 3) on the ellipsoid to the camera, along the scene's axes.

    Azimuths count from the plane's y axis, as those of the sun and the wind at its centre.
    """
    latitude, longitude = surface_place(position_m)
    _, _, turn = to_scene(latitude, longitude, centre)
    ray = camera_m - position_m
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    east, north, up = (np.sum(axis * ray, axis=-1) for axis in Ellipsoid.east_north_up(latitude, longitude))
    sine, cosine = np.sin(np.radians(turn)), np.cos(np.radians(turn))
    return np.stack((east * cosine - north * sine, east * sine + north * cosine, up), axis=-1)
