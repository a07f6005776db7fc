"""Brightness temperature of band radiance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.kernels import kernel
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck

__all__ = ["BrightnessTemperature"]

COLDEST_K, HOTTEST_K = 60.0, 3000.0
_TEMPERATURES = 4096

_SHIFT = 14
"""Bits of the mantissa within an interval of the table by radiance: 512 intervals from each power of 2 to the next."""

_ROUNDED = 1.0 + 2.0**-23
"""Radiance as near to the ends of the table as this is left to logarithms."""

_SMALLEST = float(np.finfo(np.float32).tiny)
"""Smallest radiance of the table by bits; smaller numbers have fewer bits."""


class BrightnessTemperature:
    """Converts band radiance, W m-2 sr-1, to brightness temperature, K, for each band of a grid.

    The intervals of the table are even in the bits of the radiance, so that finding one needs no logarithm and no
    search. Errors are up to 2.5 steps of single precision: 5e-5 K up to 350 K, 5e-4 K at 3000 K.
    """

    def __init__(self, grid: SpectralGrid, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._inverse_temperature = 1.0 / np.geomspace(COLDEST_K, HOTTEST_K, _TEMPERATURES)
        radiance = planck(grid.wavenumber_cm1[None, :], 1 / self._inverse_temperature[:, None]) @ grid.weights_cm1.T
        self._ln_radiance = np.log(np.maximum(radiance, np.finfo(float).tiny)).T
        self._by_bits = [self._table_by_bits(ln_radiance) for ln_radiance in self._ln_radiance]

    def __call__(self, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return kelvin for ``radiance`` (B, ...).

        Raises
        ------
        ProviderError
            If no black body between 60 and 3000 K has that radiance.
        """
        result = np.empty(radiance.shape, radiance.dtype)
        for band, (given, kelvin) in enumerate(zip(radiance, result, strict=True)):
            values = np.ascontiguousarray(given, dtype=np.float32)
            if not _look_up(values.view(np.int32).ravel(), *self._by_bits[band], kelvin.reshape(-1)):
                kelvin[:] = self._from_logarithm(band, values.astype(np.float64))
        return result

    def _from_logarithm(self, band: int, values: Array) -> Array:
        """Return kelvin where some radiances are too small for the table by bits, or have no temperature."""
        table = self._ln_radiance[band]
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(values)
        if not np.all((logarithm >= table[0]) & (logarithm <= table[-1])):  # also NaN
            raise ProviderError(
                f"band '{self._names[band]}': radiance {values.min():g} to {values.max():g} W m-2 sr-1 has no "
                f"brightness temperature between {COLDEST_K:g} and {HOTTEST_K:g} K"
            )
        result: Array = 1.0 / np.interp(logarithm, table, self._inverse_temperature)
        return result

    def _table_by_bits(self, ln_radiance: Array) -> tuple[NDArray[np.float32], int, int]:
        """Return temperatures at radiances even in their bits, and the bits of the lowest and highest radiance."""
        ends = np.maximum(np.exp(ln_radiance[[0, -1]]), _SMALLEST)
        inside = np.array([ends[0] * _ROUNDED, ends[1] / _ROUNDED], np.float32)
        lowest, highest = (int(bits) for bits in inside.view(np.int32))
        nodes = np.arange(lowest >> _SHIFT, (highest >> _SHIFT) + 2, dtype=np.int64) << _SHIFT
        logarithm = np.log(nodes.astype(np.int32).view(np.float32).astype(np.float64))
        inverse = np.interp(logarithm, ln_radiance, self._inverse_temperature)
        for end, neighbour in ((0, 1), (-1, -2)):  # half an interval may be beyond the ends
            slope = np.diff(self._inverse_temperature[[end, neighbour]]) / np.diff(ln_radiance[[end, neighbour]])
            beyond = (logarithm - ln_radiance[end]) * (1 if end else -1) > 0.0
            inverse[beyond] += slope * (logarithm[beyond] - ln_radiance[end])
        return (1.0 / inverse).astype(np.float32), lowest, highest

    @property
    def highest_radiance(self) -> Array:
        """Band radiance (B,) of the hottest tabulated black body."""
        return np.exp(self._ln_radiance[:, -1])

    def where_known(self, radiance: Array) -> Array:
        """Return kelvin for ``radiance`` (B, N), NaN where no black body between 60 and 3000 K has that radiance."""
        result = np.full(radiance.shape, np.nan)
        for values, kelvin, table in zip(radiance, result, self._ln_radiance, strict=True):
            known = (values >= np.exp(table[0])) & (values <= np.exp(table[-1]))
            kelvin[known] = 1.0 / np.interp(np.log(values[known]), table, self._inverse_temperature)
        return result


@kernel()
def _look_up(bits, table, lowest, highest, kelvin):  # type: ignore[no-untyped-def]
    """Write the temperatures of bits (N,) of radiance; False if one is outside the table.

    Bits of positive numbers ascend with them; those of NaN are higher, those of negative numbers negative.
    """
    first, mask, share = lowest >> _SHIFT << _SHIFT, (1 << _SHIFT) - 1, np.float32(2.0**-_SHIFT)
    for x in range(bits.size):
        if not lowest <= bits[x] <= highest:
            return False
        offset = bits[x] - first
        index = np.uint32(offset >> _SHIFT)
        low = table[index]
        kelvin[x] = low + np.float32(offset & mask) * share * (table[index + np.uint32(1)] - low)
    return True
