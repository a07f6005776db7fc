"""Surface provider ``coast``: land and sea from the coastlines of Natural Earth."""

from __future__ import annotations

import numpy as np

from hcss_twin.models.surfaces.coastline import Coastline
from hcss_twin.models.surfaces.parameters import CoastParameters
from hcss_twin.providers import Declaration, SurfaceClass, SurfaceInputs, SurfaceMap


class Coast:
    """Land of one class, and sea.

    Parameters
    ----------
    inputs : SurfaceInputs
    parameters : CoastParameters
    """

    declares = Declaration(
        notes=(
            "coast: coastlines of Natural Earth, 1:10 million, true to about 1 km; lakes are land, and islands smaller "
            "than about 1 km are missing",
        )
    )

    def __init__(self, inputs: SurfaceInputs, parameters: CoastParameters) -> None:
        self._inputs = inputs
        path = inputs.catalog.find("coastline", "surfaces", ".npz")
        self._coastline: Coastline = inputs.catalog.shelf.parsed(path, Coastline.read)
        self.classes = (SurfaceClass("sea"), SurfaceClass(parameters.land, parameters.land_temperature))

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return 1 for points on land."""
        return SurfaceMap(self._coastline.is_land(*self._inputs.ground(time_s, rows, columns)).view(np.uint8))
