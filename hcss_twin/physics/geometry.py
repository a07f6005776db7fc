"""Directions: bearings from the surface point toward sensor or sun, clockwise from north."""

from __future__ import annotations

import math

import numpy as np

from hcss_twin.core.arrays import Array


def relative_azimuth_rad(view_azimuth_deg: float, sun_azimuth_deg: float) -> float:
    """Angle between the bearings toward sensor and sun, folded into [0, pi].

    0: sensor on the sun's side (backscattering); pi: view toward the sun glint.
    """
    difference = math.radians(view_azimuth_deg - sun_azimuth_deg) % math.tau
    return min(difference, math.tau - difference)


def wind_azimuths(sensor_azimuth_deg: float, sun_azimuth_deg: float, wind_from_deg: float) -> tuple[float, float]:
    """Return (relative_azimuth, wind_azimuth) in radians for bearings in degrees clockwise from north.

    Slope statistics are mirror-symmetric about the wind, so the rotation sense is chosen such that the sun is at
    wind_azimuth + relative_azimuth with relative_azimuth in [0, pi].
    """
    difference = _turn_deg(sensor_azimuth_deg, sun_azimuth_deg)
    bearing = wind_sense(sensor_azimuth_deg, sun_azimuth_deg) * (sensor_azimuth_deg - wind_from_deg)
    return math.radians(abs(difference)), math.radians(bearing % 360.0)


def wind_sense(sensor_azimuth_deg: float, sun_azimuth_deg: float) -> float:
    """Sense in which :func:`wind_azimuths` counts: 1 clockwise, -1 counterclockwise."""
    return 1.0 if _turn_deg(sensor_azimuth_deg, sun_azimuth_deg) >= 0.0 else -1.0


def _turn_deg(sensor_azimuth_deg: float, sun_azimuth_deg: float) -> float:
    """From the sensor's to the sun's bearing, clockwise, -180 to 180."""
    return (sun_azimuth_deg - sensor_azimuth_deg + 180.0) % 360.0 - 180.0


def sun_zenith_along(
    view_zenith_deg: float, sun_zenith_deg: float, relative_azimuth: float, altitude_m: float, earth_radius_m: float
) -> float:
    """Zenith angle of the sun where a straight line of sight from the surface reaches an altitude, degrees.

    That point is above a different place on the Earth, nearer to the sensor.

    Parameters
    ----------
    view_zenith_deg, sun_zenith_deg : float
        At the surface point.
    relative_azimuth : float
        Radians, as :func:`relative_azimuth_rad`.
    """
    zenith, sun = math.radians(view_zenith_deg), math.radians(sun_zenith_deg)
    local = math.asin(math.sin(zenith) * earth_radius_m / (earth_radius_m + altitude_m))
    turned = zenith - local
    cosine = math.cos(sun) * math.cos(turned) + math.sin(sun) * math.sin(turned) * math.cos(relative_azimuth)
    return math.degrees(math.acos(_cosine(cosine)))


def scattering_cosine(mu: float, mu0: float, relative_azimuth: float) -> float:
    """Cosine of the scattering angle from the sunbeam into the view (HCSS paper, eq 14, its sign corrected).

    Parameters
    ----------
    mu, mu0 : float
        Cosines of view and solar zenith angles.
    relative_azimuth : float
        Radians, as :func:`relative_azimuth_rad`.

    Notes
    -----
    From the direction vectors: the sunbeam travels along -s, the light seen along v, so cos(scattering) = -s.v. Eq 14
    of the HCSS paper has the opposite sign of the first product; :func:`scattering_cosine_literal` keeps that form.
    """
    return _cosine(-mu * mu0 - math.sqrt(1 - mu * mu) * math.sqrt(1 - mu0 * mu0) * math.cos(relative_azimuth))


def scattering_cosine_literal(mu: float, mu0: float, relative_azimuth: float) -> float:
    """HCSS paper, eq 14 as printed: its wrong sign puts the forward peak into back-scattering."""
    return _cosine(mu * mu0 - math.sqrt(1 - mu * mu) * math.sqrt(1 - mu0 * mu0) * math.cos(relative_azimuth))


def _cosine(value: float) -> float:
    """Clip a cosine that rounding carries beyond 1 in the hot spot."""
    return max(-1.0, min(1.0, value))


def displacement_m(height_m: Array | float, zenith_deg: Array | float, azimuth_deg: Array | float) -> Array:
    """Return how far north and east, (2, ...), a straight line toward a direction passes a height.

    Parameters
    ----------
    height_m, zenith_deg, azimuth_deg : float or ndarray (...)
        Height; direction to the sensor or sun from the sea point; zenith below 90.
    """
    distance = height_m * np.tan(np.radians(zenith_deg))
    azimuth = np.radians(azimuth_deg)
    return np.stack((distance * np.cos(azimuth), distance * np.sin(azimuth)))
