"""Blur of a frame: point spread of the optics, and smear by footprint motion during integration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from hcss_twin.core.arrays import Array
from hcss_twin.models.sensor.detector import photon_wavelength_um
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.point_image import PointImage
from hcss_twin.models.sensor.point_spread import (
    airy_mtf,
    convolve,
    gaussian_mtf,
    line_kernel,
    mirrored_transfer,
    plane_kernel,
    read_kernel,
    separated,
)
from hcss_twin.models.sensor.rows import TAPS_AT_ONCE
from hcss_twin.providers import Points, SensorBand, SensorInputs

MOST_WEIGHTS = 768
"""Weights of kernels along rows and columns up to which a sum over pixels is faster than transforms of the image."""


def smear_mtf(frequency_x: Array, pixels: float) -> Array:
    """MTF of uniform motion along x, sin(pi f d) / (pi f d), centred on the time of the frame.

    The frequency f is in cycles per pixel, the distance d of one integration in pixels.
    """
    result: Array = np.sinc(frequency_x * pixels)
    return result


class Weights(NamedTuple):
    """Weights of neighbouring pixels, as :func:`hcss_twin.models.sensor.rows.measure` takes them.

    Attributes
    ----------
    down, across : ndarray (K, N) of float32
        Kernels along columns and rows, whose K products are summed; N is a multiple of 4, filled up with 0.
    reach : (int, int)
        Pixels before the middle of a kernel, along columns and rows.
    """

    down: NDArray[np.float32]
    across: NDArray[np.float32]
    reach: tuple[int, int]


_NONE = np.zeros((0, TAPS_AT_ONCE), np.float32)
UNBLURRED = Weights(_NONE, _NONE, (0, 0))
"""No blur: of images that have passed the optics, or are dark."""


def _weights(kernels: Sequence[Array]) -> Weights | None:
    """Return the weights of neighbours for kernels that are applied in turn; None if they are too many."""
    terms = separated(kernels, MOST_WEIGHTS) if kernels else ([], [])
    if terms is None:
        return None
    down, across = terms
    return Weights(_padded(down), _padded(across), (_reach(down), _reach(across)))


def _padded(kernels: list[Array]) -> NDArray[np.float32]:
    """Return kernels as weights (T, K) from the lowest neighbour on, with zeros up to a multiple of TAPS_AT_ONCE."""
    size = 2 * _reach(kernels) + 1
    weights = np.zeros((len(kernels), size + -size % TAPS_AT_ONCE), np.float32)
    for weight, kernel in zip(weights, kernels, strict=True):
        weight[:size] = kernel[::-1]
    return weights


def _reach(kernels: list[Array]) -> int:
    return kernels[0].size // 2 if kernels else 0


class Blur:
    """Blur kernels of optics and motion with finite support, and their convolution with a frame.

    Raises
    ------
    CatalogError
        If the kernel file is missing or malformed.
    """

    def __init__(self, inputs: SensorInputs, parameters: RadiometerParameters) -> None:
        self._parameters = parameters
        measured: tuple[Array, ...] = ()
        if parameters.psf == "file" and parameters.psf_file is not None:
            measured = (read_kernel(inputs.catalog.file(parameters.psf_file)),)
        self._exposure_s = (parameters.integration_time or 0.0) if parameters.smear else 0.0
        self._smear = abs(inputs.platform_speed_m_s) * self._exposure_s / inputs.grid.pixel_size_m
        self._blurs = parameters.psf in ("gaussian", "airy") or self._smear > 0.0 or parameters.jitter > 0.0
        self._sigma = math.hypot(parameters.psf_sigma or 0.0, parameters.jitter) or None
        self._cut = 0.0
        self._kernels = {band.name: (*measured, *self._kernels_of(band)) for band in inputs.bands}
        self._transfers: dict[tuple[str, tuple[int, ...]], Array] = {}
        self.weights = {name: _weights(kernels) for name, kernels in self._kernels.items()}
        spot = measured[0] if measured else None
        self._point_images = [
            PointImage(self._sigma, self._cutoff(band) if parameters.psf == "airy" else None, spot)
            for band in inputs.bands
        ]

    def of_points(self, points: Points, rows: int, columns: int) -> NDArray[np.float32]:
        """Return what points add to a blurred frame (B, rows, columns), smeared by their own motion against it."""
        added = np.zeros((len(self._point_images), rows, columns))
        for band, (image, point_image) in enumerate(zip(added, self._point_images, strict=True)):
            point_image.draw(image, points, band, self._exposure_s)
        return added.astype(np.float32)

    @property
    def reach_pixels(self) -> int:
        """Maximum distance along either axis at which a pixel contributes."""
        return max(
            sum(int(kernel.shape[axis]) // 2 for kernel in kernels)
            for kernels in self._kernels.values()
            for axis in (0, 1)
        )

    @property
    def worked_out(self) -> dict[str, Any]:
        """Derived quantities of all bands."""
        smear = {"smear_pixels": self._smear} if self._smear > 0.0 else {}
        if not self.reach_pixels:
            return smear
        return {**smear, "blur_reach_pixels": self.reach_pixels, "blur_share_beyond_reach": self._cut}

    def worked_out_of(self, band: SensorBand) -> dict[str, Any]:
        """MTF of optics and smear at half a cycle per pixel, along y and along x."""
        if not self._blurs:
            return {}
        half, none = np.array([0.5]), np.array([0.0])
        return {
            "mtf_nyquist_y": float(self._transfer(band, half, none)[0]),
            "mtf_nyquist_x": float(self._transfer(band, none, half)[0]),
        }

    def without_optics(self, bands: Sequence[SensorBand]) -> str:
        """Return the note of a sensor whose optics do not blur, with what diffraction would do if it is known."""
        note, given = 'sensor: psf = "none": optics do not blur', self._parameters
        if given.aperture_diameter is None or given.pixel_angle is None:
            return f"{note}; psf computes it"
        half = {band.name: float(airy_mtf(np.array(0.5), self._cutoff(band))) for band in bands}
        least = min(half, key=half.__getitem__)
        return (
            f"{note}; diffraction has an MTF of {half[least]:.2g} at half a cycle per pixel (band '{least}'): "
            'psf = "airy" computes it'
        )

    def __call__(self, image: Array, band: SensorBand) -> Array:
        """Return the frame (Y, X) at the detectors."""
        for kernel in self._kernels[band.name]:
            image = convolve(image, kernel)
        return image

    def by_rows(self, image: NDArray[np.float32], band: SensorBand) -> tuple[NDArray[np.float32], Weights]:
        """Return an image (Y, X) and the weights of neighbouring pixels that blur it.

        Where these are too many, the image is blurred by transforms in double precision, and there are no weights.
        """
        weights = self.weights[band.name]
        if not image.any():
            return image, UNBLURRED
        if weights is not None:
            return image, weights
        if self._parameters.psf == "file":
            blurred = self(image.astype(np.float64), band)
        else:
            key = band.name, image.shape
            if key not in self._transfers:
                self._transfers[key] = mirrored_transfer(self._kernels[band.name], (image.shape[0], image.shape[1]))
            blurred = idctn(dctn(image.astype(np.float64)) * self._transfers[key], overwrite_x=True)
        return blurred.astype(np.float32), UNBLURRED

    def _kernels_of(self, band: SensorBand) -> tuple[Array, ...]:
        """Return the kernels of the transfer functions, one for each axis where they separate."""
        if not self._blurs:
            return ()
        given = self._parameters
        planes = [_airy_kernel(self._cutoff(band))] if given.psf == "airy" else []
        sigmas = (given.jitter, given.psf_sigma or 0.0) if given.psf == "gaussian" else (given.jitter,)
        (along_x, cut_x), (along_y, cut_y) = (_line_kernel(smear, sigmas) for smear in (self._smear, 0.0))
        self._cut = max(self._cut, cut_x + cut_y + sum(cut for _, cut in planes))
        kernels = (*(plane for plane, _ in planes), along_y[:, None], along_x[None, :])
        return tuple(kernel for kernel in kernels if kernel.size > 1)

    def _cutoff(self, band: SensorBand) -> float:
        """Return the cut-off frequency of the aperture, in cycles per pixel: diameter x angle / wavelength."""
        given = self._parameters
        assert given.aperture_diameter is not None
        assert given.pixel_angle is not None
        return given.aperture_diameter * given.pixel_angle / (photon_wavelength_um(band, None) * 1e-6)

    def _motion(self, along_y: Array, along_x: Array) -> Array:
        """Return the MTF of smear and jitter."""
        jitter = self._parameters.jitter
        return smear_mtf(along_x, self._smear) * gaussian_mtf(along_x, jitter) * gaussian_mtf(along_y, jitter)

    def _transfer(self, band: SensorBand, along_y: Array, along_x: Array) -> Array:
        given, factor = self._parameters, self._motion(along_y, along_x)
        if given.psf == "gaussian" and given.psf_sigma is not None:
            return factor * gaussian_mtf(along_x, given.psf_sigma) * gaussian_mtf(along_y, given.psf_sigma)
        if given.psf == "airy":
            return factor * airy_mtf(np.hypot(along_y, along_x), self._cutoff(band))
        return factor + 0.0 * along_y


@lru_cache(maxsize=128)
def _line_kernel(smear: float, sigmas: tuple[float, ...]) -> tuple[Array, float]:
    """Return the kernel of smear and Gaussian spreads along one axis; cached as that of an aperture."""

    def transfer(frequency: Array) -> Array:
        factor = smear_mtf(frequency, smear)
        for sigma in sigmas:
            factor = factor * gaussian_mtf(frequency, sigma)
        return factor

    kernel, cut = line_kernel(transfer)
    kernel.flags.writeable = False
    return kernel, cut


@lru_cache(maxsize=128)
def _airy_kernel(cutoff: float) -> tuple[Array, float]:
    """Return the kernel of a round aperture; cached, because a run builds its sensor for several sizes of image."""
    kernel, cut = plane_kernel(lambda along_y, along_x: airy_mtf(np.hypot(along_y, along_x), cutoff))
    kernel.flags.writeable = False
    return kernel, cut
