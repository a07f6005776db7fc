"""Kernels of finite reach with a given modulation transfer.

A transfer function known up to half a cycle per pixel belongs to a kernel without end, whose far parts are small: a
pixel could only be measured with the whole scene around it. It is cut where next to nothing lies beyond, so that what
a pixel measures follows from the pixels within its reach, whatever image they are part of.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.fft import idct, idctn

Array = NDArray[np.float64]

NEGLIGIBLE = 1e-6
"""Share of a kernel beyond its reach, where it has one of at most so few pixels:"""

NEAR = 32

SMALL = 2e-3
"""Share beyond the reach of kernels that fall off slowly."""

LONGEST_LINE, LONGEST_PLANE = 2**14, 2**9
"""Pixels that a kernel along one axis, and one of both, may reach; more may lie beyond then."""


def line_kernel(transfer: Callable[[Array], Array]) -> tuple[Array, float]:
    """Return the kernel (2 R + 1,) along one axis, its sum 1, and the share of it that was cut off.

    Parameters
    ----------
    transfer : callable
        Maps frequencies from 0 to 0.5, in cycles per pixel, to a real factor; 1 at frequency 0.
    """

    def quarter(size: int) -> Array:
        half: Array = idct(transfer(_frequencies(size)), type=1)
        return half

    half, cut = _cut(quarter, LONGEST_LINE)
    kernel = np.concatenate((half[:0:-1], half))
    return kernel / kernel.sum(), cut


def plane_kernel(transfer: Callable[[Array, Array], Array]) -> tuple[Array, float]:
    """Return the kernel (2 R + 1, 2 R + 1) of a transfer function of frequencies along y (Y, 1) and x (1, X).

    As :func:`line_kernel`; the function is even along both axes.
    """

    def quarter(size: int) -> Array:
        frequency = _frequencies(size)
        found: Array = idctn(transfer(frequency[:, None], frequency[None, :]), type=1)
        return found

    corner, cut = _cut(quarter, LONGEST_PLANE)
    right = np.concatenate((corner[:, :0:-1], corner), axis=1)
    kernel = np.concatenate((right[:0:-1], right))
    return kernel / kernel.sum(), cut


def _frequencies(size: int) -> Array:
    return np.arange(size + 1) / (2.0 * size)


def _cut(quarter: Callable[[int], Array], longest: int) -> tuple[Array, float]:
    """Cut a kernel, of which the part from its middle on is known on so many pixels, at its reach.

    Twice as many pixels as it reaches are looked at, so that what lies beyond them, which a discrete transform folds
    back, is small as well.
    """
    size = 4 * NEAR
    while True:
        whole = quarter(size)
        beyond = _beyond(whole)
        reach = int(np.argmax(beyond <= NEGLIGIBLE))
        if beyond[reach] > NEGLIGIBLE or reach > NEAR:
            reach = max(NEAR, int(np.argmax(beyond <= SMALL)))
        if 2 * reach <= size or size >= 2 * longest:
            reach = min(reach, longest)
            return whole[tuple(slice(reach + 1) for _ in whole.shape)], float(beyond[reach])
        size *= 2


def _beyond(whole: Array) -> Array:
    """Share of a kernel's absolute values farther from its middle than 0, 1, 2 ... along either axis."""
    count = np.full(whole.shape[0], 2.0)
    count[[0, -1]] = 1.0
    values = np.abs(whole)
    for axis in range(whole.ndim):
        values = values * np.expand_dims(count, tuple(other for other in range(whole.ndim) if other != axis))
    place = np.max(np.indices(whole.shape, sparse=False), axis=0)
    within = np.cumsum(np.bincount(place.ravel(), values.ravel()))
    share: Array = 1.0 - within / within[-1]
    return share
