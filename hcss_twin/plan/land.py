"""Share of land in the image of a scene without ``[surfaces]``, which is sea everywhere."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.scenario.scenario import Scenario

_SIDE = 64
"""Points along each side of the image that are looked up, at the start and at the end."""

_STEP_M = 40_000.0
"""Distance of points in the search for cells of a degree with land."""


def land_share(scenario: Scenario, catalog: Catalog, last_s: float) -> float:
    """Return the share of land in the image, mean of the first and the last frame; 0 if the data are not installed.

    Cells of a degree without land rule it out for most scenes over the ocean, without reading coastlines.
    """
    moved = [float(scenario.motion.platform_speed) * time_s for time_s in sorted({0.0, last_s})]
    image, folder = scenario.image, catalog.root / "surfaces"
    longest = max(image.rows, image.columns) * float(image.pixel_size)
    coarse = min(_SIDE, 3 + math.ceil(longest / _STEP_M))
    try:
        if not _may_have_land(*_points(scenario, coarse, moved), np.load(folder / "land-cells.npy")):
            return 0.0
        from hcss_twin.models.surfaces.coastline import Coastline  # not for scenes over the open sea

        coastline = catalog.shelf.parsed(folder / "coastline.npz", Coastline.read)
        return float(np.mean(coastline.is_land(*_points(scenario, _SIDE, moved))))
    except OSError:
        return 0.0


def _points(scenario: Scenario, side: int, moved_m: list[float]) -> tuple[Array, Array]:
    """Return latitude and longitude of evenly spaced points of the image, moved east."""
    image, place, size = scenario.image, scenario.place, float(scenario.image.pixel_size)
    centres = (np.arange(side) + 0.5) / side - 0.5
    x, y = np.meshgrid(centres * image.columns * size, centres * image.rows * size)
    along = np.stack([x + shift for shift in moved_m])
    return to_geographic(along, np.broadcast_to(y, along.shape), place.latitude, place.longitude)


def _may_have_land(latitude: Array, longitude: Array, packed: NDArray[np.uint8]) -> bool:
    """Whether a cell of a degree at or beside any point has land."""
    cells = np.unpackbits(packed).reshape(180, 360)
    row, column = np.floor(latitude + 90.0).astype(int), np.floor(longitude + 180.0).astype(int)
    steps = np.arange(-1, 2)
    rows = np.clip(row[..., None, None] + steps[:, None], 0, 179)
    return bool(np.any(cells[rows, (column[..., None, None] + steps) % 360]))
