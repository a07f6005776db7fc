"""Optical properties of the particles of layers, computed once for the solvers of all suns and views."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.array_memory import cached_method
from hcss_twin.core.arrays import Array
from hcss_twin.providers import Microphysics, Optics, SingleScattering

MOST_SPECTRA = 2
"""Spectra in memory, of some MB each: those of the solved wavenumbers and of the grid."""

MOST_CURVES = 16
"""Curves in memory, of some kB each."""

LEAST_SHARE = 1e-6
"""Shares below this count as equal: their logarithms would not be."""


class LayerOptics:
    """Optics of one provider.

    Parameters
    ----------
    optics : Optics
    """

    def __init__(self, optics: Optics) -> None:
        self._optics = optics
        self._spectra = cached_method(self._new_spectrum, MOST_SPECTRA)
        self._curves = cached_method(self._new_curves, MOST_CURVES)

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at wavenumbers (V,)."""
        return self._spectra(cloud, wavenumber_cm1.tobytes())

    def curves(self, cloud: Microphysics, wavenumber_cm1: Array) -> Array:
        """Return what operators of a layer are smooth functions of, (4, V).

        These are the logarithms of extinction, albedo and 1 - s, and the similarity parameter s: with it, reflection of
        thick clouds falls from 1 to 0.
        """
        return self._curves(cloud, wavenumber_cm1.tobytes())

    def _new_spectrum(self, cloud: Microphysics, wavenumber_cm1: bytes) -> SingleScattering:
        return self._optics.single_scattering(cloud, np.frombuffer(wavenumber_cm1, dtype=np.float64))

    def _new_curves(self, cloud: Microphysics, wavenumber_cm1: bytes) -> Array:
        own = self._new_spectrum(cloud, wavenumber_cm1)
        similarity = np.sqrt((1.0 - own.albedo) / (1.0 - own.albedo * own.moments[1]))
        shares = np.stack((own.extinction_m1, own.albedo, 1.0 - similarity))
        result: Array = np.concatenate((np.log(np.maximum(shares, LEAST_SHARE)), similarity[None]))
        return result
