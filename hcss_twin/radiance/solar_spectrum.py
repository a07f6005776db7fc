"""Extraterrestrial solar irradiance from the catalog."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog

Array = NDArray[np.float64]


class SolarSpectrum:
    """Spectral irradiance at 1 au, ASTM E490-00a by default.

    Interpolated log-log between tabulated wavelengths, which follows the steep tail beyond 10 um.
    """

    def __init__(self, catalog: Catalog, name: str = "astm-e490") -> None:
        columns = catalog.columns(catalog.find(name, "solar", ".csv"))
        self._ln_wavelength = np.log(columns["wavelength_um"])
        self._ln_irradiance = np.log(columns["irradiance_W_m2_um"])

    def __call__(self, wavenumber_cm1: Array) -> Array:
        """Return W m-2 (cm-1)-1.

        Raises
        ------
        ValueError
            If a wavenumber lies outside the spectrum.
        """
        ln_wavelength = np.log(1e4 / wavenumber_cm1)
        low, high = self._ln_wavelength[0], self._ln_wavelength[-1]
        if np.any(ln_wavelength < low) or np.any(ln_wavelength > high):
            raise ValueError(
                f"solar spectrum: wavenumbers {wavenumber_cm1.min():.6g} to {wavenumber_cm1.max():.6g} cm-1; allowed "
                f"{1e4 / np.exp(high):.6g} to {1e4 / np.exp(low):.6g} cm-1"
            )
        per_um = np.exp(np.interp(ln_wavelength, self._ln_wavelength, self._ln_irradiance))
        # E per cm-1 = E per um x |d lambda / d nu| with lambda in um and nu in cm-1.
        result: Array = per_um * 1e4 / wavenumber_cm1**2
        return result
