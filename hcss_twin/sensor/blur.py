"""Spread by the optics and smear by motion, together one transfer function."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import SensorBand, SensorInputs
from hcss_twin.sensor.band_light import photon_wavelength_um
from hcss_twin.sensor.kernel import convolve, read_kernel
from hcss_twin.sensor.parameters import RadiometerParameters
from hcss_twin.sensor.point_spread import airy_cutoff, airy_mtf, gaussian_mtf
from hcss_twin.sensor.smear import smear_mtf, smear_pixels
from hcss_twin.sensor.transfer import apply_transfer

Array = NDArray[np.float64]

EDGE_NOTE = (
    "blur at the edges of the image takes the scene beyond them for its mirror image: pixels no farther from an edge "
    "than the blur reaches are not those of a larger image"
)


class Blur:
    """What optics and motion do to a frame.

    Parameters
    ----------
    inputs, parameters
        Of the sensor.

    Raises
    ------
    CatalogError
        If the kernel's file is missing or malformed.
    """

    def __init__(self, inputs: SensorInputs, parameters: RadiometerParameters) -> None:
        self._parameters = parameters
        self._kernel: Array | None = None
        if parameters.psf == "file" and parameters.psf_file is not None:
            self._kernel = read_kernel(inputs.catalog.file(parameters.psf_file))
        self._smear = 0.0
        if parameters.smear and parameters.integration_time is not None:
            self._smear = smear_pixels(
                inputs.platform_speed_m_s, parameters.integration_time, inputs.grid.pixel_size_m
            )
        self._spreads = parameters.psf in ("gaussian", "airy")
        self._blurs = self._spreads or self._smear > 0.0

    @property
    def reach_pixels(self) -> int | None:
        """As far as a pixel has a share; a transfer function reaches through the whole frame."""
        if self._blurs:
            return None
        return 0 if self._kernel is None else max(self._kernel.shape) // 2

    @property
    def notes(self) -> tuple[str, ...]:
        """What users should know."""
        return () if self.reach_pixels == 0 else (EDGE_NOTE,)

    @property
    def worked_out(self) -> dict[str, Any]:
        """Numbers that hold for all bands."""
        return {"smear_pixels": self._smear} if self._smear > 0.0 else {}

    def worked_out_of(self, band: SensorBand) -> dict[str, Any]:
        """Modulation transfer of optics and smear at half a cycle per pixel, along y and along x."""
        if not self._blurs:
            return {}
        half, none = np.array([0.5]), np.array([0.0])
        return {
            "mtf_nyquist_y": float(self._transfer(band, half, none)[0]),
            "mtf_nyquist_x": float(self._transfer(band, none, half)[0]),
        }

    def __call__(self, image: Array, band: SensorBand) -> Array:
        """Return a frame (Y, X) as it falls on the detectors."""
        if self._kernel is not None:
            image = convolve(image, self._kernel)
        if not self._blurs:
            return image
        return apply_transfer(image, lambda along_y, along_x: self._transfer(band, along_y, along_x))

    def _transfer(self, band: SensorBand, along_y: Array, along_x: Array) -> Array:
        given = self._parameters
        factor = smear_mtf(along_x, self._smear)
        if given.psf == "gaussian" and given.psf_sigma is not None:
            return factor * gaussian_mtf(along_x, given.psf_sigma) * gaussian_mtf(along_y, given.psf_sigma)
        if given.psf == "airy" and given.aperture_diameter is not None and given.pixel_angle is not None:
            wavelength_um = photon_wavelength_um(band, None)
            cutoff = airy_cutoff(given.aperture_diameter, given.pixel_angle, wavelength_um)
            return factor * airy_mtf(np.hypot(along_y, along_x), cutoff)
        return factor + 0.0 * along_y
