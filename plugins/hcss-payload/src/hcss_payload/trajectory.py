"""Trajectories: the position of the camera at any time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hcss_payload.checks import NoStateAtTimeError, PayloadError, ascending, finite, require_inside, require_within
from hcss_payload.earth import EARTH_M3_S2, OBLATENESS, SEMI_MAJOR_AXIS_M
from hcss_payload.earth_rotation import EARTH_RATE_RAD_S
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import Array

GEOSTATIONARY_RADIUS_M = float((EARTH_M3_S2 / EARTH_RATE_RAD_S**2) ** (1.0 / 3.0))
"""Radius at which the period is that of the Earth's rotation (Kepler's third law), 42 164 km."""


class Trajectory(Protocol):
    """Position of the camera."""

    def at(self, time_s: float) -> Array:
        """Return the Earth-fixed position (3,) in m, ``time_s`` after the start."""
        ...


def velocity_m_s(trajectory: Trajectory, time_s: float, step_s: float = 0.5) -> Array:
    """Return the velocity (3,) over the rotating Earth by a difference, one-sided at the ends of a table."""
    ends = []
    for side in (-1.0, 1.0):
        try:
            ends.append((time_s + side * step_s, trajectory.at(time_s + side * step_s)))
        except NoStateAtTimeError:
            ends.append((time_s, trajectory.at(time_s)))
    (first, before), (last, after) = ends
    if first == last:
        raise PayloadError(f"trajectory: a table shorter than {step_s:g} s; allowed: longer ones, for the velocity")
    speed: Array = (after - before) / (last - first)
    return speed


@dataclass(frozen=True)
class Geostationary:
    """A satellite that stays above a place of the equator.

    Parameters
    ----------
    longitude_deg : float
        Of the satellite.
    """

    longitude_deg: float

    def __post_init__(self) -> None:
        require_within("trajectory.longitude_deg", self.longitude_deg, -180.0, 360.0, "deg")

    def at(self, time_s: float) -> Array:
        """Return the position, the same at all times."""
        height = GEOSTATIONARY_RADIUS_M - SEMI_MAJOR_AXIS_M
        return Ellipsoid.to_earth_centred(np.float64(0.0), np.float64(self.longitude_deg), height)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Circular:
    """A circular orbit by Kepler's third law, without drag.

    Parameters
    ----------
    altitude_m : float
        Above the equatorial radius.
    inclination_deg : float
        Of the orbit, 0 to 180.
    node_longitude_deg : float
        Longitude of the ascending node at time 0.
    argument_deg : float
        Angle from the ascending node along the orbit at time 0.
    precesses : bool
        Whether the oblate Earth turns the plane and changes the period, at their mean rates.

    References
    ----------
    Rates: D. A. Vallado, "Fundamentals of Astrodynamics and Applications" (2013), section 9.6, for no eccentricity.
    """

    altitude_m: float
    inclination_deg: float
    node_longitude_deg: float = 0.0
    argument_deg: float = 0.0
    precesses: bool = False

    def __post_init__(self) -> None:
        require_within("trajectory.altitude_m", self.altitude_m, 1e5, 1e8, "m")
        require_within("trajectory.inclination_deg", self.inclination_deg, 0.0, 180.0, "deg")
        require_within("trajectory.node_longitude_deg", self.node_longitude_deg, -360.0, 360.0, "deg")
        require_within("trajectory.argument_deg", self.argument_deg, -360.0, 360.0, "deg")

    @classmethod
    def above(
        cls,
        altitude_m: float,
        inclination_deg: float,
        latitude_deg: float,
        longitude_deg: float,
        time_s: float = 0.0,
        ascending: bool = True,
        precesses: bool = False,
    ) -> Circular:
        """Return the orbit that passes above a place at a time.

        Raises
        ------
        PayloadError
            If the place is farther from the equator than the orbit reaches.
        """
        require_within("trajectory.above", latitude_deg, -90.0, 90.0, "deg")
        require_within("trajectory.above", longitude_deg, -180.0, 360.0, "deg")
        target_m = Ellipsoid.to_earth_centred(np.float64(latitude_deg), np.float64(longitude_deg), altitude_m)  # type: ignore[arg-type]
        # The place at this altitude on the ray from the centre: the plane of the orbit contains it.
        sine, tilt = target_m[2] / np.linalg.norm(target_m), np.radians(inclination_deg)
        if abs(sine) > np.sin(tilt):
            most = min(inclination_deg, 180.0 - inclination_deg)
            raise PayloadError(
                f"trajectory.above: latitude {latitude_deg:g} deg with inclination {inclination_deg:g} deg; allowed: "
                f"up to {most:g} deg"
            )
        along = np.arcsin(sine / np.sin(tilt)) if np.sin(tilt) > 0.0 else 0.0
        along = along if ascending else np.pi - along
        east = np.arctan2(np.sin(along) * np.cos(tilt), np.cos(along))
        along_rate, node_rate = cls(altitude_m, inclination_deg, precesses=precesses).rates_rad_s
        node, start = np.radians(longitude_deg) - east - node_rate * time_s, along - along_rate * time_s
        angles = float(np.degrees(node)) % 360.0, float(np.degrees(start)) % 360.0
        return cls(altitude_m, inclination_deg, *angles, precesses)

    @property
    def rates_rad_s(self) -> tuple[float, float]:
        """Rates of the angle along the orbit, and of the longitude of the node over the rotating Earth."""
        radius, cosine = SEMI_MAJOR_AXIS_M + self.altitude_m, float(np.cos(np.radians(self.inclination_deg)))
        motion = float(np.sqrt(EARTH_M3_S2 / radius**3))
        share = 1.5 * OBLATENESS * (SEMI_MAJOR_AXIS_M / radius) ** 2 if self.precesses else 0.0
        return motion * (1.0 + share * (4.0 * cosine**2 - 1.0)), -EARTH_RATE_RAD_S - share * motion * cosine

    def later(self, time_s: float) -> Circular:
        """Return the same motion with another time 0, this much later."""
        along_rate, node_rate = self.rates_rad_s
        node = (self.node_longitude_deg + float(np.degrees(node_rate * time_s))) % 360.0
        argument = (self.argument_deg + float(np.degrees(along_rate * time_s))) % 360.0
        return replace(self, node_longitude_deg=node, argument_deg=argument)

    def at(self, time_s: float) -> Array:
        """Return the position."""
        radius = SEMI_MAJOR_AXIS_M + self.altitude_m
        along_rate, node_rate = self.rates_rad_s
        along = np.radians(self.argument_deg) + along_rate * time_s
        node = np.radians(self.node_longitude_deg) + node_rate * time_s
        tilt = np.radians(self.inclination_deg)
        x, y, z = np.cos(along), np.sin(along) * np.cos(tilt), np.sin(along) * np.sin(tilt)
        return radius * np.array([x * np.cos(node) - y * np.sin(node), x * np.sin(node) + y * np.cos(node), z])


USUAL_DEGREE, LARGEST_DEGREE = 7, 31
"""Degree of the interpolation in tables: that with which ephemerides are commonly exchanged."""


@dataclass(frozen=True, eq=False)
class PositionTable:
    """Positions at given times, with the polynomial through the nearest of them between (Lagrange, or Hermite).

    Parameters
    ----------
    times_s : array_like (N,)
        Seconds after the start, ascending.
    positions_m : array_like (N, 3)
        Earth-fixed.
    velocities_m_s : array_like (N, 3), optional
        Over the rotating Earth; the polynomial has them, too.
    degree : int
        Of the polynomial; a lower one where the table has fewer points.
    """

    times_s: Array
    positions_m: Array
    velocities_m_s: Array | None = None
    degree: int = USUAL_DEGREE

    def __post_init__(self) -> None:
        object.__setattr__(self, "times_s", ascending("trajectory.times_s", self.times_s))
        for name in ("positions_m", "velocities_m_s"):
            if getattr(self, name) is not None:
                values = finite(f"trajectory.{name}", getattr(self, name), len(self.times_s), 3)
                object.__setattr__(self, name, values)
        require_within("trajectory.degree", self.degree, 1, LARGEST_DEGREE)

    def at(self, time_s: float) -> Array:
        """Return the position; a time outside the table is an error."""
        require_inside("trajectory", time_s, self.times_s)
        return self.through(time_s, self.points)

    @property
    def points(self) -> int:
        """How many of the nearest points the polynomial passes."""
        wanted = self.degree + 1 if self.velocities_m_s is None else self.degree // 2 + 1
        return min(wanted, self.times_s.size)

    def through(self, time_s: float, points: int) -> Array:
        """Return the position of the polynomial through so many points.

        With the Lagrange polynomials L of the points, Hermite's terms are (1 - 2 L'(t_i) (t - t_i)) L^2 for positions,
        and (t - t_i) L^2 for velocities.
        """
        times, count = self.times_s, points
        first = int(np.clip(np.searchsorted(times, time_s) - count // 2, 0, times.size - count))
        nodes = slice(first, first + count)
        since = time_s - times[nodes]
        others = ~np.eye(count, dtype=np.bool_)
        apart = np.where(others, times[nodes, None] - times[None, nodes], 1.0)
        weight = np.prod(np.where(others, since[None, :], 1.0) / apart, axis=1)
        if self.velocities_m_s is None:
            position: Array = weight @ self.positions_m[nodes]
            return position
        slope = np.sum(np.where(others, 1.0 / apart, 0.0), axis=1)
        square = weight**2
        position = ((1.0 - 2.0 * slope * since) * square) @ self.positions_m[nodes]
        position += (since * square) @ self.velocities_m_s[nodes]
        return position
