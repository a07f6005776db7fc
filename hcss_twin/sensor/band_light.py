"""How light is spread over a band: its black-body radiance, and how many photons a joule is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.constants import PLANCK_J_S, SPEED_OF_LIGHT_M_S
from hcss_twin.physics.gauss_legendre import gauss_legendre
from hcss_twin.physics.planck import SECOND_RADIATION, planck, wavenumber_from_um
from hcss_twin.providers import SensorBand

Array = NDArray[np.float64]

_NODES = 24
"""Per stretch between two wavelengths of the response; a band of 8 to 14 um in one stretch is exact to 1e-12."""


def band_radiance(band: SensorBand, temperature_K: float) -> float:
    """Radiance of a black body within a band, W m-2 sr-1."""
    wavelength_um, weight = _nodes(band)
    return float(weight @ _per_um(wavelength_um, temperature_K))


def band_radiance_per_kelvin(band: SensorBand, temperature_K: float) -> float:
    """Derivative of :func:`band_radiance` by temperature, W m-2 sr-1 K-1.

    That of Planck's function is B x / (T (1 - exp(-x))) with x = h c / (lambda k T).
    """
    wavelength_um, weight = _nodes(band)
    x = SECOND_RADIATION * wavenumber_from_um(wavelength_um) / temperature_K
    slope = _per_um(wavelength_um, temperature_K) * x / (-np.expm1(-x) * temperature_K)
    return float(weight @ slope)


def photon_wavelength_um(band: SensorBand, temperature_K: float | None) -> float:
    """Wavelength of the mean photon energy: photons per second are watts times it over h c.

    The mean of wavelength over the light in the band. The spectrum within a band is that of a black body, or, without
    a temperature, the same at all of its wavelengths; a cube has no more of it than its integral.
    """
    wavelength_um, weight = _nodes(band)
    light = weight if temperature_K is None else weight * _per_um(wavelength_um, temperature_K)
    return float(light @ wavelength_um / light.sum())


def photons_per_joule(wavelength_um: float) -> float:
    """Photons of one wavelength in a joule, lambda / (h c)."""
    return wavelength_um * 1e-6 / (PLANCK_J_S * SPEED_OF_LIGHT_M_S)


def _nodes(band: SensorBand) -> tuple[Array, Array]:
    """Wavelengths (N,) and weights (N,) in um that hold the response, for integrals over the band."""
    abscissa, weight = gauss_legendre(_NODES)
    low, step = band.wavelength_um[:-1, None], np.diff(band.wavelength_um)[:, None]
    wavelength_um = (low + 0.5 * step * (abscissa + 1.0)).ravel()
    response = np.interp(wavelength_um, band.wavelength_um, band.response)
    return wavelength_um, (0.5 * step * weight).ravel() * response


def _per_um(wavelength_um: Array, temperature_K: float) -> Array:
    """Planck's function in W m-2 sr-1 um-1."""
    wavenumber_cm1 = wavenumber_from_um(wavelength_um)
    result: Array = planck(wavenumber_cm1, temperature_K) * wavenumber_cm1 / wavelength_um
    return result
