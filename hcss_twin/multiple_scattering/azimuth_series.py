"""Azimuth series of layers, each of which ends where the rest is negligible."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.chains import chains

Array = NDArray[np.float64]


class AzimuthSeries:
    """Layers whose series have not ended: one does where two modes in succession are small.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.

    Attributes
    ----------
    chains : Chains
        Of the layers that still need a mode.
    """

    def __init__(self, thickness: Array) -> None:
        self._thickness = thickness
        self._going = np.ones(thickness.shape, dtype=np.bool_)
        # Whose mode before was small.
        self._quiet = np.zeros(thickness.size, dtype=np.bool_)
        self.chains = chains(thickness, self._going)

    def end_where(self, small: NDArray[np.bool_]) -> bool:
        """Say of which layers of ``chains`` (n,) a mode was small, and return whether all series have ended."""
        cells = self.chains.cell
        ended = small & self._quiet[cells]
        self._quiet[cells] = small
        if np.any(ended):
            self._going.flat[cells[ended]] = False
            self.chains = chains(self._thickness, self._going)
        return bool(np.all(ended))
