"""Detector of one band: in-band Planck radiance and photons, saturation and quantisation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import PLANCK_J_S, SECOND_RADIATION, SPEED_OF_LIGHT_M_S, planck, wavenumber_from_um
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import SensorBand

_NODES = 24
"""Per interval of the response table; the integral over one interval from 8 to 14 um is exact to 1e-12."""


def band_radiance_per_kelvin(band: SensorBand, temperature_K: float) -> float:
    """Return the temperature derivative of the black-body band radiance, W m-2 sr-1 K-1.

    The derivative of the Planck function is B x / (T (1 - exp(-x))) with x = h c / (lambda k T).
    """
    wavelength_um, weight = _nodes(band)
    x = SECOND_RADIATION * wavenumber_from_um(wavelength_um) / temperature_K
    slope = _planck_per_um(wavelength_um, temperature_K) * x / (-np.expm1(-x) * temperature_K)
    return float(weight @ slope)


def band_radiance(band: SensorBand, temperature_K: float) -> float:
    """Return the band radiance of a black body, W m-2 sr-1."""
    wavelength_um, weight = _nodes(band)
    return float(weight @ _planck_per_um(wavelength_um, temperature_K))


def black_body_K(band: SensorBand, radiance: float) -> float:
    """Return the temperature of the black body with a band radiance, within the limits 20 and 20000 K."""
    from scipy.optimize import brentq  # only for sensors with a range

    return float(brentq(lambda kelvin: np.log(max(band_radiance(band, kelvin), 1e-300) / radiance), 20.0, 2e4))


def photon_wavelength_um(band: SensorBand, temperature_K: float | None) -> float:
    """Mean wavelength of the light in a band, at which its power is converted to photons: P lambda / (h c) per second.

    The spectrum in the band is that of a black body, or constant if no temperature is given, because a cube contains
    only the band integral.
    """
    wavelength_um, weight = _nodes(band)
    light = weight if temperature_K is None else weight * _planck_per_um(wavelength_um, temperature_K)
    return float(light @ wavelength_um / light.sum())


def photons_per_radiance(
    aperture_diameter_m: float, pixel_angle_rad: float, transmission: float, wavelength_um: float
) -> float:
    """Photons per second and pixel for a band radiance of 1 W m-2 sr-1: A Omega tau lambda / (h c).

    A circular aperture of area A = pi D^2 / 4, a square pixel of solid angle Omega = ``pixel_angle_rad`` squared, and
    the transmission tau of the optics.
    """
    area_m2 = 0.25 * math.pi * aperture_diameter_m**2
    photons_per_joule = wavelength_um * 1e-6 / (PLANCK_J_S * SPEED_OF_LIGHT_M_S)
    return area_m2 * pixel_angle_rad**2 * transmission * photons_per_joule


def _nodes(band: SensorBand) -> tuple[Array, Array]:
    """Wavelengths (N,) and weights (N,) in um, times the response, for integrals over the band."""
    abscissa, weight = gauss_legendre(_NODES)
    low, step = band.wavelength_um[:-1, None], np.diff(band.wavelength_um)[:, None]
    wavelength_um = (low + 0.5 * step * (abscissa + 1.0)).ravel()
    response = np.interp(wavelength_um, band.wavelength_um, band.response)
    return wavelength_um, (0.5 * step * weight).ravel() * response


def _planck_per_um(wavelength_um: Array, temperature_K: float) -> Array:
    """Planck's function in W m-2 sr-1 um-1."""
    wavenumber_cm1 = wavenumber_from_um(wavelength_um)
    result: Array = planck(wavenumber_cm1, temperature_K) * wavenumber_cm1 / wavelength_um
    return result


@dataclass(frozen=True)
class Readout:
    """Limits of a detector and its converter, in the unit of the signal (electrons or radiance).

    Attributes
    ----------
    full : float or None
        Signal at which the detector is full.
    bits : int or None
        Of the converter; None means an analogue signal.
    step : float
        Signal of one digital number, above 0.
    offset : int
        Digital number at zero signal, which prevents clipping of noise about 0.
    """

    full: float | None = None
    bits: int | None = None
    step: float = 1.0
    offset: int = 0
