"""Brightness temperature of the radiance in a cube, clean or measured, of any time and place."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydantic import TypeAdapter, ValidationError

from hcss_twin.core.arguments import checked
from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CubeError
from hcss_twin.core.reading import MAX_VALUES, Reading
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.variables import VARIABLES
from hcss_twin.cube.writer import variable_attributes
from hcss_twin.engine.cube_sensor import bands_of
from hcss_twin.engine.provenance import Recorded
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.scenario.bands import Bands, spectral_band

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["kelvin_of_band"]

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


def kelvin_of_band(dataset: xr.Dataset, path: Path, band: str) -> Callable[[Array], Array]:
    """Return the conversion of band radiance (rows, columns) to brightness temperature (K), NaN where none exists.

    Raises
    ------
    CubeError
        If the cube's scenario is missing or lacks this band.
    CatalogError
        If the file of the band's spectral response is missing.
    """
    recorded = Recorded.of(dict(dataset.attrs), str(path))
    catalog = Catalog(base=recorded.base)
    try:
        entries = TypeAdapter(Bands).validate_python(recorded.scenario["bands"])
    except (KeyError, ValidationError) as error:
        raise CubeError(f"{path}: its scenario has no bands that can be read") from error
    bands = [candidate for candidate in (spectral_band(entry, catalog) for entry in entries) if candidate.name == band]
    if not bands:
        raise CubeError(f"{path}: its scenario has no band '{band}'")
    temperature = BrightnessTemperature(SpectralGrid.dense(bands, None), [band])

    def kelvin(radiance: Array) -> Array:
        return temperature.where_known(radiance.reshape(1, -1)).reshape(radiance.shape)

    return kelvin
