"""The shape of a cloud type as a start."""

from __future__ import annotations

import numpy as np

from hcss_twin.catalog import Catalog
from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.matching.cloud_image import CloudImage

# The frame of the paper's tables.
SIDE = 800
PIXEL_SIZE_M = 20.0


def type_parameters(cloud_type: str, catalog: Catalog) -> FractalParameters:
    """Return the complete parameters of a cloud type of the catalog.

    Raises
    ------
    CatalogError
        If there is no such type.
    """
    shape = catalog.toml(catalog.find(cloud_type, "cloud_types", ".toml"))["fractal"]
    x, y = shape["L"]
    first, last = shape["k"]
    return FractalParameters(
        gamma=float(shape["gamma"]), H=float(shape["H"]), L=(float(x), float(y)), k=(first, last)
    )


def empty_frame(rows: int = SIDE, columns: int = SIDE, pixel_size_m: float = PIXEL_SIZE_M) -> CloudImage:
    """Return a frame that only has a size; that of the paper by default."""
    return CloudImage(np.zeros((rows, columns), dtype=np.float32), pixel_size_m)
