"""Opening of the dataset of a sweep."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hcss_twin.cube.coordinates import COORDINATES
from hcss_twin.cube.variables import LAYER
from hcss_twin.errors import CubeError

if TYPE_CHECKING:
    import xarray as xr

MARK = "hcss_sweep"
"""Global attribute of a dataset, with the hash of the sweep."""


def open_sweep(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the dataset of a sweep; values are read from the file when they are used.

    Swept keys, bands and cloud layers are selected by value or name:
    ``open_sweep(path).radiance.sel(view_zenith=30, band="mwir")``. Close the dataset after use.

    Raises
    ------
    CubeError
        If the file is missing or is no dataset of a sweep.
    """
    import xarray as xr

    if not os.path.isfile(path):
        raise CubeError(f"cannot read {os.fspath(path)}: there is no such file")
    try:
        dataset = xr.open_dataset(path, engine="netcdf4", decode_coords="all", cache=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise CubeError(f"cannot read {os.fspath(path)}: {error}") from error
    if MARK not in dataset.attrs:
        dataset.close()
        raise CubeError(f"cannot read {os.fspath(path)}: it is no dataset of a sweep; open_cube reads cubes")
    described = [spec.name for spec in COORDINATES if spec.name in dataset]
    of_points = [str(name) for name in dataset.variables if str(name).startswith("point_")]
    named = dataset.set_coords([*described, *of_points])
    names = {
        dim: f"{dim}_name"
        for dim in ("band", LAYER)
        if f"{dim}_name" in dataset and dataset[f"{dim}_name"].dims == (dim,)
    }
    named = named.assign_coords(
        {dim: (dim, dataset[name].to_numpy().astype(str)) for dim, name in names.items()}
    )
    # a dataset made from another one does not close its file
    named.set_close(dataset.close)
    return named
