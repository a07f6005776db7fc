"""Writing of three-dimensional occupancy as NetCDF."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.metadata import creation_time
from hcss_twin.report.cloud_columns import CloudColumns, altitude_edges, occupancy
from hcss_twin.version import __version__

_EPOCH = np.datetime64("1970-01-01T00:00:00", "ms")


def write_occupancy(columns: CloudColumns, path: Path, step_m: float) -> tuple[int, int, int]:
    """Write the share of each voxel that cloud fills (CF-1.11), in levels of ``step_m``.

    The file has its final name only when it is complete; an older one stays until then.

    Parameters
    ----------
    columns : CloudColumns
        One frame; with cloud in at least one pixel.
    path : Path
        File to write; its folder must exist.
    step_m : float
        Height of a voxel in metres.

    Returns
    -------
    tuple of int
        Levels, rows and columns.

    Raises
    ------
    CubeError
        If the frame is clear, the step is out of its range, or the file cannot be written.
    """
    if columns.is_clear:
        raise CubeError(f"frame {columns.frame} has no cloud: there is no volume to write")
    try:
        edges = altitude_edges(float(np.nanmin(columns.base_m)), float(np.nanmax(columns.top_m)), step_m)
    except ValueError as error:
        raise CubeError(str(error)) from error
    shares = occupancy(columns.base_m, columns.top_m, edges)
    shares *= columns.fraction.astype(np.float32)
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        _write(draft, columns, edges, shares)
        os.replace(draft, path)
    except OSError as error:
        raise CubeError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        draft.unlink(missing_ok=True)
    levels, rows, width = shares.shape
    return levels, rows, width


def _write(path: Path, columns: CloudColumns, edges: NDArray[np.float64], shares: NDArray[np.float32]) -> None:
    import netCDF4

    centres = 0.5 * (edges[:-1] + edges[1:])
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(
            {
                "Conventions": "CF-1.11",
                "title": f"Cloud occupancy of: {columns.title}",
                "source": f"hcss_twin {__version__}, from cloud thickness and top altitude of a simulated cube",
                "comment": "Simulated, not observed. One slab of cloud per column, over the cloudy part of "
                "the pixel; volume in a column divided by the area of the pixel is the cube's thickness.",
                "history": f"{creation_time():%Y-%m-%dT%H:%M:%SZ} created by hcss_twin",
                "frame": np.int32(columns.frame),
            }
        )
        file.createDimension("bound", 2)
        for name, values, attributes in (
            ("altitude", centres, {"standard_name": "altitude", "positive": "up", "axis": "Z"}),
            ("y", columns.y_m, {"standard_name": "projection_y_coordinate", "axis": "Y"}),
            ("x", columns.x_m, {"standard_name": "projection_x_coordinate", "axis": "X"}),
        ):
            file.createDimension(name, values.size)
            _variable(file, name, "f8", (name,), {"units": "m", "long_name": _LONG_NAMES[name], **attributes})
            file[name][:] = values
        file["altitude"].bounds = "altitude_bounds"
        _variable(file, "altitude_bounds", "f8", ("altitude", "bound"), {})
        file["altitude_bounds"][:] = np.stack((edges[:-1], edges[1:]), axis=1)
        time = {
            "units": "seconds since 1970-01-01 00:00:00",
            "calendar": "standard",
            "units_metadata": "leap_seconds: none",
            "standard_name": "time",
            "long_name": "time of the frame",
            "axis": "T",
        }
        _variable(file, "time", "f8", (), time)
        file["time"].assignValue((columns.time - _EPOCH) / np.timedelta64(1, "s"))
        described = {
            "units": "1",
            "long_name": "share of the voxel that is filled with cloud",
            "coordinates": "time",
            "cell_methods": "altitude: y: x: mean",
            "comment": "Volume fraction between the bounds of altitude and over the pixel.",
        }
        shape = ("altitude", "y", "x")
        # Most voxels are 0 or 1: the cheapest level makes the file many times smaller.
        _variable(file, "cloud_occupancy", "f4", shape, described, compression="zlib", complevel=1, shuffle=True)
        file["cloud_occupancy"][:] = shares


_LONG_NAMES = {
    "altitude": "altitude of the voxel's centre above the sea",
    "y": "distance north of the image centre",
    "x": "distance east of the image centre",
}


def _variable(
    file: Any, name: str, kind: str, dimensions: tuple[str, ...], attributes: Mapping[str, str], **layout: Any
) -> None:
    variable = file.createVariable(name, kind, dimensions, fill_value=False, **layout)
    variable.setncatts(dict(attributes))
