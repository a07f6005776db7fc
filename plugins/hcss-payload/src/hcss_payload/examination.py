"""Examination of trajectories: what no satellite of the Earth can do is refused, and what is doubtful is noted.

The yardstick is gravity, with the Earth's oblateness: other forces on satellites above 100 km are smaller by factors
of a thousand, but for engines. A file in wrong units, of another planet or in another frame is far from it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hcss_payload.checks import NoStateAtTimeError, PayloadError
from hcss_payload.earth import EARTH_M3_S2, MEAN_EARTH_RADIUS_M, OBLATENESS, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_payload.earth_rotation import EARTH_RATE_RAD_S
from hcss_payload.rays import geographic
from hcss_payload.spans import Spans
from hcss_payload.trajectory import PositionTable, Trajectory
from hcss_payload.two_lines import Sgp4Orbit
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import Array

LOWEST_M, FARTHEST_M = 99e3, 2e9
"""Lowest altitude, where the least that ``orbit.altitude`` allows may be above the ellipsoid, and largest distance from
the Earth's centre: somewhat beyond the point between Earth and sun from which some satellites see full disks."""

AGE_NOTED_D, AGE_REFUSED_D = 7.0, 180.0
"""Age of two-line elements, days."""

INTERPOLATION_NOTED_M, INTERPOLATION_REFUSED_M = 30.0, 1000.0

DEPARTURE_NOTED, DEPARTURE_REFUSED = 0.05, 0.5
"""Difference from gravity, relative to it; the second for ephemeris messages, whose subject is orbits."""

PLACE_NOTED_M, PLACE_REFUSED_M = 100e3, 2000e3
"""Distance of ``[place]`` from what the camera sees, beyond the distance of the sampled pixels. The latter is the 18
degrees that full disks allow."""

_TIMES = 17
"""Times of a pass at which positions are examined."""

_STEPS_PER_PERIOD = 50.0
"""Second differences over a fiftieth of the period err by 0.13 %."""

_SHORTEST_S = 10.0
"""Least step of second differences: positions rounded to 1 m leave 1 % of gravity."""


def require_radius(where: str, lines: Sequence[int], positions_m: Array) -> None:
    """Raise a :class:`PayloadError` for positions (N, 3) inside the Earth or far from it."""
    radius = np.linalg.norm(positions_m, axis=1)
    wrong = np.flatnonzero((radius < SEMI_MINOR_AXIS_M) | (radius > FARTHEST_M))
    if wrong.size:
        first = int(wrong[0])
        raise PayloadError(
            f"{where}: line {lines[first]}: radius {1e-3 * radius[first]:.6g} km; allowed: outside the Earth and up to "
            f"{1e-3 * FARTHEST_M:g} km: positions are in km, and velocities in km/s"
        )


def largest_turn_rad(times_s: Array, positions_m: Array) -> float:
    """Return the largest angle by which a satellite at positions (N, 3) turns around the Earth between two times."""
    return float(np.max(_rate_rad_s(positions_m) * np.diff(times_s)))


def _rate_rad_s(positions_m: Array) -> Array:
    """Return the angular velocity (N - 1,) of circular orbits through the lower one of two positions each."""
    radius = np.linalg.norm(positions_m, axis=1)
    rate: Array = np.sqrt(EARTH_M3_S2 / np.minimum(radius[1:], radius[:-1]) ** 3)
    return rate


def require_consistent_velocities(
    where: str, lines: Sequence[int], times_s: Array, positions_m: Array, velocities_m_s: Array
) -> None:
    """Raise a :class:`PayloadError` for velocities (N, 3) that positions (N, 3) contradict, both Earth-fixed.

    The mean of two velocities and the way between two positions differ by a twelfth of (rate x step)^2 of the speed;
    twice that is allowed, and 2 % of the speed of a circular orbit, and rounding of positions to 1 m.
    """
    step_s = np.diff(times_s)
    moved = np.diff(positions_m, axis=0) / step_s[:, None]
    stated = 0.5 * (velocities_m_s[1:] + velocities_m_s[:-1])
    rate = _rate_rad_s(positions_m)
    speed, turned = np.cbrt(EARTH_M3_S2 * rate), (rate + EARTH_RATE_RAD_S) * step_s
    apart = np.linalg.norm(moved - stated, axis=1) / speed
    wrong = np.flatnonzero(apart > 0.02 + turned**2 / 6.0 + 1.0 / (speed * step_s))
    if wrong.size:
        first = int(wrong[0])
        stated_km_s, moved_km_s = (1e-3 * np.linalg.norm(velocity[first]) for velocity in (stated, moved))
        raise PayloadError(
            f"{where}: lines {lines[first]} and {lines[first + 1]}: velocities of {stated_km_s:.5g} km/s, and "
            f"positions that move with {moved_km_s:.5g} km/s, {100.0 * apart[first]:.3g} % of the orbital speed apart; "
            "allowed: positions in km, velocities in km/s, of one frame"
        )


def examine(trajectory: Trajectory, first_s: float, last_s: float) -> tuple[str, ...]:
    """Return what is doubtful about a trajectory between two times, with its size.

    Raises
    ------
    PayloadError
        If the trajectory is impossible: outside its table, inside the Earth, far from it, faster than three times the
        escape velocity, in an ephemeris message that gravity contradicts, with points so far apart that positions
        between them are unknown, or with elements that say nothing about these times.
    """
    times = np.unique(np.linspace(first_s, last_s, _TIMES)).tolist()
    notes: list[str] = []
    if isinstance(trajectory, Sgp4Orbit):  # first, since SGP4 takes very old elements for those of a decayed orbit
        notes += _age(trajectory, first_s, last_s)
    for time_s in times:
        _require_above_ground(trajectory, time_s)
    for table in _tables(trajectory):
        notes += _interpolation(table, first_s, last_s)
    return (*notes, *_dynamics(trajectory, times))


def _tables(trajectory: Trajectory) -> Sequence[PositionTable]:
    if isinstance(trajectory, Spans):
        return trajectory.tables
    return [trajectory] if isinstance(trajectory, PositionTable) else []


def _require_above_ground(trajectory: Trajectory, time_s: float) -> None:
    position = trajectory.at(time_s)
    radius = float(np.linalg.norm(position))
    altitude = float(geographic(position)[2]) if radius > SEMI_MINOR_AXIS_M else radius - MEAN_EARTH_RADIUS_M
    if not (altitude >= LOWEST_M and radius <= FARTHEST_M):
        raise PayloadError(
            f"trajectory: altitude {1e-3 * altitude:.6g} km at time {time_s:g} s; allowed: above the air, "
            f"{1e-3 * LOWEST_M:g} km, and up to {1e-3 * FARTHEST_M:g} km from the Earth's centre"
        )


def _age(elements: Sgp4Orbit, first_s: float, last_s: float) -> Iterator[str]:
    since = [((elements.start - elements.epoch).total_seconds() + time_s) / 86400.0 for time_s in (first_s, last_s)]
    age = max(since, key=abs)
    text = f"the elements are {abs(age):.3g} days {'older' if age > 0.0 else 'younger'} than the frames"
    if abs(age) > AGE_REFUSED_D:
        raise PayloadError(
            f"trajectory: {text}; allowed: up to {AGE_REFUSED_D:g} days; closest are those of the same day"
        )
    if abs(age) > AGE_NOTED_D:
        yield (
            f"orbit: {text}; along a low orbit SGP4 errs by 1 to 3 km more each day, so by about {abs(age):.0f} to "
            f"{3.0 * abs(age):.0f} km here"
        )


def _interpolation(table: PositionTable, first_s: float, last_s: float) -> Iterator[str]:
    """Estimate the error between points in two ways, and believe the smaller.

    One point fewer tells what the last one brought. What the polynomial lacks of gravity, if it swings between points
    of distance h as sin(pi t / h), is an error of position (h / pi)^2 times smaller in acceleration.
    """
    times = table.times_s
    inside = np.flatnonzero((times[1:] > first_s) & (times[:-1] < max(last_s, first_s + 1e-9)))
    worst, gap_s = 0.0, 0.0
    for index in inside[np.unique(np.linspace(0, inside.size - 1, min(inside.size, 64)).astype(int))].tolist():
        step = float(times[index + 1] - times[index])
        middle = float(times[index]) + 0.5 * step
        fewer = table.through(middle, table.points - 1) if table.points > 1 else table.positions_m[index]
        last_point = float(np.linalg.norm(table.at(middle) - fewer))
        motion = _motion(table, middle, 0.125 * step)
        assert motion is not None  # between two points
        lacking = float(np.linalg.norm(motion[1] - _gravity(table.at(middle)))) * (step / np.pi) ** 2
        if min(last_point, lacking) > worst:
            worst, gap_s = min(last_point, lacking), step
    text = f"points {gap_s:g} s apart, between which positions of degree {table.degree} err by about {worst:.2g} m"
    if worst > INTERPOLATION_REFUSED_M:
        raise PayloadError(
            f"trajectory: {text}; allowed: up to {INTERPOLATION_REFUSED_M:g} m, with points closer together, or "
            "velocities"
        )
    if worst > INTERPOLATION_NOTED_M:
        yield f"orbit: {text}"


def _dynamics(trajectory: Trajectory, times_s: Sequence[float]) -> Iterator[str]:
    """Compare acceleration with gravity, and speed with the escape velocity (vis-viva)."""
    worst = at_s = fastest = farthest_m = 0.0
    for time_s in times_s:
        position = trajectory.at(time_s)
        radius = float(np.linalg.norm(position))
        step = 2.0 * np.pi * np.sqrt(radius**3 / EARTH_M3_S2) / _STEPS_PER_PERIOD
        tried = (
            _motion(trajectory, time_s, step_s) for step_s in (step, 0.1 * step, 0.01 * step) if step_s >= _SHORTEST_S
        )
        found = next((motion for motion in tried if motion is not None), None)
        if found is None:
            continue
        velocity, acceleration = found
        gravity = _gravity(position)
        apart = float(np.linalg.norm(acceleration - gravity) / np.linalg.norm(gravity))
        worst, at_s = max((worst, at_s), (apart, time_s))
        fastest, farthest_m = max(
            (fastest, farthest_m), (float(np.linalg.norm(velocity) / np.sqrt(2.0 * EARTH_M3_S2 / radius)), radius)
        )
    if fastest > 3.0:
        raise PayloadError(
            f"trajectory: {fastest:.3g} times the escape velocity at radius {1e-3 * farthest_m:.6g} km; allowed: up to "
            "3, with lengths in the unit of the file's kind"
        )
    text = f"acceleration at time {at_s:g} s differs by {100.0 * worst:.3g} % from gravity"
    if worst > DEPARTURE_REFUSED and isinstance(trajectory, Spans):
        raise PayloadError(
            f"trajectory: {text}; allowed: up to {100.0 * DEPARTURE_REFUSED:g} %: an orbit around the Earth, in km, in "
            "the stated REF_FRAME"
        )
    if worst > DEPARTURE_NOTED:
        yield f"orbit: {text}: engines, or another frame, unit or centre than stated"
    if fastest > 1.0:
        yield f"orbit: {fastest:.3g} times the escape velocity: the camera leaves the Earth"


def _inertial(trajectory: Trajectory, time_s: float, axes_s: float) -> Array:
    """Return the position (3,) at a time along the Earth-fixed axes of another time, which no longer turn."""
    angle = EARTH_RATE_RAD_S * (time_s - axes_s)
    (x, y, z), cosine, sine = trajectory.at(time_s), np.cos(angle), np.sin(angle)
    return np.array([cosine * x - sine * y, sine * x + cosine * y, z])


def _motion(trajectory: Trajectory, time_s: float, step_s: float) -> tuple[Array, Array] | None:
    """Return velocity (m/s) and acceleration (m/s2), (3,), along axes that do not turn; None at the ends of a table."""
    try:
        before, now, after = (_inertial(trajectory, time_s + side * step_s, time_s) for side in (-1.0, 0.0, 1.0))
    except NoStateAtTimeError:
        return None
    return (after - before) / (2.0 * step_s), (before - 2.0 * now + after) / step_s**2


def _gravity(position_m: Array) -> Array:
    """Return the gravity (3,) of the oblate Earth, m/s2.

    O. Montenbruck and E. Gill, "Satellite Orbits" (2000), section 3.2.
    """
    radius = float(np.linalg.norm(position_m))
    share = 1.5 * OBLATENESS * (SEMI_MAJOR_AXIS_M / radius) ** 2
    polar = 5.0 * (position_m[2] / radius) ** 2
    factor = 1.0 + share * (np.array([1.0, 1.0, 3.0]) - polar)
    gravity: Array = -EARTH_M3_S2 / radius**3 * position_m * factor
    return gravity


def examine_place(
    place_deg: tuple[float, float], seen_deg: Array, apart_m: float, positions_m: Array
) -> tuple[str, ...]:
    """Return a note if a place is far from what the camera sees, whose sun, air and sea are those of the place.

    Parameters
    ----------
    place_deg : (float, float)
        Latitude and longitude.
    seen_deg : ndarray (M, 2)
        Those of sampled pixels of the pass.
    apart_m : float
        Distance between neighbouring ones of a time.
    positions_m : ndarray (T, 3)
        Of the camera at the sampled times.

    Raises
    ------
    PayloadError
        If it is so far away that the scene has another sun.
    """
    seen = Ellipsoid.to_earth_centred(seen_deg[:, 0], seen_deg[:, 1])
    place_m = Ellipsoid.to_earth_centred(*(np.float64(degrees) for degrees in place_deg))  # type: ignore[arg-type]
    chord = np.linalg.norm(seen - place_m, axis=1)
    nearest = int(np.argmin(chord))
    away = 2.0 * MEAN_EARTH_RADIUS_M * float(np.arcsin(min(1.0, 0.5 * chord[nearest] / MEAN_EARTH_RADIUS_M)))
    along = positions_m / np.linalg.norm(positions_m, axis=1, keepdims=True)
    steps_m = MEAN_EARTH_RADIUS_M * np.linalg.norm(np.diff(along, axis=0), axis=1)
    beyond = away - apart_m - 0.5 * float(np.max(steps_m, initial=0.0))
    latitude, longitude = float(seen_deg[nearest, 0]), (float(seen_deg[nearest, 1]) + 180.0) % 360.0 - 180.0
    text = (
        f"[place] {place_deg[0]:g} N {place_deg[1]:g} E is {1e-3 * away:.0f} km from the nearest pixel of all frames, "
        f"{latitude:.4g} N {longitude:.5g} E"
    )
    if beyond > PLACE_REFUSED_M:
        raise PayloadError(
            f"place: {text}; allowed: up to {1e-3 * PLACE_REFUSED_M:g} km, since sun, air and sea are those of "
            f"[place]; closest valid choice is {latitude:.4g}, {longitude:.5g}"
        )
    return (f"place: {text}; sun, air and sea are those of [place]",) if beyond > PLACE_NOTED_M else ()
