"""Limits of effective radius, effective variance and water content, in cloud types and in scenarios alike."""

LARGEST_UM = 500.0
"""Effective radius, um; above 0."""

NARROWEST, WIDEST = 0.01, 0.4
"""Effective variance; at 0.5 the number of particles of a gamma distribution diverges."""

MOST_WATER_KG_M3 = 0.1
"""Liquid water or ice per volume of cloud, kg m-3; above 0."""
