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
        """Centroid of the response over wavelength."""
        step = np.diff(self.wavelength_um)
        response, moment = self.response, self.response * self.wavelength_um
        area = np.sum(step * (response[1:] + response[:-1]))
        return float(np.sum(step * (moment[1:] + moment[:-1])) / area)
