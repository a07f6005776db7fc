"""Terms of the physical radiance: where light was emitted or, for sunlight, last scattered or reflected."""

from __future__ import annotations

from collections.abc import Mapping

CLOUD, CLOUD_SUN, SEA, SEA_SUN, AIR, SCATTERED_AIR, AIR_SUN = range(7)

TERMS: Mapping[str, str] = {
    "cloud_emission": "thermal emission of the clouds, also where sea or other clouds reflect it",
    "cloud_reflected_sun": "sunlight scattered by clouds, toward the sensor or first to sea and other clouds",
    "sea_emission": "thermal emission of the sea, through the clouds and reflected by them",
    "sea_reflected_sun": "sunlight reflected by the sea, directly or through clouds",
    "path_emission": "thermal emission of the air that reaches the sensor without being scattered",
    "reflected_air_emission": "thermal emission of the air (and of space) that sea or clouds reflect or scatter",
    "path_scattered_sun": "sunlight scattered once by the air",
}

SOLAR_TERMS = frozenset({"cloud_reflected_sun", "sea_reflected_sun", "path_scattered_sun"})

SEA_SUN_TERMS = frozenset({"sea_reflected_sun"})
"""Terms that consist of direct sunlight reflected by the sea in a clear column."""
