"""Directions toward a camera that stands still above the Earth: each is that of one place, with its own sun and air.

From a geostationary orbit the direction from a place to the camera tells the place. Tables toward directions are then
tables of places, and radiance differs over the disk by view, sun, air and sea at once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from functools import lru_cache

import numpy as np

from hcss_payload.directions import PADDING
from hcss_payload.earth import SEMI_MAJOR_AXIS_M
from hcss_payload.scene_plane import surface_place, toward_camera
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.sun import sun_position
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.providers import Array, Sun, View

_FOUND, _STEPS = 1e-9, 60
"""Largest error of a direction whose place is sought, rad, and number of steps."""


GLINT = 0.15
"""Width around the mirror image of the sun within which positions are denser, of half the disk: in 3-5 um over a sea of
10 m/s 17 nodes leave 2e-3 of the radiance with 0.1 to 0.2, 6e-3 with 0.3 and 6e-2 without."""

_SEARCH, _FARTHEST_GLINT_DEG = 41, 10.0
"""Positions along each side at which the mirror image is sought, and its largest distance from the nearest."""


@dataclass(frozen=True)
class Disk:
    """Plane of directions: sqrt(1 / cos(zenith) - 1) along their azimuths.

    Radiance is smooth in it, at its centre, too, where polar coordinates are not. Its square contains the disk.

    Attributes
    ----------
    edge : float
        Half its width.
    centre : (float, float)
        Latitude and longitude of the centre of the scene's plane, along whose axes directions are given.
    camera_m : tuple of float (3,)
        Place of the camera, Earth-fixed.
    start : datetime
        Of the scene, with a time zone.
    times_s : tuple of float
        At which suns are compared.
    glint : (float, float) or None
        Position of the sun's mirror image in -1 to 1, around which positions are stretched, if it matters.
    """

    edge: float
    centre: tuple[float, float]
    camera_m: tuple[float, float, float]
    start: datetime
    times_s: tuple[float, ...]
    glint: tuple[float, float] | None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        plane = np.array(list(places), dtype=np.float64).reshape(-1, 2)
        if self.glint is not None:
            plane = np.stack(
                [_squeezed(coordinate, at) for coordinate, at in zip(plane.T, self.glint, strict=True)], axis=-1
            )
        plane = self.edge * plane
        slant = 1.0 + np.sum(plane**2, axis=1)
        flat = plane * (np.sqrt(1.0 + slant) / slant)[:, None]
        return self.views_of(self._seen_in(np.column_stack((flat, 1.0 / slant))))

    def places(self, toward: Array, position_m: Array) -> tuple[Array, Array]:
        """Return the positions x and y (...) of directions (..., 3)."""
        scale = 1.0 / (self.edge * np.sqrt(toward[..., 2] * (1.0 + toward[..., 2])))
        x, y = toward[..., 0] * scale, toward[..., 1] * scale
        return (x, y) if self.glint is None else (_stretched(x, self.glint[0]), _stretched(y, self.glint[1]))

    def suns(self, view: View) -> list[Sun | None]:
        """Return the sun of the place of a view at the times; None below the horizon."""
        assert isinstance(view, AirOverField.PlacedView)
        return [_sun(self.start, view.latitude_deg, view.longitude_deg, time_s) for time_s in self.times_s]

    def views_of(self, position_m: Array) -> list[View]:
        """Return the views of positions (N, 3) on the ellipsoid; azimuths count from north."""
        latitude, longitude = surface_place(position_m)
        ray = np.array(self.camera_m) - position_m
        east, north, up = (np.sum(axis * ray, axis=-1) for axis in Ellipsoid.east_north_up(latitude, longitude))
        across = np.hypot(east, north)
        zenith = np.degrees(np.arctan2(across, up))
        azimuth = np.where(zenith < 1e-6, 0.0, np.degrees(np.arctan2(east, north)) % 360.0)
        directions = zip(*(values.tolist() for values in (zenith, azimuth, latitude, longitude)), strict=True)
        return [
            AirOverField.PlacedView(above, around, north, east, own_sun=True)
            for above, around, north, east in directions
        ]

    def _seen_in(self, toward: Array) -> Array:
        """Return the positions (N, 3) on the ellipsoid from which the camera is seen in directions (N, 3)."""
        camera = np.array(self.camera_m)
        latitude, longitude = surface_place(camera)
        below = Ellipsoid.to_earth_centred(latitude, longitude)
        east, north, up = Ellipsoid.east_north_up(latitude, longitude)
        zenith = np.arctan2(np.hypot(toward[:, 0], toward[:, 1]), toward[:, 2])
        bearing = np.arctan2(toward[:, 0], toward[:, 1])
        # On a sphere below the camera; the rest is the Earth's shape and the turn of the scene's axes.
        away = zenith - np.arcsin(SEMI_MAJOR_AXIS_M / np.linalg.norm(camera) * np.sin(zenith))
        opposite = bearing + np.pi
        position = np.broadcast_to(below, toward.shape)
        for _ in range(_STEPS):
            flat = np.sin(opposite)[:, None] * east + np.cos(opposite)[:, None] * north
            normal = np.cos(away)[:, None] * up + np.sin(away)[:, None] * flat
            position = Ellipsoid.to_earth_centred(
                np.degrees(np.arcsin(normal[:, 2])), np.degrees(np.arctan2(normal[:, 1], normal[:, 0]))
            )
            found = toward_camera(position, camera, self.centre)
            low = np.arctan2(np.hypot(found[:, 0], found[:, 1]), found[:, 2]) - zenith
            turned = bearing - np.arctan2(found[:, 0], found[:, 1])
            turned = np.where(zenith > 1e-6, (turned + np.pi) % (2.0 * np.pi) - np.pi, 0.0)
            if max(np.max(np.abs(low), initial=0.0), np.max(np.abs(turned * np.sin(zenith)), initial=0.0)) < _FOUND:
                break
            # Near the horizon the zenith angle changes as fast as the place.
            away, opposite = np.maximum(away - 0.85 * low, 0.0), opposite + turned
        return position


def _ends(middle: float) -> tuple[float, float]:
    return float(np.arcsinh((1.0 - middle) / GLINT)), float(np.arcsinh((1.0 + middle) / GLINT))


def _squeezed(position: Array, middle: float) -> Array:
    """Return positions from stretched ones; -1 and 1 stay (Tee and Trefethen, SIAM J. Sci. Comput. 28, 2006)."""
    after, before = _ends(middle)
    result: Array = middle + GLINT * np.sinh(0.5 * (after + before) * position + 0.5 * (after - before))
    return result


def _stretched(position: Array, middle: float) -> Array:
    """Return the inverse of :func:`_squeezed`."""
    after, before = _ends(middle)
    result: Array = (2.0 * np.arcsinh((position - middle) / GLINT) - (after - before)) / (after + before)
    return result


def with_glint(disk: Disk) -> Disk:
    """Return a disk that is stretched around the mirror image of the sun in the middle of its times, if it has one."""
    edge = np.linspace(-1.0, 1.0, _SEARCH).tolist()
    places = [(x, y) for y in edge for x in edge]
    views = disk.at(places)
    zenith, azimuth, latitude, longitude = (
        np.array([getattr(view, name) for view in views])
        for name in ("zenith_deg", "azimuth_deg", "latitude_deg", "longitude_deg")
    )
    instant = disk.start + timedelta(seconds=disk.times_s[len(disk.times_s) // 2])
    sun_zenith, sun_azimuth, _ = sun_position([instant] * zenith.size, latitude, longitude)
    seen, lit, turn = (np.radians(degrees) for degrees in (zenith, sun_zenith, azimuth - sun_azimuth))
    # Cosine between the view and the mirror direction, whose bearing is opposite to the sun's.
    nearness = np.cos(seen) * np.cos(lit) - np.sin(seen) * np.sin(lit) * np.cos(turn)
    best = int(np.argmax(np.where(sun_zenith < 90.0, nearness, -1.0)))
    return replace(disk, glint=places[best]) if nearness[best] > np.cos(np.radians(_FARTHEST_GLINT_DEG)) else disk


def disk_around(
    toward: Array,
    limit_deg: float | None,
    centre: tuple[float, float],
    camera_m: Array,
    start: datetime,
    times_s: tuple[float, ...],
) -> Disk:
    """Return the plane that contains directions (N, 3), up to a zenith angle if the ground is seen beyond it."""
    up = float(toward[:, 2].min()) if limit_deg is None else float(np.cos(np.radians(limit_deg)))
    x, y, z = camera_m.tolist()
    return Disk((1.0 + PADDING) * float(np.sqrt(1.0 / up - 1.0)), centre, (x, y, z), start, times_s)


@lru_cache(maxsize=4096)
def _sun(start: datetime, latitude_deg: float, longitude_deg: float, time_s: float) -> Sun | None:
    sun = sun_at(start, latitude_deg, longitude_deg, time_s)
    return sun if sun.is_up else None


def sun_at(start: datetime, latitude_deg: float, longitude_deg: float, time_s: float) -> Sun:
    """Return the sun, seen from a place, at seconds after the start."""
    zenith, azimuth, distance = sun_position([start + timedelta(seconds=time_s)], latitude_deg, longitude_deg)
    return Sun(float(zenith[0]), float(azimuth[0]), float(distance[0]))
