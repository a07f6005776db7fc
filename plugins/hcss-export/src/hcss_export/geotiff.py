"""GeoTIFF: one georeferenced file per frame, with a plane for each band; written by rasterio (GDAL)."""

from __future__ import annotations

from pathlib import Path

from hcss_export.description import ascii_text, count_missing, description, headline, json_text
from hcss_export.projection import Projection
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError


def write_geotiff(
    selection: FrameSelection, projection: Projection | None, source: str, frame: FrameSelection.Frame, path: Path
) -> int:
    """Write one frame, northernmost row first, and return the number of missing values, which are NaN.

    Parameters
    ----------
    projection : Projection
        Of the cube.
    source : str
        Name of the cube's file.
    frame : FrameSelection.Frame
        One of the selection; its displacement is added to x, so that x refers to the local plane at the start.
    path : Path
        A new file.

    Raises
    ------
    CubeError
        If rasterio is not installed, or the image is no grid on the ground.
    OSError
        If the file cannot be written.
    """
    grid = selection.grid
    if grid is None or projection is None:
        raise CubeError(
            "geotiff places pixels on a grid on the ground, and a camera's image is none; allowed: envi, fits, png"
        )
    try:
        import rasterio
    except ImportError as error:
        raise CubeError(
            "GeoTIFF needs the package rasterio; install it with: "
            "pip install './plugins/hcss-export[geotiff]' in a checkout of hcss_twin"
        ) from error

    values = selection.values(frame)[:, ::-1]
    west = grid.west_m - 0.5 * grid.step_x_m + frame.displacement_m
    north = grid.south_m + (selection.rows - 0.5) * grid.step_y_m
    # Through memory, because GDAL writes an incomplete file to a full disk and raises nothing.
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff",
            width=selection.columns,
            height=selection.rows,
            count=len(values),
            dtype=values.dtype.newbyteorder("="),
            nodata=float("nan") if values.dtype.kind == "f" else None,
            crs=projection.proj_text,
            transform=rasterio.Affine(grid.step_x_m, 0.0, west, 0.0, -grid.step_y_m, north),
            interleave="band",
        ) as file:
            file.write(values)
            # for readers that do not know the GDAL tags
            document = {
                **description(selection, projection, source),
                "frames": [vars(frame)],
                "row_order": "north first",
            }
            file.update_tags(
                TIFFTAG_IMAGEDESCRIPTION=json_text(document),
                variable=ascii_text(selection.variable),
                long_name=ascii_text(headline(selection)),
                units=ascii_text(selection.units),
                time=frame.time,
                seconds_since_start=repr(frame.seconds),
                centre_displacement_m=repr(frame.displacement_m),
                cube_id=ascii_text(str(selection.attributes.get("id", ""))),
                title=ascii_text(str(selection.attributes.get("title", ""))),
            )
            for number, plane in enumerate(selection.planes, 1):
                file.set_band_description(number, ascii_text(plane.name or selection.variable))
                file.set_band_unit(number, ascii_text(selection.units))
                if plane.central_um is not None:
                    names = ("lower_um", "central_um", "upper_um")
                    file.update_tags(number, **{name: repr(getattr(plane, name)) for name in names})
        path.write_bytes(memory.getbuffer())
    return count_missing(values)
