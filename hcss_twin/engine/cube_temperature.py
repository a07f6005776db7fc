"""Brightness temperature of the radiance in a cube, clean or measured, of any time and place."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError
from hcss_twin.core.reading import MAX_VALUES, Reading
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.variables import VARIABLES
from hcss_twin.cube.writer import variable_attributes
from hcss_twin.engine.cube_sensor import bands_of
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid

if TYPE_CHECKING:
    import xarray as xr

RESPONSE_STEP_CM1 = 1.0
"""Wavenumbers at which Planck's function is integrated over a response: changes a temperature by less than 1e-4 K."""

ToKelvin: TypeAlias = Callable[[NDArray[Any]], NDArray[np.float32]]


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
    radiance, most = _radiance(cube), MAX_VALUES // 2
    if radiance.size > most:
        raise CubeError(f"{_name(cube)}: {radiance.size} values of radiance; allowed: {most}; select a part")
    convert = kelvin_by_band(cube, base)
    axis = radiance.get_axis_num("band")
    values = np.moveaxis(np.asarray(radiance), axis, 0)
    kelvin = np.stack([to_kelvin(plane) for to_kelvin, plane in zip(convert, values, strict=True)])
    result = radiance.copy(data=np.moveaxis(kelvin, 0, axis)).rename("brightness_temperature")
    result.attrs = variable_attributes(
        next(variable for variable in VARIABLES if variable.name == "brightness_temperature")
    )
    return result


def kelvin_by_band(cube: xr.Dataset, base: Path | None = None) -> tuple[ToKelvin, ...]:
    """Return for each band of an open cube what turns its radiance, of any shape, into kelvin (float32).

    For pictures, which read few planes of large cubes; errors as of :func:`brightness_temperature`.
    """
    _radiance(cube)
    return tuple(_to_kelvin(band) for band in bands_of(cube, _name(cube), base))


def _to_kelvin(band: SpectralBand) -> ToKelvin:
    low, high = np.floor(1e4 / band.upper_um), np.ceil(1e4 / band.lower_um)
    grid = SpectralGrid.dense([band], np.arange(low, high + RESPONSE_STEP_CM1, RESPONSE_STEP_CM1))
    temperature = BrightnessTemperature(grid, [band.name])

    def to_kelvin(radiance: NDArray[Any]) -> NDArray[np.float32]:
        known = temperature.where_known(np.asarray(radiance, dtype=np.float64).reshape(1, -1))
        return known.reshape(np.shape(radiance)).astype(np.float32)

    return to_kelvin


def _radiance(cube: xr.Dataset) -> xr.DataArray:
    if "radiance" not in cube:
        raise CubeError(f"{_name(cube)} has no radiance; request it in the scenario")
    return cube["radiance"]


def _name(cube: xr.Dataset) -> str:
    return os.path.basename(str(cube.encoding.get("source", "the dataset")))
