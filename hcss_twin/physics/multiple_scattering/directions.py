"""Directions of a solution: Gauss streams of one hemisphere, extra directions, and scattering between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.physics.quadrature import gauss_legendre


@dataclass(frozen=True)
class Streams:
    """Quadrature over the cosines of zenith angles of one hemisphere.

    The flux of radiance I is ``2 pi sum(mu weight I)``, its mean over the hemisphere ``sum(weight I)``.

    Attributes
    ----------
    mu : ndarray (N,)
        Cosines, ascending, inside (0, 1).
    weight : ndarray (N,)
        Weights; their sum is 1.
    """

    mu: Array
    weight: Array


def gauss_streams(count: int) -> Streams:
    """Gauss-Legendre quadrature on (0, 1), exact for polynomials of degree 2 ``count`` - 1.

    One quadrature per hemisphere ("double Gauss") copes with radiance that jumps at the horizon; J. B. Sykes, Mon. Not.
    R. Astron. Soc. 111, 377 (1951).

    Raises
    ------
    ValueError
        If ``count`` is not a whole number of at least 1.
    """
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise ValueError(f"streams {count}: allowed whole numbers from 1; closest is {_closest(count)}")
    node, weight = gauss_legendre(int(count))
    return Streams(0.5 * (1.0 + node), 0.5 * weight)


def _closest(count: object) -> int:
    if isinstance(count, float) and np.isfinite(count):
        return max(1, round(count))
    return 1


def normalised_legendre(mu: Array, order: int, degrees: int) -> Array:
    """Evaluate sqrt((l - m)! / (l + m)!) P_l^m(mu), without the sign (-1)^m.

    By the addition theorem P_l(cos(angle between two directions)) is the sum over m of (2 - delta_m0)
    times the product of these functions of both cosines times cos(m azimuth difference).

    Parameters
    ----------
    mu : ndarray (D,)
        Cosines in [-1, 1].
    order : int
        m, 0 or more.
    degrees : int
        Functions of degree 0 to ``degrees`` - 1 are returned; those below m are 0.

    Returns
    -------
    ndarray (degrees, D)

    References
    ----------
    Recurrence over the degree at constant order: J. V. Dave and B. H. Armstrong, J. Quant. Spectrosc. Radiat. Transfer
    10, 557 (1970); stable for all l, because |value| <= 1.
    """
    m = order
    result = np.zeros((degrees, mu.size))
    if m >= degrees:
        return result
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    first = np.ones_like(mu)
    for k in range(1, m + 1):
        first = first * sine * np.sqrt((2 * k - 1) / (2 * k))
    result[m] = first
    if m + 1 < degrees:
        result[m + 1] = np.sqrt(2 * m + 1) * mu * first
    for l in range(m + 1, degrees - 1):  # noqa: E741
        before = np.sqrt(l * l - m * m) * result[l - 1]
        result[l + 1] = ((2 * l + 1) * mu * result[l] - before) / np.sqrt((l + 1) ** 2 - m * m)
    return result


@lru_cache(maxsize=512)
def _legendre(mu: bytes, order: int, degrees: int) -> Array:
    """Return :func:`normalised_legendre`: layers, levels and wavenumbers of a scene have the same few directions."""
    values = normalised_legendre(np.frombuffer(mu, dtype=np.float64), order, degrees)
    values.flags.writeable = False
    return values


@dataclass(frozen=True)
class Directions:
    """Beams, streams and other extra directions, D in all, in this order.

    Attributes
    ----------
    mu, weight, scale : ndarray (D,)
        Cosines; weights, 0 for beams and extras; sqrt(2 pi mu weight), 1 for beams and extras.
    beams : int
        Extra directions along which light also enters.
    columns : int
        C, beams and streams: all directions along which light enters.
    """

    mu: Array
    weight: Array
    scale: Array
    beams: int
    columns: int


def directions(beams: Array, streams: Streams, others: Array) -> Directions:
    """Put directions in the order that the compiled loops expect."""
    mu = np.concatenate([beams, streams.mu, others])
    weight = np.concatenate([np.zeros_like(beams), streams.weight, np.zeros_like(others)])
    scale = np.where(weight > 0.0, np.sqrt(2.0 * np.pi * mu * weight), 1.0)
    return Directions(mu, weight, scale, beams.size, beams.size + streams.mu.size)


def scattering_kernels(where: Directions, scattering: ScaledScattering, mode: int) -> tuple[Array, Array]:
    """Return scaled kernels of scattering per optical depth into the same and into the other hemisphere.

    w' / (4 pi mu_i mu_j) times the phase function's coefficient of cos(mode azimuth), halved for modes from 1 on.

    Returns
    -------
    same, other : ndarray (V, D, C)
    """
    count = scattering.moments.shape[0]
    value = _legendre(where.mu.tobytes(), mode, count)
    series = (2 * np.arange(count) + 1)[:, np.newaxis] * scattering.moments
    factor = where.scale / where.mu
    scaled = value * factor
    # Products of the functions in both directions, (L, D * C).
    product = (scaled[:, :, np.newaxis] * scaled[:, np.newaxis, : where.columns]).reshape(count, -1)
    even = series[mode::2].T @ product[mode::2]
    odd = series[mode + 1 :: 2].T @ product[mode + 1 :: 2]
    strength = (scattering.albedo / (4.0 * np.pi))[:, np.newaxis]
    shape = (-1, where.mu.size, where.columns)
    return (strength * (even + odd)).reshape(shape), (strength * (even - odd)).reshape(shape)
