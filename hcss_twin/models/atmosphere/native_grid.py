"""Interpolation from a provider's native wavenumbers to the requested ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError


def native_nodes(native_cm1: Array, wavenumber_cm1: Array, provider: str) -> NDArray[np.intp]:
    """Return the indices (M,) of the native wavenumbers that enclose the requested ones, and no others.

    A native wavenumber needs only itself, any other its two neighbours; both grids ascend. Raises ProviderError, which
    names ``provider``, if the request leaves the native grid.
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


@dataclass(frozen=True)
class NativeWindow:
    """Native wavenumbers that enclose a request, and weights for linear interpolation to it.

    Attributes
    ----------
    nodes : ndarray of int (M,)
        Indices of the native wavenumbers, from :func:`native_nodes`.
    lower : ndarray of int (V,)
        Index into ``nodes`` of the lower neighbour of each requested wavenumber.
    fraction : ndarray (V,)
        Weight of the upper neighbour.
    is_native : bool
        Whether all requested wavenumbers are native.
    """

    nodes: NDArray[np.intp]
    lower: NDArray[np.intp]
    fraction: Array
    is_native: bool

    def interpolate(self, values: Array) -> Array:
        """Interpolate from the native wavenumbers (P, M) to those requested, (P, V)."""
        if self.is_native:
            return values
        result: Array = np.take(values, self.lower, axis=1)
        # Most are native, except at band edges.
        between = np.flatnonzero(self.fraction)
        above, share = self.lower[between] + 1, self.fraction[between]
        result[:, between] = result[:, between] * (1.0 - share) + values[:, above] * share
        return result


def native_window(native_cm1: Array, wavenumber_cm1: Array, provider: str) -> NativeWindow:
    """Return the native wavenumbers that a request needs; arguments and errors as for :func:`native_nodes`."""
    nodes = native_nodes(native_cm1, wavenumber_cm1, provider)
    some = native_cm1[nodes]
    if np.array_equal(some, wavenumber_cm1):
        return NativeWindow(nodes, np.arange(nodes.size), np.zeros(nodes.size), is_native=True)
    lower = np.searchsorted(some, wavenumber_cm1, side="right") - 1
    step = np.where(lower + 1 < some.size, some[np.minimum(lower + 1, some.size - 1)] - some[lower], 1.0)
    return NativeWindow(nodes, lower, (wavenumber_cm1 - some[lower]) / step, is_native=False)
