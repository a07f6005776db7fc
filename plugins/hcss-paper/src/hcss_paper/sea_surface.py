"""The Pierson-Moskowitz spectrum (eq 1) as printed, and realisations of a sea that has it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

ALPHA, BETA, GRAVITY_M_S2 = 8.1e-3, 0.74, 9.81
"""Constants below eq 1."""


def spectrum_m2_s(omega_rad_s: NDArray[np.float64], wind_speed_m_s: float) -> NDArray[np.float64]:
    """Return alpha g^2 / omega^5 exp(-beta (g / (U omega))^4) at frequencies (N,) above 0."""
    decay = np.exp(-BETA * (GRAVITY_M_S2 / (wind_speed_m_s * omega_rad_s)) ** 4)
    return np.asarray(ALPHA * GRAVITY_M_S2**2 / omega_rad_s**5 * decay, dtype=np.float64)


def elevation_variance_m2(wind_speed_m_s: float) -> float:
    """Return m0, the integral of eq 1 over all frequencies: alpha U^4 / (4 beta g^2)."""
    return ALPHA * wind_speed_m_s**4 / (4.0 * BETA * GRAVITY_M_S2**2)


def significant_wave_height_m(wind_speed_m_s: float) -> float:
    """Return 4 m0^(1/2)."""
    return 4.0 * math.sqrt(elevation_variance_m2(wind_speed_m_s))


def component_frequencies_rad_s(wind_speed_m_s: float, count: int) -> NDArray[np.float64]:
    """Return ``count`` ascending frequencies (N,), each the median of an equal share of the variance.

    The fraction of variance below omega is exp(-beta (g / (U omega))^4), which can be inverted in closed form; the
    components add up to m0 exactly, without a cut-off.

    Raises
    ------
    ValueError
        If the wind speed is not above 0 or not finite, or ``count`` below 1.
    """
    if not (math.isfinite(wind_speed_m_s) and wind_speed_m_s > 0.0) or count < 1:
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}, count {count}: allowed finite, above 0; at least 1")
    share = (np.arange(count) + 0.5) / count
    return np.asarray(GRAVITY_M_S2 / wind_speed_m_s * (BETA / -np.log(share)) ** 0.25, dtype=np.float64)


def surface_elevation(
    x_m: NDArray[np.float64],
    y_m: NDArray[np.float64],
    time_s: float,
    wind_speed_m_s: float,
    wind_from_deg: float,
    seed: int,
    components: int = 1000,
) -> NDArray[np.float64]:
    """Return the elevation of one realisation of the sea as a sum of waves of random phase.

    Wave directions have the density 2/pi cos^2 about downwind. Deep-water waves: k = omega^2 / g.

    Parameters
    ----------
    x_m, y_m : ndarray
        Positions east and north; the arrays broadcast.
    time_s : float
        Time; the waves of a realisation travel.
    wind_speed_m_s : float
        Wind speed; 0 gives a flat surface.
    wind_from_deg : float
        Bearing that the wind comes from, clockwise from north.
    seed : int
        Selects the realisation.
    components : int
        Number of waves, all of the same amplitude.

    Returns
    -------
    ndarray
        Metres above the mean, of the broadcast shape. The ensemble variance is m0 for any number of components.

    Raises
    ------
    ValueError
        If the wind speed is negative or not finite, or ``components`` below 1.
    """
    x, y = np.broadcast_arrays(np.asarray(x_m, dtype=np.float64), np.asarray(y_m, dtype=np.float64))
    elevation = np.zeros(x.shape)
    if not (math.isfinite(wind_speed_m_s) and wind_speed_m_s >= 0.0):
        raise ValueError(f"wind_speed_m_s {wind_speed_m_s}: allowed finite, at least 0")
    variance = elevation_variance_m2(wind_speed_m_s)
    if variance == 0.0:
        return elevation
    omega = component_frequencies_rad_s(wind_speed_m_s, components)
    random = np.random.default_rng(seed)
    phase = 2.0 * np.pi * random.random(components)
    # The sine of an angle with density cos^2 is distributed like a coordinate of random points in a disc.
    disc = np.sqrt(random.random(components)) * np.cos(2.0 * np.pi * random.random(components))
    bearing = np.radians(wind_from_deg + 180.0) + np.arcsin(disc)
    wavenumber = omega**2 / GRAVITY_M_S2
    east, north = wavenumber * np.sin(bearing), wavenumber * np.cos(bearing)
    phase -= omega * time_s
    # Adding one wave at a time limits the memory to the size of the surface.
    for k_east, k_north, start in zip(east, north, phase, strict=True):
        elevation += np.cos(k_east * x + k_north * y + start)
    return elevation * math.sqrt(2.0 * variance / components)
