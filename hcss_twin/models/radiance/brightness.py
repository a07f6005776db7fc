"""Brightness temperature: invert the band-integrated Planck function."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck

COLDEST_K, HOTTEST_K = 60.0, 3000.0
NODES = 4096


class BrightnessTemperature:
    """Temperature of the black body with a given band radiance, for each band of a grid.

    Tabulated evenly in 1/T and interpolated as 1/T against ln(radiance), which is nearly a straight
    line: within 1e-5 K over 150-350 K.
    """

    def __init__(self, grid: SpectralGrid, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._inverse_temperature = np.linspace(1 / COLDEST_K, 1 / HOTTEST_K, NODES)
        radiance = planck(grid.wavenumber_cm1[None, :], 1 / self._inverse_temperature[:, None]) @ grid.weights_cm1.T
        self._ln_radiance = np.log(np.maximum(radiance, np.finfo(float).tiny)).T

    def __call__(self, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return kelvin for ``radiance`` (B, y, x).

        Raises
        ------
        ProviderError
            If a radiance is that of no black body between 60 and 3000 K.
        """
        result = np.empty_like(radiance)
        for band, table in enumerate(self._ln_radiance):
            values = radiance[band].astype(np.float64)
            if values.min() <= 0 or np.log(values.max()) > table[-1] or np.log(values.min()) < table[0]:
                raise ProviderError(
                    f"band '{self._names[band]}': radiance {values.min():g} to {values.max():g} W m-2 sr-1 has no "
                    f"brightness temperature between {COLDEST_K:g} and {HOTTEST_K:g} K"
                )
            result[band] = 1.0 / np.interp(np.log(values), table, self._inverse_temperature)
        return result

    @property
    def highest_radiance(self) -> Array:
        """Radiance of each band that is hotter than all known temperatures, (B,)."""
        return np.exp(self._ln_radiance[:, -1])

    def where_known(self, radiance: Array) -> Array:
        """Return kelvin for ``radiance`` (B, N), NaN where it is that of no black body between 60 and 3000 K."""
        result = np.full(radiance.shape, np.nan)
        for values, kelvin, table in zip(radiance, result, self._ln_radiance, strict=True):
            known = (values >= np.exp(table[0])) & (values <= np.exp(table[-1]))
            kelvin[known] = 1.0 / np.interp(np.log(values[known]), table, self._inverse_temperature)
        return result
