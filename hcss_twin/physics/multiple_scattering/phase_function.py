"""Phase functions: Henyey and Greenstein's, others by their Legendre moments, and delta-M scaling of layers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array


def henyey_greenstein(scattering_cosine: Array | float, asymmetry: Array | float) -> Array:
    """Henyey-Greenstein phase function, whose mean over the sphere is 1 (HCSS paper, eq 13).

    Parameters
    ----------
    scattering_cosine : ndarray or float
        Cosine of the scattering angle, 1 is forward.
    asymmetry : ndarray or float
        Asymmetry parameter g in (-1, 1), broadcast against ``scattering_cosine``.

    Returns
    -------
    ndarray
        Dimensionless; divide by 4 pi for the density per steradian. Its Legendre moments are g^n.

    Raises
    ------
    ValueError
        If |g| is not below 1 or a cosine lies outside [-1, 1].

    References
    ----------
    L. G. Henyey and J. L. Greenstein, Astrophys. J. 93, 70 (1941).
    """
    mu = np.asarray(scattering_cosine, dtype=np.float64)
    g = np.asarray(asymmetry, dtype=np.float64)
    if not np.all(np.abs(g) < 1.0):
        raise ValueError(f"asymmetry {np.max(np.abs(g)):g}: allowed above -1 and below 1")
    if not np.all(np.abs(mu) <= 1.0):
        raise ValueError(f"scattering_cosine {mu[np.abs(mu) > 1.0][0] if mu.ndim else mu}: allowed -1 to 1")
    # (1 - g)^2 + 2 g (1 - mu) is 1 + g^2 - 2 g mu without its cancellation near the forward peak.
    result: Array = (1.0 - g * g) / ((1.0 - g) ** 2 + 2.0 * g * (1.0 - mu)) ** 1.5
    return result


HENYEY_GREENSTEIN_MOMENTS = 2
"""Two moments, 1 and g, stand for the Henyey-Greenstein function of that g."""

_FAINT_TERM = 1e-3
"""Moments are complete if the last term of the series in the forward direction is below this."""

_TOGETHER = 512
"""Cosines whose polynomials fit in the processor's cache; of all wavenumbers they are one matrix product."""

_KEPT = 2**22
"""Most elements of a table of polynomials that is kept: at 1440 cosines 2048 degrees, for crystals, take 24 MB."""

_FEWEST_KEPT = 256
"""Degrees of the smallest table, for droplets."""

_FEW_MOMENTS = 32
"""This many moments may describe a smooth phase function completely."""


@dataclass(frozen=True)
class ScaledScattering:
    """Properties of a layer whose forward peak counts as unscattered light.

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
    """First ``count`` moments: g^l if only 1 and g are given; otherwise padded with zeros.

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
    return ScaledScattering(thickness * rest, albedo * (1.0 - peak) / rest, (1.0 - albedo) / rest, scaled, peak)


def phase_function(scattering_cosine: Array, moments: Array) -> Array:
    """Full phase function with mean 1 over the sphere, (V, P), at cosines (P,).

    Where the moments end before those of the forward peak have decayed, the sum of the series oscillates about the
    phase function at all angles, by up to many times its value. Then the series of 1 - mu times the phase function is
    summed, to which the peak hardly contributes, and divided by 1 - mu: the reduced series of D. R. Yennie, D. G.
    Ravenhall and R. N. Wilson, Phys. Rev. 95, 500-512 (1954).

    Parameters
    ----------
    scattering_cosine : ndarray (P,)
    moments : ndarray (K, V)
        As for :func:`extended_moments`: the closed form for K = 2, else the sum of the series.
    """
    if moments.shape[0] == HENYEY_GREENSTEIN_MOMENTS:
        return henyey_greenstein(scattering_cosine, moments[1][:, np.newaxis])
    result = _series(scattering_cosine, moments)
    cut = _end_early(moments)
    if np.any(cut):
        result[cut] = _reduced_series(scattering_cosine, moments[:, cut], result[cut])
    return result


def _series(cosine: Array, moments: Array) -> Array:
    """Sum (V, P) of the Legendre series with moments (K, V)."""
    terms = (2 * np.arange(moments.shape[0]) + 1)[:, np.newaxis] * moments
    result = np.empty((moments.shape[1], cosine.size))
    for first in range(0, cosine.size, _TOGETHER):
        some = slice(first, first + _TOGETHER)
        result[:, some] = (polynomials(cosine, moments.shape[0], some) @ terms).T
    return result


def polynomials(cosine: Array, count: int, some: slice = slice(None)) -> Array:
    """Legendre polynomials (S, count) at some of the cosines (P,); those of one direction and of tables are kept."""
    most = max(_FEWEST_KEPT, 1 << (count - 1).bit_length())
    if cosine.size == 1:
        return _of_one(cosine.tobytes(), most)[some, :count]
    if cosine.size <= _TOGETHER or cosine.size * most > _KEPT:
        return _polynomials(cosine[some].tobytes(), count)
    return _of_table(cosine.tobytes(), most)[some, :count]


def _polynomials(cosine: bytes, count: int) -> Array:
    result = np.asarray(np.polynomial.legendre.legvander(np.frombuffer(cosine), count - 1), dtype=np.float64)
    result.flags.writeable = False
    return result


_of_one = lru_cache(maxsize=64)(_polynomials)
_of_table = lru_cache(maxsize=4)(_polynomials)


def _end_early(moments: Array) -> NDArray[np.bool_]:
    """Whether moments (K, V) end before they have decayed, (V,).

    They do if the last of many moments is at least half the one before, or if the sum is negative anywhere. Moments
    that end abruptly, like Rayleigh's, and few moments are complete if the sum is nowhere negative.
    """
    count, last, before = moments.shape[0], np.abs(moments[-1]), np.abs(moments[-2])
    seen = (2 * count - 1) * last > _FAINT_TERM
    result: NDArray[np.bool_] = seen & (last <= before) & (before <= 2.0 * last) & (count > _FEW_MOMENTS)
    unsure = seen & ~result
    if np.any(unsure):
        cosine = np.cos(np.linspace(0.0, np.pi, 2 * count + 1))
        result[unsure] = np.min(_series(cosine, moments[:, unsure]), axis=1) < 0.0
    return result


def _reduced_series(cosine: Array, moments: Array, series: Array) -> Array:
    """Sum (V, P) from the series of 1 - mu times it; the plain sum ``series`` within the angle that moments resolve."""
    degree = np.arange(moments.shape[0] - 1.0)[:, np.newaxis]
    below = np.concatenate((np.zeros_like(moments[:1]), moments[:-2]))
    reduced = moments[:-1] - ((degree + 1.0) * moments[1:] + degree * below) / (2.0 * degree + 1.0)
    over = 1.0 / np.maximum(1.0 - cosine, 4.0 / moments.shape[0] ** 2)
    result: Array = over * _series(cosine, reduced) + (1.0 - (1.0 - cosine) * over) * series
    return result
