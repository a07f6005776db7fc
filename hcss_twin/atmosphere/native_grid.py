"""From a provider's own wavenumbers to those the engine asks for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ProviderError

Array = NDArray[np.float64]


def native_nodes(native_cm1: Array, wavenumber_cm1: Array, provider: str) -> NDArray[np.intp]:
    """Return the indices of the native wavenumbers that enclose the requested ones, and no others.

    Parameters
    ----------
    native_cm1 : ndarray (N,)
        Ascending.
    wavenumber_cm1 : ndarray (V,)
        Ascending.
    provider : str
        Who complains.

    Returns
    -------
    ndarray of int (M,)
        Ascending; both neighbours of a wavenumber between two, itself alone where it is native.

    Raises
    ------
    ProviderError
        If the request leaves the native grid.
    """
    low, high = native_cm1[0], native_cm1[-1]
    if wavenumber_cm1[0] < low or wavenumber_cm1[-1] > high:
        raise ProviderError(
            f"{provider}: wavenumbers {wavenumber_cm1[0]:.6g} to {wavenumber_cm1[-1]:.6g} cm-1; allowed {low:g} to "
            f"{high:g} cm-1 ({1e4 / high:.4g} to {1e4 / low:.4g} um)"
        )
    needed = np.zeros(native_cm1.size, dtype=np.bool_)
    needed[np.searchsorted(native_cm1, wavenumber_cm1, side="right") - 1] = True
    needed[np.searchsorted(native_cm1, wavenumber_cm1, side="left")] = True
    return np.flatnonzero(needed)


def from_native(native_cm1: Array, values: Array, wavenumber_cm1: Array) -> Array:
    """Interpolate linearly from native to requested wavenumbers.

    Parameters
    ----------
    native_cm1 : ndarray (N,)
        Those that :func:`native_nodes` chose.
    values : ndarray (P, N)
    wavenumber_cm1 : ndarray (V,)

    Returns
    -------
    ndarray (P, V)
    """
    if np.array_equal(native_cm1, wavenumber_cm1):
        return values
    if native_cm1.size == 1:
        return np.repeat(values, wavenumber_cm1.size, axis=1)
    index = np.clip(np.searchsorted(native_cm1, wavenumber_cm1, side="right") - 1, 0, native_cm1.size - 2)
    fraction = (wavenumber_cm1 - native_cm1[index]) / np.diff(native_cm1)[index]
    result: Array = values[:, index] * (1.0 - fraction) + values[:, index + 1] * fraction
    return result
