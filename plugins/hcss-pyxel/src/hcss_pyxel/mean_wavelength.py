"""Mean photon wavelengths of a scene in its bands, which convert band radiance to photons.

Photons of a band are the integral of ``lambda L / (h c)``; with the mean wavelength ``integral(lambda L) /
integral(L)`` they are ``mean L_band / (h c)`` exactly.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from hcss_twin import ColumnSpectra, column_spectra
from hcss_twin.providers import Array, wavenumber_from_um


@dataclass(frozen=True)
class MeanWavelength:
    """Mean wavelength of individual columns of a scene in one band: clear sky first, then cloud.

    Attributes
    ----------
    band : str
    radiance : ndarray (N,)
        W m-2 sr-1.
    wavelength_um : ndarray (N,)
    """

    band: str
    radiance: Array
    wavelength_um: Array

    def of_image(self, radiance: Array) -> float:
        """Return the mean wavelength of a whole image, which gives the correct total number of photons.

        Parameters
        ----------
        radiance : ndarray
            Pixels of the band. Each has the wavelength of columns of the same radiance, in straight lines between
            them and that of the darkest and the brightest beyond them.
        """
        order = np.argsort(self.radiance)
        wavelength_um = np.interp(radiance, self.radiance[order], self.wavelength_um[order])
        total = float(np.sum(radiance, dtype=np.float64))
        return float(np.sum(wavelength_um * radiance)) / total if total > 0.0 else float(np.mean(wavelength_um))


def mean_wavelengths(columns: ColumnSpectra) -> tuple[MeanWavelength, ...]:
    """Return the mean wavelengths of columns in each band; of a dark column, that of a constant spectrum."""
    wavelength_um = wavenumber_from_um(columns.wavenumber_cm1)
    energy = columns.radiance @ columns.weights_cm1.T
    weighted = (columns.radiance * wavelength_um) @ columns.weights_cm1.T
    flat = (columns.weights_cm1 @ wavelength_um) / columns.weights_cm1.sum(axis=1)
    mean = np.divide(weighted, energy, out=np.broadcast_to(flat, energy.shape).copy(), where=energy > 0.0)
    return tuple(MeanWavelength(name, energy[:, index], mean[:, index]) for index, name in enumerate(columns.bands))


def mean_wavelengths_of(cube: str | os.PathLike[str]) -> tuple[MeanWavelength, ...]:
    """Return mean wavelengths of the scene of a cube, at the scenario's start.

    Raises
    ------
    CubeError
        If the file is no finished cube or carries no scenario.
    HcssError
        If the scenario cannot be planned here: a file or a provider is missing.
    """
    return mean_wavelengths(column_spectra(cube))
