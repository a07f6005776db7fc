"""Brightness temperature of a cube's radiance, by the spectral response of its own bands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter, ValidationError

from hcss_twin.catalog import Catalog
from hcss_twin.comparison.footage import Array
from hcss_twin.errors import CubeError
from hcss_twin.radiance.spectral_grid import dense_grid
from hcss_twin.scenario.band_entries import Bands
from hcss_twin.scenario.bands import spectral_band
from hcss_twin.scene.brightness import BrightnessTemperature
from hcss_twin.scene.verification.recorded import Recorded

if TYPE_CHECKING:
    import xarray as xr


def kelvin_of_band(dataset: xr.Dataset, path: Path, band: str) -> Callable[[Array], Array]:
    """Return what turns radiance of a band (rows, columns) into kelvin; NaN where no black body has it.

    Raises
    ------
    CubeError
        If the cube carries no scenario with this band.
    CatalogError
        If a file of the band's response is missing.
    """
    recorded = Recorded.of(dict(dataset.attrs), str(path))
    known = recorded.bases()
    catalog = Catalog(base=known[0] if len(known) == 1 else Path.cwd())
    try:
        entries = TypeAdapter(Bands).validate_python(recorded.scenario["bands"])
    except (KeyError, ValidationError) as error:
        raise CubeError(f"{path}: its scenario has no bands that can be read") from error
    found = [each for each in (spectral_band(entry, catalog) for entry in entries) if each.name == band]
    if not found:
        raise CubeError(f"{path}: its scenario has no band '{band}'")
    temperature = BrightnessTemperature(dense_grid(found, None), [band])

    def kelvin(radiance: Array) -> Array:
        return temperature.where_known(radiance.reshape(1, -1)).reshape(radiance.shape)

    return kelvin
