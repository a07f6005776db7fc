"""A small cube of random numbers, for tests of code that writes or reads cubes."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.frames import frame_shape
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE, BandInfo, CubeHeader, LayerInfo
from hcss_twin.cube.requested_variables import expand

EXAMPLE_TERMS = {"sea_emission": "Emission of the sea.", "sun_glint": "Sunlight reflected by the sea."}


def example_header(**changes: Any) -> CubeHeader:
    """Return the header of a cube with three frames of 5 x 7 pixels, two bands, two layers and every variable.

    Parameters
    ----------
    **changes
        Fields of :class:`CubeHeader` to replace.
    """
    fields: dict[str, Any] = {
        "start": datetime(2024, 6, 1, 12, tzinfo=UTC),
        "frame_times_s": (0.0, 0.5, 1.0),
        "bands": (BandInfo("SWIR", 2.7, 3.0, 2.85), BandInfo("MWIR", 3.0, 5.0, 4.0)),
        "rows": 5,
        "columns": 7,
        "pixel_size_m": 100.0,
        "latitude": 20.0,
        "longitude": 135.0,
        "view_zenith_deg": 30.0,
        "view_azimuth_deg": 120.0,
        "solar_zenith_deg": (24.0, 24.1, 24.2),
        "solar_azimuth_deg": (180.0, 180.1, 180.2),
        "variables": tuple(expand(["all"], EXAMPLE_TERMS, layer_count=2, shadows=True)),
        "attributes": {SCENARIO_ATTRIBUTE: "[scene]\nname = 'example'\n", "seed": 1},
        "layers": (LayerInfo("cumulus", 66.0, 3000.0), LayerInfo("cirrus", 6000.0, 10_000.0)),
        **changes,
    }
    return CubeHeader(**fields)


def example_frame(header: CubeHeader, index: int) -> dict[str, NDArray[Any]]:
    """Return arrays of random numbers that make a valid frame; the same for the same index."""
    random = np.random.default_rng(index)
    arrays: dict[str, NDArray[Any]] = {}
    for spec in header.variables:
        shape = frame_shape(header, spec)
        if spec.dtype == "uint8":
            arrays[spec.name] = random.integers(0, 2, shape, dtype=np.uint8)
            continue
        values = random.random(shape, dtype=np.float32)
        if spec.may_be_missing:
            values[values < 0.5] = np.nan
        arrays[spec.name] = values
    return arrays
