"""Fourier series over azimuth, solved mode by mode until the remaining terms are negligible."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.chains import chains


class AzimuthSeries:
    """Layers whose Fourier series need more terms: a series ends after two successive small modes.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.

    Attributes
    ----------
    chains : DoublingChains
        Of the layers that still need a mode.
    """

    def __init__(self, thickness: Array) -> None:
        self._thickness = thickness
        self._going = np.ones(thickness.shape, dtype=np.bool_)
        # Layers whose previous mode was small.
        self._quiet = np.zeros(thickness.size, dtype=np.bool_)
        self.chains = chains(thickness, self._going)

    def end_where(self, small: NDArray[np.bool_]) -> bool:
        """Record for which layers of ``chains`` (n,) this mode was small; return whether all series have ended."""
        cells = self.chains.cell
        ended = small & self._quiet[cells]
        self._quiet[cells] = small
        if np.any(ended):
            self._going.flat[cells[ended]] = False
            self.chains = chains(self._thickness, self._going)
        return bool(np.all(ended))
