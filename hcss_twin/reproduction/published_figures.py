"""What the paper states about its figures, in numbers."""

from __future__ import annotations

CLOUD_HEIGHTS_KM = {
    "stratus": (0.033, 1.0),
    "cumulus": (0.066, 3.0),
    "cirrus": (6.0, 10.0),
    "simulated": (0.333, 6.0),
}
"""Base and top by Table III."""
