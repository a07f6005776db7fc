"""From the sea of the climatology, ships' reports of 1946 to 1989, to the surface that a satellite sees in a year."""

from __future__ import annotations

import math

WARMING_SINCE = 1980
WARMING_K_PER_YEAR = 0.015
"""Warming of the sea since the years of the climatology.

0.60 K (0.44 to 0.74) from 1980 to 2020 in the global mean (IPCC, Climate Change 2021: The Physical Science Basis,
section 9.2.1.1). Trends from 1981 to 2018 are -0.1 to 0.35 K per decade in 95 % of places (C. E. Bulgin et al., Sci.
Rep. 10, 7882 (2020)), so that a place differs by some tenths of a kelvin."""


def warming_K(year: int) -> float:
    """Return how much warmer the sea is than that of the climatology; beyond 2020 by the same trend."""
    return WARMING_K_PER_YEAR * max(0, year - WARMING_SINCE)


def skin_K(wind_speed_m_s: float) -> float:
    """Return the temperature of the surface less that of the water below, which ships report.

    By night, or in wind above 6 m/s (C. J. Donlon et al., J. Climate 15, 353 (2002), eq 2). A calm sea in the sun is
    warmer, which is left out.
    """
    return -0.14 - 0.30 * math.exp(-wind_speed_m_s / 3.7)
