"""Points within a pixel that a scene can have in at most twice the time of a frame with one."""

from __future__ import annotations

import math

FRAME_NS, SENSOR_NS, POINT_NS, BAND_NS = 16.0, 50.0, 20.0, 3.3
"""Time of a pixel, and of its sensor in a band; of a point, and of its radiance in a band (one processor; frames of 800
x 800 pixels of stratus, cumulus and cirrus with 1 and 2 points along a pixel)."""

MOST_POINTS = 2**24
"""Points of a frame, beyond which one a pixel is chosen."""


def points_along_pixel(rows: int, columns: int, bands: int, has_sensor: bool) -> int:
    """Return how many points along a pixel take at most twice the time of one."""
    pixel, point = FRAME_NS + SENSOR_NS * bands * has_sensor, POINT_NS + BAND_NS * bands
    count = math.floor(math.sqrt(2.0 + pixel / point))
    return count if rows * columns * count**2 <= MOST_POINTS else 1
