"""GeoTIFF: one frame, its bands as planes of one file, placed on the globe.

Keys and codes are those of OGC GeoTIFF 1.1 (19-008r4), the coordinate transformation code 12 among them
(CT_AzimuthalEquidistant, annex C of the GeoTIFF 1.0 specification). Names and units of bands go into the tags 42112
and 42113 of GDAL, which most readers know.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from hcss_twin.cube.export.place import LocalPlane
from hcss_twin.cube.export.selection import (
    Frame,
    Selection,
    ascii_text,
    count_missing,
    description,
    headline,
    json_text,
)

_USER_DEFINED = 32767
_WGS84 = 4326
_METRE, _DEGREE = 9001, 9102
_AZIMUTHAL_EQUIDISTANT = 12
_PROJECTED, _PIXEL_IS_AREA = 1, 1

_DOUBLES, _ASCII = 34736, 34737


def write_geotiff(selection: Selection, source: str, frame: Frame, path: Path) -> int:
    """Write one frame, the northernmost row first, and return how many values are missing: NaN, and the file says so.

    Parameters
    ----------
    source : str
        Name of the cube's file.
    frame : Frame
        One of the selection; its displacement is added to x, which places it on the plane of the start.
    path : Path
        A new file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import tifffile

    values = selection.values(frame)[:, ::-1]
    shape: dict[str, Any] = {"photometric": "minisblack"}
    if len(values) > 1:
        shape["planarconfig"] = "separate"
    else:
        values = values[0]
    tifffile.imwrite(
        path,
        np.ascontiguousarray(values),
        description=json_text({**description(selection, source), "frames": [vars(frame)], "row_order": "north first"}),
        datetime=None,
        metadata=None,
        software=False,
        extratags=_tags(selection, frame),
        **shape,
    )
    return count_missing(values)


def _tags(selection: Selection, frame: Frame) -> list[tuple[int, str, int, Any, bool]]:
    grid = selection.grid
    west = grid.west_m - 0.5 * grid.step_x_m + frame.displacement_m
    north = grid.south_m + (selection.rows - 0.5) * grid.step_y_m
    directory, doubles, text = _geo_keys(grid.plane)
    gdal = _gdal_metadata(selection, frame)
    tags: list[tuple[int, str, int, Any, bool]] = [
        (33550, "d", 3, (grid.step_x_m, grid.step_y_m, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0), True),
        (34735, "H", len(directory), directory, True),
        (_DOUBLES, "d", len(doubles), doubles, True),
        (_ASCII, "s", 0, text, True),
        (42112, "s", 0, gdal, True),
    ]
    if selection.dtype.kind == "f":
        tags.append((42113, "s", 0, "nan", True))
    return tags


def _geo_keys(plane: LocalPlane) -> tuple[tuple[int, ...], tuple[float, ...], str]:
    """Return the directory of keys (sorted, as the standard wants), its floats and its text."""
    citation = "hcss_twin local plane: azimuthal equidistant about the image centre at the start|"
    figure: dict[int, int | float | str] = (
        {2048: _WGS84}
        if plane.is_wgs84
        else {
            2048: _USER_DEFINED,
            2050: _USER_DEFINED,
            2054: _DEGREE,
            2056: _USER_DEFINED,
            2057: plane.semi_major_m,
            **({2059: plane.inverse_flattening} if plane.inverse_flattening else {2058: plane.semi_major_m}),
        }
    )
    keys: dict[int, int | float | str] = {
        1024: _PROJECTED,
        1025: _PIXEL_IS_AREA,
        1026: citation,
        **figure,
        3072: _USER_DEFINED,
        3074: _USER_DEFINED,
        3075: _AZIMUTHAL_EQUIDISTANT,
        3076: _METRE,
        3082: 0.0,
        3083: 0.0,
        3088: plane.longitude,
        3089: plane.latitude,
    }
    directory: list[int] = [1, 1, 0, len(keys)]
    doubles: list[float] = []
    for key, value in sorted(keys.items()):
        if isinstance(value, str):
            directory += [key, _ASCII, len(value), 0]
        elif isinstance(value, float):
            directory += [key, _DOUBLES, 1, len(doubles)]
            doubles.append(value)
        else:
            directory += [key, 0, 1, value]
    return tuple(directory), tuple(doubles), citation


def _gdal_metadata(selection: Selection, frame: Frame) -> str:
    items = {
        "variable": selection.variable,
        "long_name": headline(selection),
        "units": selection.units,
        "time": frame.time,
        "seconds_since_start": repr(frame.seconds),
        "centre_displacement_m": repr(frame.displacement_m),
        "cube_id": str(selection.attributes.get("id", "")),
        "title": str(selection.attributes.get("title", "")),
    }
    lines = [f"<Item name={quoteattr(name)}>{_xml(text)}</Item>" for name, text in items.items()]
    for number, plane in enumerate(selection.planes):
        lines.append(
            f'<Item name="DESCRIPTION" sample="{number}" role="description">'
            f"{_xml(plane.name or selection.variable)}</Item>"
        )
        lines.append(f'<Item name="UNITTYPE" sample="{number}" role="unittype">{_xml(selection.units)}</Item>')
        if plane.central_um is not None:
            for name in ("lower_um", "central_um", "upper_um"):
                lines.append(f'<Item name="{name}" sample="{number}">{getattr(plane, name)!r}</Item>')
    return "<GDALMetadata>\n" + "\n".join(lines) + "\n</GDALMetadata>\n"


def _xml(text: str) -> str:
    return escape(ascii_text(text))
