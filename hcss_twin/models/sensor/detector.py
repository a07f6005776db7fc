"""How light is spread over a band: its black-body radiance, and how many photons a joule is.

From radiance to photons and electrons.

Saturation and quantisation of a signal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import PLANCK_J_S, SECOND_RADIATION, SPEED_OF_LIGHT_M_S, planck, wavenumber_from_um
from hcss_twin.physics.quadrature import gauss_legendre
from hcss_twin.providers import SensorBand

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


@dataclass(frozen=True)
class Detection:
    """Factors between radiance, photons and electrons of one band.

    Attributes
    ----------
    photons_per_radiance : float
        Photons per second on a pixel's detector for 1 W m-2 sr-1, A Omega tau lambda / (h c) with the aperture's
        area A, the pixel's solid angle Omega and the transmission tau of the optics.
    electrons_per_radiance : float
        Electrons per integration for 1 W m-2 sr-1.
    dark_electrons : float
        Mean of what the dark current adds in one integration.
    read_noise : float
        Standard deviation, electrons.
    shot_noise : bool
        Whether electrons come one by one.
    """

    photons_per_radiance: float
    electrons_per_radiance: float
    dark_electrons: float
    read_noise: float
    shot_noise: bool


def photons_per_radiance(
    aperture_diameter_m: float, pixel_angle_rad: float, transmission: float, wavelength_um: float
) -> float:
    """Photons per second and pixel for a band radiance of 1 W m-2 sr-1.

    A circular aperture of area pi D^2 / 4 and a square pixel of solid angle ``pixel_angle_rad`` squared.
    """
    area_m2 = 0.25 * math.pi * aperture_diameter_m**2
    return area_m2 * pixel_angle_rad**2 * transmission * photons_per_joule(wavelength_um)


UPPER, LOWER = 1, 2
"""Flags of values that were cut at the upper and at the lower end."""


@dataclass(frozen=True)
class Readout:
    """What a detector and its converter can hold, in the unit of the signal (electrons or radiance).

    Attributes
    ----------
    full : float or None
        Signal at which the detector is full.
    bits : int or None
        Of the converter; None leaves the signal analogue.
    step : float
        Signal of one digital number, above 0.
    offset : int
        Digital number of no signal, which keeps noise about 0 from being cut.
    """

    full: float | None = None
    bits: int | None = None
    step: float = 1.0
    offset: int = 0

    def read(self, signal: Array) -> tuple[Array, NDArray[np.int32] | None, NDArray[np.uint8]]:
        """Read a frame.

        Returns
        -------
        signal : ndarray (Y, X)
            As known after it was read: that of the digital number where there is one.
        digital_number : ndarray (Y, X) or None
            The nearest whole number to signal / step + offset, halves up, within 0 and 2^bits - 1.
        flags : ndarray (Y, X)
            0, or where a value was cut 1 (upper end) or 2 (lower end).
        """
        flags = np.zeros(signal.shape, dtype=np.uint8)
        if self.full is not None:
            flags[signal > self.full] = UPPER
            signal = np.minimum(signal, self.full)
        if self.bits is None:
            return signal, None, flags
        number = np.floor(signal / self.step + 0.5) + self.offset
        most = float(2**self.bits - 1)
        flags[number > most] = UPPER
        flags[number < 0.0] = LOWER
        number = np.clip(number, 0.0, most)
        return (number - self.offset) * self.step, number.astype(np.int32), flags
