"""The parts in which frames are made and written: whole frames where they are small, tiles where they are large.

Which tiles a frame has follows from the plan alone, and not from who makes them: the certificate draws its pixels tile
by tile, and chunks of the cube are tiles.
"""

from __future__ import annotations

import math

from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, cut

LARGEST_FRAME_BYTES = 2**28
"""Frames with more bytes in the cube are made by tiles."""

TILE_BYTES = 2**26
"""Of the variables of one tile, at most."""

TILE_PIXELS = 2**21
"""Of one tile, at most."""


def tile_shape(plan: Plan) -> tuple[int, int] | None:
    """Return the rows and columns of tiles, those at the far edges apart; None where frames are made whole.

    Tiles are nearly square, so that slant paths leave them as little as possible and readers of a window read little
    else.
    """
    rows, columns = plan.pixels
    frame_bytes = plan.uncompressed_bytes // plan.frame_times_s.size
    if frame_bytes <= LARGEST_FRAME_BYTES:
        return None
    bytes_per_pixel = math.ceil(frame_bytes / (rows * columns))
    side = max(1, math.isqrt(min(TILE_PIXELS, TILE_BYTES // bytes_per_pixel)))
    # A long and narrow image is cut along its length only.
    height = _evenly(rows, max(side, side * side // columns))
    return height, _evenly(columns, max(side, side * side // height))


def tiles(plan: Plan) -> list[Window]:
    """Return the tiles (rows, columns) of each frame, in pixels of the image, row by row."""
    shape = tile_shape(plan)
    return [plan.extent] if shape is None else list(cut(plan.extent, *shape))


def _evenly(size: int, most: int) -> int:
    """Largest part of a length that is cut into as few nearly equal ones as possible, each of at most ``most``."""
    return math.ceil(size / math.ceil(size / most))
