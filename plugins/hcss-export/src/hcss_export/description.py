"""Description of exported images in words and numbers, as the formats write it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_export.projection import Projection
from hcss_twin import __version__
from hcss_twin.core.json_numbers import json_value
from hcss_twin.cube.frame_selection import FrameSelection


def description(selection: FrameSelection, projection: Projection | None, source: str) -> dict[str, Any]:
    """Return what an export is of, without its values, for JSON: readers of a format get all of it.

    Parameters
    ----------
    projection : Projection or None
        Of the cube; None if the image is no grid on the ground.
    source : str
        Name of the cube's file.
    """
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
        "grid": _grid(selection, projection),
        "attributes": selection.attributes,
    }


def _grid(selection: FrameSelection, projection: Projection | None) -> dict[str, Any] | None:
    grid = selection.grid
    if grid is None or projection is None:
        return None
    return {
        "projection": "azimuthal equidistant",
        **asdict(projection),
        "west_pixel_centre_m": grid.west_m,
        "south_pixel_centre_m": grid.south_m,
        "pixel_size_x_m": grid.step_x_m,
        "pixel_size_y_m": grid.step_y_m,
        "wkt": projection.esri_wkt,
    }


def first_row(selection: FrameSelection) -> str:
    """Return which row an image begins with that is written from above."""
    return "the northernmost" if selection.grid is not None else "the highest"


def json_text(document: dict[str, Any]) -> str:
    """Serialise a document as ASCII JSON; non-finite numbers become null."""
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def headline(selection: FrameSelection) -> str:
    """Return a one-line title, for formats that display one."""
    units = f", {selection.units}" if selection.units not in ("", "1") else ""
    return f"{selection.long_name or selection.variable}{units}"


def image_name(frame: FrameSelection.Frame, plane: FrameSelection.Plane) -> str:
    """Return the name of one exported image."""
    named = plane.name or "image"
    return named if frame.number is None else f"{named} frame {frame.number} ({frame.time})"


def ascii_text(text: str) -> str:
    """Escape non-ASCII characters and replace line breaks by spaces: many formats allow printable ASCII only."""
    flat = " ".join(text.split())
    return flat.encode("ascii", "backslashreplace").decode()


def count_missing(values: NDArray[Any]) -> int:
    """Return the number of NaN values; integers have none."""
    return int(np.count_nonzero(np.isnan(values))) if values.dtype.kind == "f" else 0


def calibration(attributes: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return what is known about each band of a measured cube's sensor; of a chain, of its last digitising stage."""
    sensor = json.loads(str(attributes.get("hcss_sensor", "{}")))
    stages = [stage.get("worked_out", {}).get("bands", {}) for stage in sensor.get("stages", [sensor])]
    digitising = [bands for bands in stages if any("radiance_per_number" in of_band for of_band in bands.values())]
    return digitising[-1] if digitising else {}
