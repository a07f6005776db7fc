"""From absorber amounts to optical depth: double exponential functions, continua and aerosol in one matrix product."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.band_model.aerosol_tables import boundary_optics, wavelength_weights
from hcss_twin.atmosphere.band_model.coefficients import BandModelCoefficients

Array = NDArray[np.float64]


class Absorption:
    """Optical depth at the native wavenumbers.

    Parameters
    ----------
    coefficients : BandModelCoefficients
    aerosol : str
        Boundary-layer model, or ``none``.
    """

    def __init__(self, coefficients: BandModelCoefficients, aerosol: str) -> None:
        self._tables = coefficients.aerosol
        self._aerosol = aerosol
        self._exponent = coefficients.exponent
        self._gas_columns: int = coefficients.absorption.shape[0]
        self._matrix = coefficients.absorption
        if aerosol != "none":
            weights = wavelength_weights(self._tables, coefficients.wavenumber_cm1)
            upper = self._tables.upper["extinction"] @ weights
            self._matrix = np.concatenate((self._matrix, upper, weights))
        self._window = lru_cache(maxsize=4)(self._make_window)

    @property
    def aerosol_column(self) -> int:
        """First of the aerosol columns of the amounts: four regions of height, then the humidity's weight."""
        return self._gas_columns

    def humidity_percent(self, amount: Array) -> Array:
        """Aerosol-weighted mean relative humidity (P,) of the lowest 2 km along paths with amounts (P, K)."""
        haze, weighted = amount[:, self._gas_columns], amount[:, -1]
        crossed = haze > 0.0
        result: Array = np.where(crossed, 100.0 - np.exp(weighted / np.where(crossed, haze, 1.0)), 0.0)
        return result

    def factors(self, amount: Array, humidity_percent: Array) -> Array:
        """Factors of the paths (P, F): amounts to the power of the bands, continua, aerosol."""
        channels = self._exponent.size
        parts = [amount[:, :channels] ** self._exponent, amount[:, channels : self._gas_columns]]
        if self._aerosol != "none":
            boundary = boundary_optics(self._tables, self._aerosol, "extinction", humidity_percent)
            first = self._gas_columns
            parts += [amount[:, first + 1 : first + 4], amount[:, first : first + 1] * boundary]
        return np.concatenate(parts, axis=1)

    def transmittance(self, factors: Array, nodes: NDArray[np.intp]) -> Array:
        """Transmittance (P, N) at native wavenumbers, given by their indices."""
        used, matrix = self._window(nodes.tobytes())
        depth = factors[:, used] @ matrix
        result: Array = np.exp(np.negative(depth, out=depth), out=depth)
        return result

    def _make_window(self, nodes: bytes) -> tuple[NDArray[np.intp], Array]:
        """Channels that absorb at some wavenumbers, and their coefficients: most absorb in a few bands only."""
        matrix = self._matrix[:, np.frombuffer(nodes, dtype=np.intp)]
        used = np.flatnonzero(matrix.any(axis=1))
        return used, matrix[used]
