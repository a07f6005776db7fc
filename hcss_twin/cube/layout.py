"""Dimensions and attributes of the variables of a cube, whatever format it is written in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hcss_twin.cube.bit_rounding import INFO, largest_error
from hcss_twin.cube.coordinates import BOUND, GRID_MAPPING, VERTEX, auxiliary_names, is_bounds, time_units
from hcss_twin.cube.footprint import footprint
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.version import __version__

QUANTIZATION_ATTRIBUTES: Mapping[str, str] = {
    "algorithm": "bitround",
    "implementation": f"hcss_twin version {__version__}",
}
"""Of the variable that says how others were rounded."""


def dimensions(header: CubeHeader) -> dict[str, int]:
    """Return the length of every dimension."""
    return {**header.sizes, BOUND: 2, VERTEX: len(footprint(header).outline)}


def coordinate_attributes(spec: VariableSpec, header: CubeHeader) -> dict[str, Any]:
    """Return the attributes of a coordinate variable; boundary variables have none."""
    found = {} if is_bounds(spec) else variable_attributes(spec)
    return {**found, "units": time_units(header)} if spec.name == "time" else found


def variable_attributes(spec: VariableSpec) -> dict[str, Any]:
    """Return the attributes of a variable but its links to others."""
    found: dict[str, Any] = {"long_name": spec.long_name, "comment": spec.description}
    if spec.standard_name is not None:
        found["standard_name"] = spec.standard_name
    if spec.units is not None:
        found["units"] = spec.units
    content = "coordinate" if spec.kind in ("coordinate", "geometry") else "modelResult"
    if spec.significant_bits is not None:
        found["quantization"] = INFO
        found["quantization_nsb"] = np.int32(spec.significant_bits)
        found["quantization_maximum_relative_error"] = np.float32(largest_error(spec.significant_bits))
    return {**found, "coverage_content_type": content, **spec.attributes}


def links(spec: VariableSpec, header: CubeHeader) -> dict[str, str]:
    """Return the attributes of a variable that name others; coordinates of pixels, which others name, have none."""
    if spec.kind == "geometry":
        return {}
    return {"coordinates": " ".join(auxiliary_names(header, spec.dims)), "grid_mapping": GRID_MAPPING}
