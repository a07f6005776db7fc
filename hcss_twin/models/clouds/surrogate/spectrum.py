"""Fourier magnitudes of a measured image: without the cross of its borders, for a plane of any size."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.fft import fft2, fftfreq, ifft2, irfft2, rfft2, rfftfreq
from scipy.ndimage import map_coordinates
from scipy.special import ndtri

from hcss_twin.core.arrays import Array

# Quantiles that stand for an amplitude distribution, and terms of its Hermite series.
_QUANTILES = 1 << 14
_HERMITE_TERMS = 80
_CORRELATIONS = 1 << 13


def periodic_component(image: Array) -> Array:
    """Return the periodic component of an image (same shape), without its jumps across opposite borders.

    L. Moisan, "Periodic plus smooth image decomposition", J. Math. Imaging Vis. 39, 161-179 (2011): the
    smooth component solves the discrete Poisson equation whose source is the jump across the borders, and
    what is left has (almost) none. The plain transform of an image that is not periodic shows a cross
    along both axes, and surrogates of it are woven of stripes. Mirroring the image would remove the jumps
    too, but gives oblique streaks the spectrum of a lattice; a window would weigh the middle of the image
    more than the rest and widen each peak.
    """
    rows, columns = image.shape
    jumps = np.zeros_like(image)
    across = image[-1] - image[0]
    jumps[0] += across
    jumps[-1] -= across
    along = image[:, -1] - image[:, 0]
    jumps[:, 0] += along
    jumps[:, -1] -= along
    # Eigenvalues of the discrete Laplacian of the torus.
    laplacian = (
        2.0 * np.cos(2.0 * np.pi * fftfreq(rows))[:, None] + 2.0 * np.cos(2.0 * np.pi * fftfreq(columns))[None, :] - 4.0
    )
    laplacian[0, 0] = 1.0
    smooth = fft2(jumps) / laplacian
    smooth[0, 0] = 0.0
    component: Array = image - ifft2(smooth).real
    return component


def plane_magnitude(component: Array, shape: tuple[int, int]) -> Array:
    """Return Fourier magnitudes of a plane with the spectrum of a (periodic) image.

    Parameters
    ----------
    component : ndarray (rows, columns)
        The image.
    shape : (int, int)
        Rows and columns of the plane. Where they are not those of the image, the power is interpolated
        linearly between the wavenumbers of the image: structures larger than the image get none of
        their own.

    Returns
    -------
    ndarray (shape[0], shape[1] // 2 + 1)
        Magnitudes of ``rfft2``, 0 at wavenumber 0, for a variance of 1; all 0 for a constant image.
    """
    rows, columns = component.shape
    varying = component - component.mean()
    if shape == component.shape:
        magnitude: Array = np.abs(rfft2(varying))
    else:
        power = np.abs(fft2(varying)) ** 2
        power[0, 0] = 0.0
        y, x = np.meshgrid(fftfreq(shape[0]) * rows, rfftfreq(shape[1]) * columns, indexing="ij")
        magnitude = np.sqrt(map_coordinates(power, (y, x), order=1, mode="grid-wrap"))
    magnitude[0, 0] = 0.0
    variance = float(irfft2(magnitude**2, s=shape)[0, 0]) / (shape[0] * shape[1])
    return magnitude / np.sqrt(variance) if variance > 0.0 else magnitude


def underlying_magnitude(magnitude: Array, shape: tuple[int, int], amplitudes: Array) -> Array:
    """Return the magnitudes of the Gaussian field that gets the wanted ones with its new amplitudes.

    Giving a Gaussian field X the amplitudes g(X) changes its correlation r into
    sum_n c_n^2 r^n / sum_n c_n^2 with the Hermite coefficients c_n of g (M. Grigoriu, "Crossings of
    non-Gaussian translation processes", J. Eng. Mech. 110, 610-620, 1984). That is inverted here at each
    lag. The spectrum of X must lie between 0 and that of g(X) over c_1^2, because no term is negative;
    where the wanted pair does not exist it is clipped to that. Iterations that start here have a short
    way to go, so that they neither take long nor jump from one solution to another as the start changes.

    Parameters
    ----------
    magnitude : ndarray (shape[0], shape[1] // 2 + 1)
        Wanted magnitudes, as :func:`plane_magnitude` gives them.
    shape : (int, int)
        Rows and columns of the plane.
    amplitudes : ndarray (N,)
        Wanted amplitudes, ascending, not all equal.

    Returns
    -------
    ndarray (shape[0], shape[1] // 2 + 1)
        For a variance of 1. Equal to ``magnitude`` where the amplitudes are normal.
    """
    share = _hermite_shares(amplitudes)
    correlation = np.linspace(-1.0, 1.0, _CORRELATIONS + 1)
    # Rises for any rank-preserving g; rounding aside.
    mapped = np.maximum.accumulate(polyval(correlation, np.concatenate(([0.0], share))))
    power = magnitude**2
    covariance = irfft2(power, s=shape)
    underlying = rfft2(np.interp(covariance / covariance[0, 0], mapped, correlation)).real
    clipped = np.clip(underlying, 0.0, power / (covariance[0, 0] * share[0]))
    clipped[0, 0] = 0.0
    variance = float(irfft2(clipped, s=shape)[0, 0]) / (shape[0] * shape[1])
    result: Array = np.sqrt(clipped / variance)
    return result


def _hermite_shares(amplitudes: Array) -> Array:
    """Return c_n^2 over their sum for n = 1, 2, ... of the map from normal quantiles to ``amplitudes``."""
    level = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
    normal = ndtri(level)
    values = amplitudes[(level * amplitudes.size).astype(np.int64)]
    values = values - values.mean()
    squares = np.empty(_HERMITE_TERMS)
    before, polynomial = np.ones_like(normal), normal.copy()
    for n in range(1, _HERMITE_TERMS + 1):
        squares[n - 1] = np.mean(values * polynomial) ** 2
        # Normalised: He_(n+1) / sqrt((n+1)!).
        before, polynomial = (polynomial, (normal * polynomial - np.sqrt(n) * before) / np.sqrt(n + 1.0))
    shares: Array = squares / squares.sum()
    return shares
