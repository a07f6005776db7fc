"""Directions of a solution and the kernels of scattering between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.legendre import normalised_legendre
from hcss_twin.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.multiple_scattering.streams import Streams

Array = NDArray[np.float64]


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
    """Order directions as the compiled loops want them."""
    mu = np.concatenate([beams, streams.mu, others])
    weight = np.concatenate([np.zeros_like(beams), streams.weight, np.zeros_like(others)])
    scale = np.where(weight > 0.0, np.sqrt(2.0 * np.pi * mu * weight), 1.0)
    return Directions(mu, weight, scale, beams.size, beams.size + streams.mu.size)


def scattering_kernels(where: Directions, scattering: ScaledScattering, mode: int) -> tuple[Array, Array]:
    """Kernels of scattering per optical depth into the same and into the other hemisphere, scaled.

    w' / (4 pi mu_i mu_j) times the phase function's part in cos(mode azimuth), over 2 for modes from 1.

    Returns
    -------
    same, other : ndarray (V, D, C)
    """
    count = scattering.moments.shape[0]
    value = normalised_legendre(where.mu, mode, count)
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
