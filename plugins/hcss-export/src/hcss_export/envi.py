"""ENVI: raw band-sequential data with a text header.

Header fields follow "ENVI Header Files" in the ENVI documentation (NV5 Geospatial).
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from hcss_export.description import ascii_text, count_missing, description, first_row, headline, image_name, json_text
from hcss_export.projection import Projection
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError

_TYPES = {
    "u1": 1, "i2": 2, "i4": 3, "f4": 4, "f8": 5, "u2": 12, "u4": 13, "i8": 14, "u8": 15,
}  # fmt: skip
"""ENVI data type codes."""


def write_envi(
    selection: FrameSelection, projection: Projection | None, source: str, raw: Path, header: Path, described: Path
) -> int:
    """Write all frames as bands of one file, one at a time, and return the number of missing values.

    Bands are ordered by frame, then by band within a frame. The first line is the northernmost. Missing values are NaN,
    as stated in the header. If the platform moves, frames have different locations: only a file with one frame is then
    georeferenced; others use metres from the centre of each frame.

    Parameters
    ----------
    projection : Projection or None
        Of the cube; None if the image is no grid on the ground.
    source : str
        Name of the cube's file.
    raw, header, described : Path
        New files; the last is a JSON with metadata that the header cannot store.

    Raises
    ------
    CubeError
        If ENVI does not support the data type.
    OSError
        If a file cannot be written.
    """
    code = _TYPES.get(f"{selection.dtype.kind}{selection.dtype.itemsize}")
    if code is None:
        raise CubeError(f"values of type {selection.dtype} cannot be stored in ENVI; allowed: {', '.join(_TYPES)}")
    missing = 0
    with raw.open("wb") as file:
        for frame in selection.frames:
            values = selection.values(frame)
            missing += count_missing(values)
            file.write(values[:, ::-1].astype(selection.dtype.newbyteorder("=")).tobytes())
    fields = _fields(selection, projection, source, code)
    text = "".join(f"{name} = {value}\n" for name, value in fields.items())
    header.write_text(f"ENVI\n{text}", encoding="ascii")
    document = {
        **description(selection, projection, source),
        "row_order": f"{first_row(selection)} first",
        "interleave": "frame, plane, row, column",
    }
    described.write_text(json_text(document), encoding="ascii")
    return missing


def _fields(selection: FrameSelection, projection: Projection | None, source: str, code: int) -> dict[str, Any]:
    images = [(frame, plane) for frame in selection.frames for plane in selection.planes]
    fields: dict[str, Any] = {
        "description": _braces([f"{headline(selection)}; from {source}; the first line is {first_row(selection)}"]),
        "samples": selection.columns,
        "lines": selection.rows,
        "bands": len(images),
        "header offset": 0,
        "file type": "ENVI Standard",
        "data type": code,
        "interleave": "bsq",
        "byte order": 0 if sys.byteorder == "little" else 1,
        "acquisition time": selection.frames[0].time,
        "band names": _braces([image_name(frame, plane) for frame, plane in images]),
        "data units": ascii_text(selection.units),
        "hcss variable": ascii_text(selection.variable),
        "hcss cube id": ascii_text(str(selection.attributes.get("id", ""))),
        "hcss frame times": _braces([f"{frame.seconds!r}" for frame in selection.frames]),
        "hcss centre displacements": _braces([f"{frame.displacement_m!r}" for frame in selection.frames]),
    }
    if np.issubdtype(selection.dtype, np.floating):
        fields["data ignore value"] = "NaN"
    if selection.plane_kind == "band":
        fields["wavelength units"] = "Micrometers"
        fields["wavelength"] = _braces([f"{plane.central_um!r}" for _, plane in images])
        widths = [(plane.upper_um or 0.0) - (plane.lower_um or 0.0) for _, plane in images]
        fields["fwhm"] = _braces([f"{width:.9g}" for width in widths])
    return {**fields, **_map(selection, projection)}


def _map(selection: FrameSelection, projection: Projection | None) -> dict[str, str]:
    """Return the map fields: coordinates of the upper left corner, ENVI's pixel (1, 1)."""
    grid = selection.grid
    if grid is None or projection is None:
        return {}
    shifts = {frame.displacement_m for frame in selection.frames}
    north = grid.south_m + (selection.rows - 0.5) * grid.step_y_m
    west = grid.west_m - 0.5 * grid.step_x_m
    if len(shifts) > 1:
        corner = f"1.0, 1.0, {west!r}, {north!r}, {grid.step_x_m!r}, {grid.step_y_m!r}"
        return {"map info": f"{{Arbitrary, {corner}, 0, units=Meters}}"}
    corner = f"1.0, 1.0, {west + shifts.pop()!r}, {north!r}, {grid.step_x_m!r}, {grid.step_y_m!r}"
    return {
        "map info": f"{{Local_Plane, {corner}, units=Meters}}",
        "coordinate system string": f"{{{projection.esri_wkt}}}",
    }


def _braces(items: list[str]) -> str:
    """Return a list in ENVI syntax; commas and braces within items are replaced because they are delimiters."""
    table = str.maketrans({",": ";", "{": "(", "}": ")"})
    return "{" + ", ".join(ascii_text(item).translate(table) for item in items) + "}"
