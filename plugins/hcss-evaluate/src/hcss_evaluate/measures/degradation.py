"""Blur and noise of a sensor, estimated from one of its images.

It is Fig 17 of the HCSS paper the other way round: the paper degrades an image by the blur and the noise of an on-orbit
image, and here they are found from that image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hcss_evaluate.measures.images import checked_image
from hcss_evaluate.measures.power_spectrum import DEPENDENT_WAVES
from hcss_twin.providers import Array, ImageError
from hcss_twin.reports.power_spectrum import Rings

SMALLEST_SIDE = 64
_FEWEST_WAVES = 4.0
_RINGS = 96


@dataclass(frozen=True)
class Degradation:
    """Blur and noise of an image.

    Attributes
    ----------
    blur_sigma_pixels, blur_error : float
        Standard deviation of the Gaussian blur, pixels, and its standard error; the blur includes the pixel's own area.
        0 if the image is not blurred beyond a power law.
    noise, noise_error : float
        Standard deviation of the white noise in the unit of the image, and its standard error.
    slope : float
        Exponent of the scene: its power falls as wavenumber^-slope; 0 if an image of the scene was given.
    misfit_db : float
        Root mean square of 10 log10 (power of a ring / model): what the model of the scene leaves.
    """

    blur_sigma_pixels: float
    blur_error: float
    noise: float
    noise_error: float
    slope: float
    misfit_db: float


def estimate_degradation(image: NDArray[Any], scene: NDArray[Any] | None = None) -> Degradation:
    """Estimate blur and noise of an image whose scene has a power-law spectrum, or that of another image.

    The power is modelled as A S(k) exp(-(2 pi sigma k)^2) + noise^2, where S is k^-slope or the power of ``scene``, and
    fitted to the whole spectrum by Whittle's likelihood (Whittle, Ark. Mat. 2, 423, 1953), up to the corners of the
    wavenumber plane, where mostly noise is left.

    Standard errors hold for a scene that follows the model. A scene with a break in its spectrum near the pixel size,
    or noise that is correlated (compression, striping, resampling), biases the estimate. In eight SEVIRI images, blurs
    of 1 and 1.8 pixels added to them differed in sigma^2 by 2.0 to 2.6 instead of 2.24. The spectrum of fractal clouds
    of few octaves has steps: in cirrus (Fig 17, 11 seeds) a blur of 1.5 pixels is found as 1.96 to 2.08 with a power
    law, and as 1.42 to 1.59 with a ``scene`` of another seed.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 64 x 64 pixels, any unit, one surface type without missing pixels.
    scene : ndarray (rows, columns), optional
        Sharp image without noise of the same kind of scene, size and pixel size, such as a simulated one.

    Raises
    ------
    ImageError
        If an image is too small, constant, a plane, or not finite, or the sizes differ.
    """
    pixels = checked_image("image", image, SMALLEST_SIDE)
    wavenumber, power, waves = _rings(pixels)
    known = np.ones_like(power)
    if scene is not None:
        if np.shape(scene) != pixels.shape:
            raise ImageError(f"scene: {np.shape(scene)} pixels given, allowed: {pixels.shape}, as the image has")
        known = _rings(checked_image("scene", scene, SMALLEST_SIDE))[1]
        waves /= 2.0  # the scene's own power is as uncertain as that of the image
    level = float(power[-_RINGS // 6 :].min())

    def surprise(values: Array) -> tuple[float, Array]:
        expected, slopes = _model(wavenumber, values, known)
        ratio = power / expected
        return float(np.sum(waves * (np.log(expected) + ratio))), slopes @ (waves * (1.0 - ratio))

    slope, steepest = (2.5, 8.0) if scene is None else (0.0, 0.0)
    start = math.log(power[0] / known[0] * wavenumber[0] ** slope)
    limits = [(None, None), (0.0, steepest), (0.0, 100.0), (math.log(level) - 30.0, math.log(power.max()))]
    # The likelihood of a blurred image may have two maxima: much blur with noise, little blur without.
    tries = [
        minimize(surprise, [start, slope, sigma**2, math.log(level)], method="L-BFGS-B", jac=True, bounds=limits)
        for sigma in (0.3, 1.5)
    ]
    values = np.asarray(min(tries, key=lambda found: float(found.fun)).x, dtype=np.float64)
    expected, slopes = _model(wavenumber, values, known)
    fitted = slopes if scene is None else slopes[[0, 2, 3]]
    error_of_square, error_of_noise = np.sqrt(np.diag(np.linalg.pinv((fitted * waves) @ fitted.T)))[-2:].tolist()
    sigma, noise = math.sqrt(values[2]), math.exp(0.5 * values[3])
    return Degradation(
        blur_sigma_pixels=sigma,
        # Near no blur the error of sigma^2 is that of a quantity at its limit.
        blur_error=error_of_square / (2.0 * sigma) if values[2] > error_of_square else math.sqrt(error_of_square),
        noise=noise,
        noise_error=0.5 * noise * error_of_noise,
        slope=float(values[1]),
        misfit_db=float(np.sqrt(np.average((10.0 * np.log10(power / expected)) ** 2, weights=waves))),
    )


def _rings(pixels: NDArray[Any]) -> tuple[Array, Array, Array]:
    """Return wavenumber, mean power density and number of independent waves of rings up to the corners, each (R,)."""
    rows, columns = pixels.shape
    density, along_y, along_x = Rings.power_density(pixels)
    wavenumber = np.hypot(along_y, along_x)
    lowest = _FEWEST_WAVES / min(rows, columns)
    counted = ((along_x > 0.0) | (along_y > 0.0)) & (wavenumber >= lowest)
    k, power = wavenumber[counted], density[counted]
    ring = np.minimum(((k - lowest) / (k.max() - lowest) * _RINGS).astype(np.int64), _RINGS - 1)
    waves = np.bincount(ring, minlength=_RINGS).astype(np.float64)
    full = waves > 0
    means = [np.bincount(ring, values, _RINGS)[full] / waves[full] for values in (k, power)]
    if not np.all(means[1] > 0.0):
        raise ImageError("image: its spectrum has rings without power, allowed: one with values of its own everywhere")
    return means[0], means[1], waves[full] / DEPENDENT_WAVES


def _model(wavenumber: Array, values: Array, known: Array) -> tuple[Array, Array]:
    """Return the power (R,) and the slopes (4, R) of its logarithm over ln A, slope, sigma^2 and ln noise^2.

    ``known`` (R,) is a factor of the scene's power.
    """
    squared = (2.0 * math.pi * wavenumber) ** 2
    scene = known * np.exp(values[0] - values[1] * np.log(wavenumber) - squared * values[2])
    noise = np.full_like(scene, math.exp(values[3]))
    expected: Array = scene + noise
    slopes: Array = np.stack([scene, -np.log(wavenumber) * scene, -squared * scene, noise]) / expected
    return expected, slopes
