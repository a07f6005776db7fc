"""Disks by night whose air and sea depend on the latitude: directions as latitude and slant path.

Without a sun, two places of one latitude from which the camera is seen at one zenith angle differ only in the bearing
of the wind. Tables then stand at few latitudes, each with the air of one profile, and at few slant paths: 10 x 17 at
1e-3 where the plane of :mod:`hcss_payload.disk` needs 33 x 23, because kinks of the air (aerosol changes with humidity)
lie along its lines, and because the corners of the square around a disk are farther away than its edge.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hcss_payload.directions import PADDING
from hcss_payload.disk import Disk
from hcss_payload.earth import SEMI_MAJOR_AXIS_M
from hcss_payload.scene_plane import surface_place
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.providers import Array, Sun, View

BESIDE_DEG = 0.3
"""Margin of latitudes: those of the ellipsoid differ by up to 0.2 degrees from those of a sphere."""


@dataclass(frozen=True)
class ZonalDisk:
    """Rectangle of 1 / cos(zenith), in which radiance is smooth, and latitude.

    It contains zenith angles that its highest latitudes do not have; their radiance is smooth, too.

    Attributes
    ----------
    disk : Disk
        The same places, as a plane.
    slant, latitude_deg : (float, float)
        Middle and half width.
    """

    disk: Disk
    slant: tuple[float, float]
    latitude_deg: tuple[float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """Latitude and longitude of the centre of the scene's plane."""
        return self.disk.centre

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge, in the west of the disk."""
        x, y = np.array(list(places), dtype=np.float64).reshape(-1, 2).T
        slant = np.maximum(self.slant[0] + self.slant[1] * x, 1.0)
        latitude = self.latitude_deg[0] + self.latitude_deg[1] * y
        below, longitude = (float(degrees) for degrees in surface_place(np.array(self.disk.camera_m)))
        zenith = np.arccos(1.0 / slant)
        apart, latitude_rad = _angle_from_centre(self.disk, zenith), np.radians(latitude)
        # Spherical triangle of place, pole and the point below the camera; due south or north where there is none.
        side = np.cos(latitude_rad) * np.sin(apart)
        cosine = (np.sin(np.radians(below)) - np.sin(latitude_rad) * np.cos(apart)) / np.where(side > 0.0, side, 1.0)
        azimuth = np.degrees(np.arccos(np.clip(np.where(side > 0.0, cosine, 1.0), -1.0, 1.0)))
        directions = zip(np.degrees(zenith).tolist(), azimuth.tolist(), latitude.tolist(), strict=True)
        return [
            AirOverField.PlacedView(above, around, north, longitude, own_sun=True)
            for above, around, north in directions
        ]

    def places(self, toward: Array, position_m: Array) -> tuple[Array, Array]:
        """Return the positions x and y (...) of directions (..., 3) from positions (..., 3)."""
        latitude, _ = surface_place(position_m)
        return (
            (1.0 / toward[..., 2] - self.slant[0]) / self.slant[1],
            (latitude - self.latitude_deg[0]) / self.latitude_deg[1],
        )

    def suns(self, view: View) -> list[Sun | None]:
        """Return the sun of the place of a view: none."""
        return [None]

    def views_of(self, position_m: Array) -> list[View]:
        """Return the views of positions (N, 3) on the ellipsoid."""
        return self.disk.views_of(position_m)


def zonal_disk(disk: Disk, toward: Array, latitude_deg: Array, limit_deg: float | None) -> ZonalDisk:
    """Return the rectangle around the directions (N, 3) and latitudes (M,) of sampled pixels.

    Parameters
    ----------
    limit_deg : float, optional
        Zenith angle up to which the ground is seen, if it is seen beyond it.
    """
    low, high = float(np.min(latitude_deg)) - BESIDE_DEG, float(np.max(latitude_deg)) + BESIDE_DEG
    farthest = float(1.0 / toward[:, 2].min())
    if limit_deg is not None:  # near the limit, latitudes between sampled pixels change fast
        below, _ = (float(degrees) for degrees in surface_place(np.array(disk.camera_m)))
        reach = float(np.degrees(_angle_from_centre(disk, np.radians(np.array(limit_deg))))) + BESIDE_DEG
        low, high = min(low, below - reach), max(high, below + reach)
        farthest = float(1.0 / np.cos(np.radians(limit_deg)))
    half = 0.5 * (farthest - 1.0) * (1.0 + PADDING)
    return ZonalDisk(disk, (1.0 + half, half), (0.5 * (low + high), 0.5 * (high - low)))


def _angle_from_centre(disk: Disk, zenith_rad: Array) -> Array:
    """Return the angle at the Earth's centre between a place and the camera, on a sphere."""
    distance = float(np.linalg.norm(disk.camera_m))
    result: Array = zenith_rad - np.arcsin(SEMI_MAJOR_AXIS_M / distance * np.sin(zenith_rad))
    return result
