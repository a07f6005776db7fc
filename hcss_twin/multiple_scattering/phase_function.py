"""Phase functions by their Legendre moments, and their delta-M scaling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.henyey_greenstein import henyey_greenstein

Array = NDArray[np.float64]

# Two moments, 1 and g, stand for the Henyey-Greenstein function of that g.
HENYEY_GREENSTEIN_MOMENTS = 2


@dataclass(frozen=True)
class ScaledScattering:
    """What is left of a layer when the forward peak counts as light that was not scattered.

    Attributes
    ----------
    thickness : ndarray (T, V)
        Scaled optical thickness tau' = (1 - w f) tau.
    albedo, co_albedo : ndarray (V,)
        Scaled albedo w' = w (1 - f) / (1 - w f), and 1 - w' without cancellation.
    moments : ndarray (L, V)
        Scaled moments (chi_l - f) / (1 - f), l < L.
    peak : ndarray (V,)
        f, the share of scattered light in the peak: the moment of degree L.
    """

    thickness: Array
    albedo: Array
    co_albedo: Array
    moments: Array
    peak: Array


def extended_moments(moments: Array, count: int) -> Array:
    """First ``count`` moments: g^l where only 1 and g are given, else zeros after the last one.

    Parameters
    ----------
    moments : ndarray (K, V)
        Means of P_l over the phase function; K = 2 stands for Henyey and Greenstein's.
    """
    given, columns = moments.shape
    if given == HENYEY_GREENSTEIN_MOMENTS:
        result: Array = moments[1] ** np.arange(count)[:, np.newaxis]
        return result
    result = np.zeros((count, columns))
    result[:given] = moments[:count]
    return result


def delta_m(thickness: Array, albedo: Array, moments: Array, count: int) -> ScaledScattering:
    """Scale a layer by the delta-M method so that ``count`` moments describe its phase function.

    Parameters
    ----------
    thickness : ndarray (T, V)
    albedo : ndarray (V,)
    moments : ndarray (K, V)
        As for :func:`extended_moments`.
    count : int
        Moments kept, L; twice the streams per hemisphere.

    References
    ----------
    W. J. Wiscombe, J. Atmos. Sci. 34, 1408-1422 (1977), eqs 10 to 20.
    """
    known = extended_moments(moments, count + 1)
    peak = known[count]
    rest = 1.0 - albedo * peak
    scaled = (known[:count] - peak) / (1.0 - peak)
    return ScaledScattering(
        thickness * rest, albedo * (1.0 - peak) / rest, (1.0 - albedo) / rest, scaled, peak
    )


def phase_function(scattering_cosine: Array, moments: Array) -> Array:
    """Full phase function with mean 1 over the sphere, (V, P), at cosines (P,).

    Parameters
    ----------
    scattering_cosine : ndarray (P,)
    moments : ndarray (K, V)
        As for :func:`extended_moments`: the closed form for K = 2, else the sum of the series.
    """
    if moments.shape[0] == HENYEY_GREENSTEIN_MOMENTS:
        return henyey_greenstein(scattering_cosine, moments[1][:, np.newaxis])
    series = (2 * np.arange(moments.shape[0]) + 1)[:, np.newaxis] * moments
    return np.asarray(np.polynomial.legendre.legval(scattering_cosine, series), dtype=np.float64)
