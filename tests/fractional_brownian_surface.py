"""Exact fractional Brownian surfaces: known fractal dimension, for measuring estimators."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft2, next_fast_len, rfft2

from hcss_twin.core.errors import ImageError

# Up to this exponent of the variogram the covariance may be cut at the unit distance.
_SIMPLE_UP_TO = 1.5


@dataclass(frozen=True)
class CirculantEmbedding:
    """Square roots of the eigenvalues of a surface's covariance on a torus.

    Attributes
    ----------
    size : int
        Pixels along each side of the surface.
    hurst : float
        Hurst exponent.
    side : int
        Nodes along each side of the torus.
    amplitude : ndarray of float64 (side, side // 2 + 1)
        Square roots, in the order of ``scipy.fft.rfft2``.
    tilt_variance : float
        Variance of each of the two slopes, per pixel squared, that complete the variogram.
    """

    size: int
    hurst: float
    side: int
    amplitude: NDArray[np.float64]
    tilt_variance: float


def circulant_embedding(size: int, hurst: float) -> CirculantEmbedding:
    """Find the torus on which a surface of ``size`` pixels can be drawn exactly.

    M. L. Stein, "Fast and exact simulation of fractional Brownian surfaces", J. Comput. Graph.
    Stat. 11, 587-599 (2002). With distances r in units of the surface's diagonal and a = 2 H, the
    covariance

        K(r) = c0 - r^a + c2 r^2           for r <= 1,
        K(r) = b (R - r)^3 / r             for 1 < r <= R,
        K(r) = 0                           beyond,

    is positive definite in the plane, so its periodic repetition on a torus of side 2 R or more is
    as well. For a <= 1.5, R = 1 and b = 0; for a > 1.5, R = 2 and b = a (2 - a) / [3 R (R^2 - 1)].
    Continuity of K and of its slope at r = 1 gives c2 = [a - b (R - 1)^2 (R + 2)] / 2 and
    c0 = b (R - 1)^3 + 1 - c2. A plane with two random slopes cancels the term c2 r^2.

    Raises
    ------
    ImageError
        If the size is less than 2 or the exponent is not between 0 and 1.
    """
    if size < 2:
        raise ImageError(f"size: {size} given, allowed: 2 or more; closest is 2")
    if not 0.0 < hurst < 1.0:
        raise ImageError(f"hurst: {hurst} given, allowed: greater than 0 and less than 1")
    exponent = 2.0 * hurst
    if exponent <= _SIMPLE_UP_TO:
        reach, outer = 1.0, 0.0
    else:
        reach = 2.0
        outer = exponent * (2.0 - exponent) / (3.0 * reach * (reach**2 - 1.0))
    parabola = (exponent - outer * (reach - 1.0) ** 2 * (reach + 2.0)) / 2.0
    level = outer * (reach - 1.0) ** 3 + 1.0 - parabola

    # No two pixels are farther apart than the unit of length.
    diagonal = math.sqrt(2.0) * (size - 1)
    side = next_fast_len(math.ceil(2.0 * reach * diagonal) + 1, real=True)
    steps = np.minimum(np.arange(side), side - np.arange(side)) / diagonal
    distance = np.hypot(steps[:, None], steps[None, :])
    covariance = np.zeros_like(distance)
    near = distance <= 1.0
    r = distance[near]
    covariance[near] = level - r**exponent + parabola * r**2
    if outer > 0.0:
        far = (distance > 1.0) & (distance < reach)
        r = distance[far]
        covariance[far] = outer * (reach - r) ** 3 / r
    eigenvalues = rfft2(covariance).real
    # Theory says none is negative; what rounding makes so is set to zero, more would be a wrong covariance.
    if eigenvalues.min() < -1e-9 * eigenvalues.max():
        raise ImageError(f"size, hurst: no embedding for {size} and {hurst}: negative eigenvalues")
    # In pixels, |h|^(2 H) = diagonal^(2 H) r^(2 H); the variance of a difference is 2 [K(0) - K(r)].
    scale = diagonal**exponent / 2.0
    amplitude = np.sqrt(np.maximum(eigenvalues, 0.0) * scale)
    return CirculantEmbedding(size, hurst, side, amplitude, 2.0 * scale * parabola / diagonal**2)


def draw_surface(embedding: CirculantEmbedding, seed: int) -> NDArray[np.float64]:
    """Draw one surface; see ``fractional_brownian_surface``."""
    random = np.random.default_rng(seed)
    side, size = embedding.side, embedding.size
    spectrum = rfft2(random.standard_normal((side, side)), overwrite_x=True)
    spectrum *= embedding.amplitude
    field = irfft2(spectrum, s=(side, side), overwrite_x=True)[:size, :size]
    slope_y, slope_x = random.standard_normal(2) * math.sqrt(embedding.tilt_variance)
    pixels = np.arange(size, dtype=np.float64)
    surface: NDArray[np.float64] = field - field[0, 0] + slope_y * pixels[:, None] + slope_x * pixels
    return surface


def fractional_brownian_surface(size: int, hurst: float, seed: int) -> NDArray[np.float64]:
    """Draw an isotropic fractional Brownian surface, exact in law.

    A Gaussian field with W(0, 0) = 0 and E[W(p + h) - W(p)]^2 = |h|^(2 H), h in pixels; its fractal
    dimension is 3 - H. Intrinsic embedding of Stein (2002), see ``circulant_embedding``, which is
    worth keeping where many surfaces of one kind are drawn.

    Parameters
    ----------
    size : int
        Pixels along each side, 2 or more. Memory is about 130 bytes x size^2 for H <= .75 and four
        times that above.
    hurst : float
        Hurst exponent H, between 0 and 1.
    seed : int
        Seed of numpy's default generator.

    Returns
    -------
    ndarray of float64 (size, size)

    Raises
    ------
    ImageError
        If the size is less than 2 or the exponent is not between 0 and 1.
    """
    return draw_surface(circulant_embedding(size, hurst), seed)
