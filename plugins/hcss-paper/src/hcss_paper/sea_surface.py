"""Realisations of a fully developed sea with the Pierson-Moskowitz spectrum (eq 1), for the figure of cloud types."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.models.sea.pierson_moskowitz import PiersonMoskowitz


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
    return np.asarray(
        PiersonMoskowitz.GRAVITY_M_S2 / wind_speed_m_s * (PiersonMoskowitz.BETA / -np.log(share)) ** 0.25,
        dtype=np.float64,
    )


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
    variance = PiersonMoskowitz.elevation_variance_m2(wind_speed_m_s)
    if variance == 0.0:
        return elevation
    omega = component_frequencies_rad_s(wind_speed_m_s, components)
    random = np.random.default_rng(seed)
    phase = 2.0 * np.pi * random.random(components)
    # The sine of an angle with density cos^2 is distributed like a coordinate of random points in a disc.
    disc = np.sqrt(random.random(components)) * np.cos(2.0 * np.pi * random.random(components))
    bearing = np.radians(wind_from_deg + 180.0) + np.arcsin(disc)
    wavenumber = omega**2 / PiersonMoskowitz.GRAVITY_M_S2
    east, north = wavenumber * np.sin(bearing), wavenumber * np.cos(bearing)
    phase -= omega * time_s
    # Adding one wave at a time limits the memory to the size of the surface.
    for k_east, k_north, start in zip(east, north, phase, strict=True):
        elevation += np.cos(k_east * x + k_north * y + start)
    return elevation * math.sqrt(2.0 * variance / components)
