"""Opening of finished cubes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hcss_twin.cube.bit_rounding import INFO
from hcss_twin.cube.coordinates import COORDINATES, GRID_MAPPING
from hcss_twin.cube.geometry_variables import GEOMETRY
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, FORMAT_VERSION, SCENARIO_ATTRIBUTE
from hcss_twin.cube.variables import LAYER
from hcss_twin.errors import CubeError

if TYPE_CHECKING:
    import xarray as xr


def open_cube(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open a finished cube; values are read from the file when they are used.

    Bands and cloud layers can be selected by name: ``open_cube(path).radiance.sel(band="mwir")``. Close the dataset
    after use, or use it in a ``with`` block.

    Raises
    ------
    CubeError
        If the file is missing, is not NetCDF, is not a cube, or was not finished.
    """
    # imported here because commands that read no cube should not wait for it
    import xarray as xr

    if not os.path.isfile(path):
        raise CubeError(f"cannot read {os.fspath(path)}: there is no such file")
    try:
        # xarray would keep a cached file open, and reuse it, if it had been replaced under the same name
        dataset = xr.open_dataset(path, engine="netcdf4", decode_coords="all", cache=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise CubeError(f"cannot read {os.fspath(path)}: {error}") from error
    found = dataset.attrs.get(FORMAT_ATTRIBUTE)
    if found != FORMAT_VERSION:
        dataset.close()
        told = "it is no finished cube" if found is None else f"it has the cube format {found}"
        raise CubeError(
            f"cannot read {os.fspath(path)}: {told}; "
            f"the global attribute {FORMAT_ATTRIBUTE} = {FORMAT_VERSION} is needed"
        )
    described = [*(spec.name for spec in (*COORDINATES, *GEOMETRY)), GRID_MAPPING, INFO]
    dataset = dataset.set_coords([name for name in described if name in dataset])
    names = {dim: f"{dim}_name" for dim in ("band", LAYER) if f"{dim}_name" in dataset}
    return dataset.assign_coords(
        {dim: (dim, dataset[name].to_numpy().astype(str)) for dim, name in names.items()}
    )


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
