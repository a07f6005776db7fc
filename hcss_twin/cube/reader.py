"""Opening of finished cubes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from hcss_twin.cube.bit_rounding import INFO
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING
from hcss_twin.cube.formats import is_zarr
from hcss_twin.cube.geometry_variables import GEOMETRY
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE
from hcss_twin.cube.variables import LAYER
from hcss_twin.cube.zarr_writer import require_zarr
from hcss_twin.errors import CubeError

if TYPE_CHECKING:
    import xarray as xr

_SIGNATURES = (b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02", b"CDF\x05")
"""First bytes of NetCDF-4 and of the older formats."""


def open_cube(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open a finished cube; values are read from the file when they are used.

    Bands and cloud layers can be selected by name: ``open_cube(path).radiance.sel(band="mwir")``. Close the dataset
    after use, or use it in a ``with`` block.

    Raises
    ------
    CubeError
        If the file is missing, is neither NetCDF nor a Zarr store, is not a cube, or was not finished.
    """
    # imported here because commands that read no cube should not wait for it
    import xarray as xr

    if is_zarr(path) and os.path.isdir(path):
        require_zarr(path)
        options: dict[str, Any] = {"engine": "zarr", "chunks": None}
    elif os.path.isfile(path):
        options = {"engine": "netcdf4"}
    else:
        raise CubeError(f"cannot read {os.fspath(path)}: there is no such file")
    try:
        # xarray would keep a cached file open, and reuse it, if it had been replaced under the same name
        dataset = xr.open_dataset(path, decode_coords="all", cache=False, **options)
    except (OSError, ValueError, RuntimeError, KeyError) as error:
        raise CubeError(f"cannot read {os.fspath(path)}: {_why_not(path, error)}") from error
    found = dataset.attrs.get(FORMAT_ATTRIBUTE)
    if found != FORMAT_VERSION:
        dataset.close()
        told = "it is no finished cube" if found is None else f"it has the cube format {found}"
        raise CubeError(
            f"cannot read {os.fspath(path)}: {told}; "
            f"the global attribute {FORMAT_ATTRIBUTE} = {FORMAT_VERSION} is needed"
        )
    described = [*(spec.name for spec in (*COORDINATES, *GEOMETRY)), GRID_MAPPING, INFO]
    named = dataset.set_coords([name for name in described if name in dataset])
    names = {dim: f"{dim}_name" for dim in ("band", LAYER) if f"{dim}_name" in dataset}
    named = named.assign_coords(
        {dim: (dim, dataset[name].to_numpy().astype(str)) for dim, name in names.items()}
    )
    # a dataset made from another one does not close its file
    named.set_close(dataset.close)
    return named


def _why_not(path: str | os.PathLike[str], error: Exception) -> str:
    """Say why a file could not be opened: for most it is that they are no NetCDF at all."""
    try:
        with open(path, "rb") as file:
            start = file.read(max(map(len, _SIGNATURES)))
    except OSError:
        return str(error)
    if start.startswith(_SIGNATURES):
        return f"it is NetCDF, but damaged, cut off or of another kind ({error})"
    if not start:
        return "it is empty; a cube is needed, as `hcss run` writes it"
    if os.path.splitext(path)[1].lower() in (".toml", ".json"):
        return f"it is no NetCDF file; if it is a scenario, `hcss run {os.fspath(path)}` makes a cube of it"
    return "it is no NetCDF file; a cube is needed, as `hcss run` writes it"


def scenario_text(path: str | os.PathLike[str]) -> str:
    """Return the scenario a cube was made from, as it was given.

    Raises
    ------
    CubeError
        If the file is no finished cube or carries no scenario.
    """
    with open_cube(path) as dataset:
        text = dataset.attrs.get(SCENARIO_ATTRIBUTE)
    if not isinstance(text, str):
        raise CubeError(f"{os.fspath(path)} carries no scenario (global attribute {SCENARIO_ATTRIBUTE})")
    return text
