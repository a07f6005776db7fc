"""What captions and text state about the figures, in numbers."""

from __future__ import annotations

CLOUD_HEIGHTS_KM = {
    "stratus": (0.033, 1.0),
    "cumulus": (0.066, 3.0),
    "cirrus": (6.0, 10.0),
    "simulated": (0.333, 6.0),
}
"""Base and top by Table III."""

COVERAGES = (0.1, 0.2, 0.3, 0.4, 0.5)
"""Fig 13."""

COVERAGE_RADIANCE = (0.648, 0.638, 0.624, 0.606, 0.604)
"""Mean radiance at these, 3-5 um, W m-2 sr-1 (Table VII)."""
