"""Coordinates of directions toward the camera, between which radiance is tabulated.

A direction is a unit vector (x, y, up): horizontal components along the axes of the scene's plane, and up. The
directions of all pixels of a pass fill a strip along a great circle (a satellite that moves straight on is seen along
one), or, for a full disk, the hemisphere. Tables depend on the pass as a whole, never on single frames, so that a pose
has the same radiance in every list of times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hcss_twin.providers import Array, Sun, View

NARROWEST_RAD = 1e-5
"""Smallest half width of a strip: directions closer than this are one."""

PADDING = 0.01
"""The strip is wider than the directions it was made from by this share on each side, for those between them."""

WIDEST_RAD = np.radians(50.0)
"""Full width of the wider strips that become zenith and azimuth; their corners would lie near the horizon."""


class PassDirections(Protocol):
    """A rectangle of coordinates of directions, as the engine wants it of rays, and the places of directions in it."""

    @property
    def suns(self) -> Callable[[View], list[Sun | None]] | None:
        """Returns the suns of the place of a view at some frames; None if all places have one sun."""
        ...

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        ...

    def places(self, toward: Array, position_m: Array) -> tuple[Array, Array]:
        """Return the positions x and y (...) of directions (..., 3) from Earth-fixed positions (..., 3)."""
        ...


def view_of(toward: Array) -> View:
    """Return the zenith and azimuth of a direction (3,)."""
    zenith = float(np.degrees(np.arctan2(np.hypot(toward[0], toward[1]), toward[2])))
    if zenith < 1e-6:  # where rounding decides over the azimuth, and tables are not found in the cache again
        return View(0.0, 0.0)
    return View(zenith, float(np.degrees(np.arctan2(toward[0], toward[1])) % 360.0))


@dataclass(frozen=True, eq=False)
class Strip:
    """Angles along and across a great circle.

    Attributes
    ----------
    axes : ndarray (3, 3)
        Unit vectors: the origin of the angles on the great circle, the circle's direction there, and its pole.
    along_rad, across_rad : (float, float)
        Middle and half width.
    """

    axes: Array
    along_rad: tuple[float, float]
    across_rad: tuple[float, float]
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions."""
        views = []
        for x, y in places:
            along, across = (
                middle + half * position
                for position, (middle, half) in zip((x, y), (self.along_rad, self.across_rad), strict=True)
            )
            angles = np.array([np.cos(across) * np.cos(along), np.cos(across) * np.sin(along), np.sin(across)])
            views.append(view_of(angles @ self.axes))
        return views

    def places(self, toward: Array, position_m: Array) -> tuple[Array, Array]:
        """Return the positions of directions."""
        along, across = _angles(self.axes, toward)
        return _scaled(along, self.along_rad), _scaled(across, self.across_rad)


@dataclass(frozen=True)
class Hemisphere:
    """Slant path and azimuth: x is 1 / cos(zenith), in which radiance is smooth, and y the azimuth.

    Attributes
    ----------
    slant : (float, float)
        Middle and half width of 1 / cos(zenith).
    """

    slant: tuple[float, float]
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions."""
        middle, half = self.slant
        return [
            View(float(np.degrees(np.arccos(min(1.0, 1.0 / max(1.0, middle + half * x))))), (180.0 * (y + 1.0)) % 360.0)
            for x, y in places
        ]

    def places(self, toward: Array, position_m: Array) -> tuple[Array, Array]:
        """Return the positions of directions."""
        azimuth = np.arctan2(toward[..., 0], toward[..., 1]) % (2.0 * np.pi)
        return _scaled(1.0 / toward[..., 2], self.slant), azimuth / np.pi - 1.0


def directions_around(toward: Array, limit_deg: float | None = None) -> PassDirections:
    """Return coordinates whose rectangle contains directions (N, 3) of a whole pass.

    Parameters
    ----------
    limit_deg : float, optional
        Zenith angle up to which the ground is seen, if it is seen beyond it.
    """
    _, _, rows = np.linalg.svd(toward, full_matrices=False)
    pole = rows[2] if rows[2][np.argmax(np.abs(rows[2]))] > 0.0 else -rows[2]
    mean = toward.mean(axis=0)
    origin = mean - (mean @ pole) * pole
    origin /= np.linalg.norm(origin)
    axes = np.stack((origin, np.cross(pole, origin), pole))
    along, across = (_range(values) for values in _angles(axes, toward))
    if 2.0 * across[1] < WIDEST_RAD:
        return Strip(axes, along, across)
    slant = 1.0 / toward[:, 2]
    low, high = float(slant.min()), float(slant.max())
    if limit_deg is not None:
        high = 1.0 / float(np.cos(np.radians(limit_deg)))
    low = 1.0 if low < 1.0 + PADDING * (high - 1.0) else low - PADDING * (high - low)
    high += PADDING * (high - low)
    return Hemisphere((0.5 * (low + high), 0.5 * (high - low)))


def _angles(axes: Array, toward: Array) -> tuple[Array, Array]:
    first, second, third = np.moveaxis(toward @ axes.T, -1, 0)
    return np.arctan2(second, first), np.arcsin(np.clip(third, -1.0, 1.0))


def _range(values: Array) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return 0.5 * (low + high), max(0.5 * (high - low) * (1.0 + 2.0 * PADDING), NARROWEST_RAD)


def _scaled(values: Array, middle_and_half: tuple[float, float]) -> Array:
    middle, half = middle_and_half
    result: Array = (values - middle) / half
    return result
