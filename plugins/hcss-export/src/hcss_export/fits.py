"""FITS: one image array of all frames, and tables of frames, bands and attributes.

The standard is version 4.0 (2018) of the IAU FITS Working Group; comments cite its sections.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_export.description import ascii_text, calibration, count_missing, headline
from hcss_export.projection import Projection
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError

_WIDER = {"i1": "i2", "u2": "i4", "u4": "i8"}
"""FITS has no such integers (section 5.2): values are stored in the next wider type."""

_PER_NUMBER, _AT_0 = "radiance_per_number", "radiance_at_number_0"

_MOST_CONSTANTS = 99
"""Names of keywords have eight characters (section 4.1.2)."""

_COMMENT = 47
"""Characters of a comment behind a number that fit into a record of 80 (section 4.1.2)."""

_EVEN = 1e-6
"""Largest deviation of frame times from even spacing, in steps."""


def write_fits(selection: FrameSelection, projection: Projection | None, source: str, path: Path) -> int:
    """Write all frames of a selection, one at a time, and return the number of missing values.

    Image axes are x, y, then band or layer, then time, if the variable has them. Rows increase northward, as FITS
    readers display them. Missing values are NaN (section 5.3).

    Parameters
    ----------
    projection : Projection or None
        Of the cube; None if the image is no grid on the ground.
    source : str
        Name of the cube's file.
    path : Path
        A new file.

    Raises
    ------
    CubeError
        If astropy is not installed, or FITS does not support the data type.
    OSError
        If the file cannot be written.
    """
    try:
        from astropy.io import fits
    except ImportError as error:
        raise CubeError(
            "FITS needs the package astropy; install it with: "
            "pip install './plugins/hcss-export[fits]' in a checkout of hcss_twin"
        ) from error

    kind = _stored(selection.dtype)
    stream = fits.StreamingHDU(str(path), _image_header(fits, selection, projection, source, kind))
    missing = 0
    try:
        for frame in selection.frames:
            values = selection.values(frame)
            missing += count_missing(values)
            stream.write(values.astype(kind))
    finally:
        stream.close()
    with fits.open(path, mode="append") as file:
        for table in _tables(fits, selection):
            file.append(table)
    return missing


def _stored(dtype: np.dtype[Any]) -> np.dtype[Any]:
    name = f"{dtype.kind}{dtype.itemsize}"
    name = _WIDER.get(name, name)
    if name not in ("u1", "i2", "i4", "i8", "f4", "f8"):
        raise CubeError(f"values of type {dtype} cannot be stored in FITS; allowed: floats of 32 or 64 bits, integers")
    return np.dtype(name).newbyteorder(">")


def _image_header(
    fits: Any, selection: FrameSelection, projection: Projection | None, source: str, kind: np.dtype[Any]
) -> Any:
    axes = [("x", selection.columns), ("y", selection.rows)]
    if selection.plane_kind:
        axes.append((selection.plane_kind, len(selection.planes)))
    if selection.frames[0].number is not None:
        axes.append(("time", len(selection.frames)))
    header = fits.Header()
    header["SIMPLE"] = True
    header["BITPIX"] = kind.itemsize * (-8 if kind.kind == "f" else 8)
    header["NAXIS"] = len(axes)
    for number, (_, size) in enumerate(axes, 1):
        header[f"NAXIS{number}"] = size
    header["EXTEND"] = True
    header["BTYPE"] = ascii_text(selection.variable)
    header["BUNIT"] = "" if selection.units == "1" else ascii_text(selection.units)
    header["OBJECT"] = ascii_text(headline(selection))
    first = np.datetime64(selection.frames[0].time.rstrip("Z"), "us")
    start = first - np.timedelta64(round(selection.frames[0].seconds * 1e6), "us")
    header["TIMESYS"] = "UTC"
    header["DATE-OBS"] = (str(first), "time of the first frame")
    header["MJD-OBS"] = (_modified_julian_day(first), "[d] the same")
    header["DATEREF"] = (str(start), "start of the scenario: TIME is 0")
    header["MJDREF"] = (_modified_julian_day(start), "[d] the same")
    _axes(header, selection, axes)
    if projection is not None:
        header["LAT0"] = (projection.latitude, "[deg] origin of x and y, north")
        header["LON0"] = (projection.longitude, "[deg] origin of x and y, east")
        header["PROJ"] = ("azimuthal equidistant", "of the plane of x and y")
        header["SEMIMAJ"] = (projection.semi_major_m, "[m] radius of the Earth there")
        header["INVFLAT"] = (projection.inverse_flattening, "inverse flattening, 0: sphere")
    order = "lowest" if projection is None else "southernmost"
    header["ROWORDER"] = ("BOTTOM-UP", f"the first row of the array is the {order}")
    for number, (name, per_number, at_0) in enumerate(_constants(selection)[:_MOST_CONSTANTS], 1):
        header[f"DNGAIN{number}"] = (per_number, f"[W m-2 sr-1] radiance per number, {ascii_text(name)}"[:_COMMENT])
        header[f"DNZERO{number}"] = (at_0, f"[W m-2 sr-1] radiance at number 0, {ascii_text(name)}"[:_COMMENT])
    header["CUBE"] = ascii_text(source)
    header["CUBEID"] = ascii_text(str(selection.attributes.get("id", "")))
    header["CREATOR"] = ascii_text(str(selection.attributes.get("source", "hcss_twin")))
    if selection.comment:
        header["COMMENT"] = ascii_text(selection.comment)
    if projection is None:
        header["COMMENT"] = "columns and rows of an image that is no grid on the ground; rows are counted"
        header["COMMENT"] = "upward from the lowest. NaN: missing value."
        return header
    header["COMMENT"] = "x points east, y north, relative to the centre of each frame; the table FRAMES"
    header["COMMENT"] = "gives the displacement of that centre. NaN: missing value."
    return header


def _constants(selection: FrameSelection) -> list[tuple[str, float, float]]:
    """Return name, radiance of a digital number, and radiance at number 0 of each band of a variable with numbers."""
    if selection.variable != "digital_number" or selection.plane_kind != "band":
        return []
    bands = calibration(selection.attributes)
    known = [(plane.name, bands.get(plane.name, {})) for plane in selection.planes]
    return [(name, of_band[_PER_NUMBER], of_band[_AT_0]) for name, of_band in known if _PER_NUMBER in of_band]


def _modified_julian_day(time: np.datetime64) -> float:
    return float((time - np.datetime64("1858-11-17")) / np.timedelta64(1, "D"))


def _axes(header: Any, selection: FrameSelection, axes: list[tuple[str, int]]) -> None:
    """Write the linear coordinates of the axes (section 8.2)."""
    grid = selection.grid
    known = {
        "x": ("COLUMN", "", 1.0, 1.0) if grid is None else ("X", "m", grid.west_m, grid.step_x_m),
        "y": ("ROW", "", 1.0, 1.0) if grid is None else ("Y", "m", grid.south_m, grid.step_y_m),
        "band": ("BAND", "", 1.0, 1.0),
        "layer": ("LAYER", "", 1.0, 1.0),
        "time": _time_axis(selection),
    }
    for number, (name, _) in enumerate(axes, 1):
        kind, unit, first, step = known[name]
        header[f"CTYPE{number}"] = kind
        header[f"CUNIT{number}"] = unit
        header[f"CRPIX{number}"] = 1.0
        header[f"CRVAL{number}"] = first
        header[f"CDELT{number}"] = step


def _time_axis(selection: FrameSelection) -> tuple[str, str, float, float]:
    """Seconds since the scenario's start if steps are even; otherwise the row number in the table FRAMES."""
    seconds = np.array([frame.seconds for frame in selection.frames])
    if seconds.size == 1:
        return "TIME", "s", float(seconds[0]), 1.0
    step = float(seconds[-1] - seconds[0]) / (seconds.size - 1)
    even = seconds[0] + step * np.arange(seconds.size)
    if step > 0.0 and np.max(np.abs(seconds - even)) <= _EVEN * step:
        return "TIME", "s", float(seconds[0]), step
    return "FRAME", "", 1.0, 1.0


def _tables(fits: Any, selection: FrameSelection) -> list[Any]:
    frames, planes = selection.frames, selection.planes
    tables = [
        _table(
            fits,
            "FRAMES",
            [
                ("number", "J", None, [-1 if frame.number is None else frame.number for frame in frames]),
                ("time", _width([frame.time for frame in frames]), None, [frame.time for frame in frames]),
                ("seconds_since_start", "D", "s", [frame.seconds for frame in frames]),
                ("centre_displacement", "D", "m", [frame.displacement_m for frame in frames]),
            ],
        )
    ]
    if selection.plane_kind:
        names = [ascii_text(plane.name) for plane in planes]
        columns: list[tuple[str, str, str | None, Any]] = [("name", _width(names), None, names)]
        if selection.plane_kind == "band":
            columns += [
                ("lower", "D", "um", [plane.lower_um for plane in planes]),
                ("central", "D", "um", [plane.central_um for plane in planes]),
                ("upper", "D", "um", [plane.upper_um for plane in planes]),
            ]
        tables.append(_table(fits, f"{selection.plane_kind.upper()}S", columns))
    names = [ascii_text(name) for name in selection.attributes]
    values = [json.dumps(value) for value in selection.attributes.values()]
    tables.append(
        _table(fits, "ATTRIBUTES", [("name", _width(names), None, names), ("json", _width(values), None, values)])
    )
    return tables


def _width(texts: list[str]) -> str:
    return f"{max(1, *(len(text) for text in texts), 1)}A"


def _table(fits: Any, name: str, columns: list[tuple[str, str, str | None, Any]]) -> Any:
    fits_columns = [
        fits.Column(name=title, format=kind, unit=unit, array=_array(values)) for title, kind, unit, values in columns
    ]
    return fits.BinTableHDU.from_columns(fits_columns, name=name)


def _array(values: Any) -> NDArray[Any]:
    return np.asarray(values)
