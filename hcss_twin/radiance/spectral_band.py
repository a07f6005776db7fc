"""A spectral band with its response."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SpectralBand:
    """A band with its response.

    Attributes
    ----------
    name : str
        Name in the cube.
    wavelength_um : ndarray (N,)
        Ascending wavelengths at which the response is known; linear between, 0 outside.
    response : ndarray (N,)
        Relative response, 0 to 1.
    """

    name: str
    wavelength_um: Array
    response: Array

    @property
    def lower_um(self) -> float:
        """Shortest wavelength."""
        return float(self.wavelength_um[0])

    @property
    def upper_um(self) -> float:
        """Longest wavelength."""
        return float(self.wavelength_um[-1])

    @property
    def width_cm1(self) -> float:
        """Distance of its limits in wavenumber."""
        return 1e4 / self.lower_um - 1e4 / self.upper_um

    @property
    def central_um(self) -> float:
        """Centroid over wavelength of the response, which is linear between its nodes."""
        step, left, right = np.diff(self.wavelength_um), self.response[:-1], self.response[1:]
        # From the shortest wavelength: relative to it the moments of narrow bands keep their digits.
        start = self.wavelength_um[:-1] - self.wavelength_um[0]
        area = step * (left + right) / 2.0
        moment = start * area + step**2 * (left + 2.0 * right) / 6.0
        return self.lower_um + float(np.sum(moment) / np.sum(area))
