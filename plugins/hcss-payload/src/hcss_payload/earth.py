"""Constants of the Earth: the ellipsoid of WGS 84, and its gravitation.

Ellipsoid: NIMA TR8350.2, "Department of Defense World Geodetic System 1984", 3rd edition (2000), table 3.1.
"""

SEMI_MAJOR_AXIS_M = 6378137.0
_FLATTENING = 1.0 / 298.257223563
SEMI_MINOR_AXIS_M = SEMI_MAJOR_AXIS_M * (1.0 - _FLATTENING)
ECCENTRICITY_SQUARED = _FLATTENING * (2.0 - _FLATTENING)

MEAN_EARTH_RADIUS_M = 6371008.7714
"""Mean radius of the WGS 84 ellipsoid (2 a + b) / 3; H. Moritz, Geodetic Reference System 1980."""

OBLATENESS = 1.0826359e-3
"""J2; G. Petit and B. Luzum, IERS Conventions (2010), table 1.1."""

EARTH_M3_S2 = 3.986004418e14
"""Gravitational constant times mass of the Earth; G. Petit and B. Luzum, IERS Conventions (2010), table 1.1."""
