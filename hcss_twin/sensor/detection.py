"""From radiance to photons and electrons."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hcss_twin.sensor.band_light import photons_per_joule


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
