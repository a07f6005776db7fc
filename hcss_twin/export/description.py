"""What every format is told about an export, as far as it has room for it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from hcss_twin.export.selection import Frame, Plane, Selection
from hcss_twin.json_numbers import json_value
from hcss_twin.version import __version__


def description(selection: Selection, source: str) -> dict[str, Any]:
    """Return everything that is known of an export but its values, as JSON can say it.

    Parameters
    ----------
    source : str
        Name of the cube's file.
    """
    grid = selection.grid
    return {
        "exported_by": f"hcss_twin {__version__}",
        "cube": source,
        "variable": selection.variable,
        "units": selection.units,
        "long_name": selection.long_name,
        "standard_name": selection.standard_name,
        "comment": selection.comment,
        "rows": selection.rows,
        "columns": selection.columns,
        "plane_kind": selection.plane_kind,
        "planes": [asdict(plane) for plane in selection.planes],
        "frames": [asdict(frame) for frame in selection.frames],
        "grid": {
            "projection": "azimuthal equidistant",
            **asdict(grid.plane),
            "west_pixel_centre_m": grid.west_m,
            "south_pixel_centre_m": grid.south_m,
            "pixel_size_x_m": grid.step_x_m,
            "pixel_size_y_m": grid.step_y_m,
            "wkt": grid.plane.esri_wkt,
        },
        "attributes": selection.attributes,
    }


def json_text(document: dict[str, Any]) -> str:
    """Write a document as ASCII, in which numbers that are not finite, which JSON does not have, are null."""
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def headline(selection: Selection) -> str:
    """Return one line, for formats that show one."""
    units = f", {selection.units}" if selection.units not in ("", "1") else ""
    return f"{selection.long_name or selection.variable}{units}"


def image_name(frame: Frame, plane: Plane) -> str:
    """Name one image of an export."""
    named = plane.name or "image"
    return named if frame.number is None else f"{named} frame {frame.number} ({frame.time})"


def ascii_text(text: str) -> str:
    """Write other characters as escapes, and line ends as blanks: many formats hold printable ASCII only."""
    flat = " ".join(text.split())
    return flat.encode("ascii", "backslashreplace").decode()
