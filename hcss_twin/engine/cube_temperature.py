"""Brightness temperature of the radiance in a cube, clean or measured, of any time and place."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError
from hcss_twin.core.reading import MAX_VALUES, Reading
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.variables import VARIABLES
from hcss_twin.cube.writer import variable_attributes
from hcss_twin.engine.cube_sensor import bands_of
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralGrid

if TYPE_CHECKING:
    import xarray as xr

RESPONSE_STEP_CM1 = 1.0
"""Wavenumbers at which Planck's function is integrated over a response: changes a temperature by less than 1e-4 K."""


@checked
@Reading.argument(CubeError)
def brightness_temperature(cube: str | os.PathLike[str] | xr.Dataset, base: Path | None = None) -> xr.DataArray:
    """Return the temperature of black bodies with the radiance of a cube, to compare measurements in kelvin.

    Parameters
    ----------
    cube : path or Dataset
        A finished cube or the result of ``simulate`` or ``sense``.
    base : Path, optional
        Base folder of band files; default: that of the scenario, if its files still exist.

    Returns
    -------
    DataArray (time, band, y, x)
        K; NaN where no black body between 60 and 3000 K has the radiance, as with negative noise.

    Raises
    ------
    CubeError
        If the cube has no radiance or too much for memory, or its scenario does not match it.
    CatalogError
        If a band response file is missing.
    """
    if isinstance(cube, str | os.PathLike):
        with open_cube(cube) as opened:
            return brightness_temperature(opened, base).load()
    name = os.path.basename(str(cube.encoding.get("source", "the dataset")))
    if "radiance" not in cube:
        raise CubeError(f"{name} has no radiance; request it in the scenario")
    radiance, most = cube["radiance"], MAX_VALUES // 2
    if radiance.size > most:
        raise CubeError(f"{name}: {radiance.size} values of radiance; allowed: {most}; select a part")
    bands = bands_of(cube, name, base)
    ends = [1e4 / band.upper_um for band in bands], [1e4 / band.lower_um for band in bands]
    native = np.arange(np.floor(min(ends[0])), np.ceil(max(ends[1])) + RESPONSE_STEP_CM1, RESPONSE_STEP_CM1)
    temperature = BrightnessTemperature(SpectralGrid.dense(bands, native), [band.name for band in bands])
    axis = radiance.get_axis_num("band")
    values = np.moveaxis(np.asarray(radiance, dtype=np.float64), axis, 0)
    kelvin = temperature.where_known(values.reshape(len(bands), -1)).reshape(values.shape).astype(np.float32)
    result = radiance.copy(data=np.moveaxis(kelvin, 0, axis)).rename("brightness_temperature")
    result.attrs = variable_attributes(
        next(variable for variable in VARIABLES if variable.name == "brightness_temperature")
    )
    return result
