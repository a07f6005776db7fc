"""Volumes of clouds: the extinction of every cell of an instant of a large-eddy simulation, as NetCDF files.

Any code can read them: ``extinction`` (z, y, x) is in 1/m in the visible, between the altitudes ``z_bounds``; the box
is periodic along y and x. Cloud-free levels below and above the clouds are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.film import CELLS_M, LAYER_M, SIDES
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError, NetcdfFile

FORMAT = 1

LEVELS = 1, 1000
"""Allowed numbers of levels."""

DENSEST_M1 = 1.0
"""Greatest extinction: that of the densest fog is a tenth of it."""

_KEPT_BITS = 10
"""Of the 23 bits of the mantissa: values are exact within 0.05 %, and files a third as large."""


@dataclass(frozen=True)
class Volume:
    """Extinction of clouds in cells.

    Attributes
    ----------
    extinction_m1 : ndarray of float32 (Z, rows, columns)
        In the visible, efficiency 2; periodic, rows northward, columns eastward; 0 where it is clear.
    edges_m : ndarray (Z + 1,)
        Altitudes between the levels, ascending.
    cell_m : float
        Side of a cell.
    kind, source, licence : str
        Kind of clouds, where the volume comes from, and the terms of use.
    recipe : str
        Case with seed, as JSON: what ``hcss skies simulate`` ran.
    time_s : float
        Of that run.
    droplets_cm3 : float
        Number of droplets from which extinction follows.
    frame_m_s : (float, float)
        Speed along x and y with which the clouds moved.
    """

    extinction_m1: NDArray[np.float32]
    edges_m: Array
    cell_m: float
    kind: str
    source: str
    licence: str
    recipe: str
    time_s: float
    droplets_cm3: float
    frame_m_s: tuple[float, float]

    @property
    def optical_thickness(self) -> Array:
        """Of the columns (rows, columns)."""
        thickness: Array = np.tensordot(np.diff(self.edges_m), self.extinction_m1.astype(np.float64), axes=1)
        return thickness

    def described(self) -> str:
        """Return kind, box, cover and heights in words."""
        levels, rows, columns = self.extinction_m1.shape
        box = f"{rows} x {columns} columns of {self.cell_m:g} m, {levels} levels"
        cover = float(np.mean(self.optical_thickness > 0.0))
        layer = f"{self.edges_m[0] / 1e3:.2f} to {self.edges_m[-1] / 1e3:.2f} km"
        return f"{self.kind}: {box}, cover {cover:.2f}, clouds from {layer}, volume"


def volume_of_run(path: Path, start_h: float | None = None, *, kind: str | None = None, licence: str) -> Volume:
    """Return a volume that a run of ``hcss skies simulate --volumes`` kept.

    Parameters
    ----------
    path : Path
        The file of the run.
    start_h : float, optional
        Hours of the run; default: the last volume.
    kind : str, optional
        Kind of clouds; default: the title of the run.
    licence : str
        Terms of use.

    Raises
    ------
    CatalogError
        If the file is no run, has no volume of that time, or no cloud in it.
    """
    from hcss_skies.les.case import Case
    from hcss_skies.les.grid import stretched_faces

    with Reading(path, CatalogError, "not a run of `hcss skies simulate`, or damaged").netcdf() as file:
        if getattr(file, "hcss_skies_simulation", None) != 1:
            raise CatalogError(f"{path}: no run of `hcss skies simulate`")
        if "extinction" not in file.variables:
            raise CatalogError(f"{path}: no volumes; allowed: a run with --volumes")
        file.set_auto_mask(False)
        time = np.asarray(file["volume_time"][:], dtype=np.float64)
        number = time.size - 1 if start_h is None else int(np.argmin(np.abs(time - 3600.0 * start_h)))
        if start_h is not None and not abs(time[number] - 3600.0 * start_h) < 1.0:
            times = ", ".join(f"{at / 3600.0:g}" for at in time)
            raise CatalogError(f"{path}: volume at {start_h:g} h; allowed: {times} h")
        extinction = np.asarray(file["extinction"][number], dtype=np.float32)
        case = Case.model_validate_json(str(file.case))
        source, title = str(file.source), str(file.title)
    grid, cloudy = case.grid, np.flatnonzero(np.any(extinction > 0.0, axis=(1, 2)))
    if cloudy.size == 0:
        raise CatalogError(f"{path}: no cloud at {time[number] / 3600.0:g} h")
    edges = grid.floor_m + stretched_faces(grid.top_m, grid.spacing_m)
    low, high = int(cloudy[0]), int(cloudy[-1]) + 1
    return Volume(
        _rounded(extinction[low:high]), edges[low : high + 1], grid.side_m, kind or title, source, licence,
        case.model_dump_json(), float(time[number]), case.output.droplets_cm3, case.air.frame_m_s,
    )  # fmt: skip


def _rounded(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return values whose last bits are 0, so that they are compressed well; those that are left are rounded."""
    lost = 23 - _KEPT_BITS
    bits = np.ascontiguousarray(values).view(np.uint32) + np.uint32(1 << (lost - 1))
    rounded: NDArray[np.float32] = (bits & np.uint32(0xFFFFFFFF << lost & 0xFFFFFFFF)).view(np.float32)
    return rounded


def write_volume(path: Path, volume: Volume) -> None:
    """Write a volume as NetCDF. Raises CatalogError if it could not be read again."""
    _check(path, volume)
    levels, rows, columns = volume.extinction_m1.shape
    with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
        file.setncatts(
            {
                "Conventions": "CF-1.8", "title": f"Volume of clouds: {volume.kind}",
                "hcss_skies_volume_format": FORMAT, "kind": volume.kind, "source": volume.source,
                "license": volume.licence, "recipe": volume.recipe, "time_s": volume.time_s,
                "droplets_cm3": volume.droplets_cm3, "cell_m": volume.cell_m, "frame_m_s": np.array(volume.frame_m_s),
            }
        )  # fmt: skip
        for name, size in {"z": levels, "y": rows, "x": columns, "side": 2}.items():
            file.createDimension(name, size)
        edges = volume.edges_m
        for name, values, what in (
            ("z", 0.5 * (edges[1:] + edges[:-1]), "altitude of the middles of levels"),
            ("y", volume.cell_m * (np.arange(rows) + 0.5), "distance along y; periodic"),
            ("x", volume.cell_m * (np.arange(columns) + 0.5), "distance along x; periodic"),
        ):
            axis = file.createVariable(name, "f8", (name,), fill_value=False)
            axis[:] = values
            axis.setncatts({"units": "m", "long_name": what})
        file["z"].setncatts({"bounds": "z_bounds", "positive": "up"})
        file.createVariable("z_bounds", "f8", ("z", "side"), fill_value=False)[:] = np.stack([edges[:-1], edges[1:]], 1)
        extinction = file.createVariable(
            "extinction", "f4", ("z", "y", "x"), zlib=True, complevel=9, shuffle=True, fill_value=False
        )
        extinction[:] = volume.extinction_m1
        extinction.setncatts({"units": "m-1", "long_name": "extinction of cloud droplets, visible (0.55 um)"})


def read_volume(path: Path) -> Volume:
    """Read a volume.

    Raises
    ------
    CatalogError
        If the file is damaged, is no volume, or has values out of range.
    """
    with Reading(path, CatalogError, "not a volume of clouds, or damaged").netcdf() as file:
        if getattr(file, "hcss_skies_volume_format", None) != FORMAT:
            raise CatalogError(f"{path}: no volume of clouds; `hcss skies pack --volume` makes one from a simulation")
        file.set_auto_mask(False)
        bounds = np.asarray(file["z_bounds"][:], dtype=np.float64)
        along_x, along_y = (float(speed) for speed in file.frame_m_s)
        volume = Volume(
            np.asarray(file["extinction"][:], dtype=np.float32), np.append(bounds[:, 0], bounds[-1:, 1]),
            float(file.cell_m), str(file.kind), str(file.source), str(file.license), str(file.recipe),
            float(file.time_s), float(file.droplets_cm3), (along_x, along_y),
        )  # fmt: skip
    _check(path, volume)
    return volume


def _check(path: Any, volume: Volume) -> None:
    """Raise CatalogError unless the parts of a volume fit together and are in range."""
    if wrong := _wrong(volume):
        raise CatalogError(f"{path}: {wrong}")


def _wrong(volume: Volume) -> str:
    shape, edges = volume.extinction_m1.shape, volume.edges_m
    if len(shape) != 3:
        return f"extinction of {shape}; allowed: levels, rows and columns"
    for size, name, (low, high) in zip(shape, ("levels", "rows", "columns"), (LEVELS, SIDES, SIDES), strict=True):
        if not low <= size <= high:
            return f"{size} {name}; allowed: {low} to {high}"
    if edges.shape != (shape[0] + 1,) or not np.all(np.diff(edges) > 0.0):
        return f"z_bounds that are not {shape[0]} levels above each other"
    for name, value, (least, most) in (
        ("z_bounds", edges[0], LAYER_M),
        ("z_bounds", edges[-1], LAYER_M),
        ("cell_m", volume.cell_m, CELLS_M),
        ("frame_m_s along x", volume.frame_m_s[0], (-100.0, 100.0)),
        ("frame_m_s along y", volume.frame_m_s[1], (-100.0, 100.0)),
    ):
        if not least <= value <= most:
            return f"{name} {value:g}; allowed: {least:g} to {most:g}"
    if not np.all((volume.extinction_m1 >= 0.0) & (volume.extinction_m1 <= DENSEST_M1)):
        return f"extinction that is missing, or outside 0 to {DENSEST_M1:g} m-1"
    if not np.any(volume.extinction_m1 > 0.0):
        return "no cloud"
    return ""
