"""Layers that one chain of doublings passes through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Thicknesses that differ by less than this share are one.
SAME = 1e-12


@dataclass(frozen=True)
class Chains:
    """Layers in the order in which chains pass through them: thin to thick, chain after chain.

    Attributes
    ----------
    cell : ndarray of int (n,)
        Position of each layer in the flattened (T, V).
    column : ndarray of int (n,)
        Its row of kernels: its place among the wavenumbers that have layers.
    thickness : ndarray (n,)
        Its optical thickness.
    doublings : ndarray of int (n,)
        From the layer before in its chain; 0 for the first.
    first : ndarray of int (chains + 1,)
        Where chains begin, and n.
    wavenumber : ndarray of int
        Those that have layers, ascending.
    """

    cell: NDArray[np.int64]
    column: NDArray[np.int64]
    thickness: Array
    doublings: NDArray[np.int64]
    first: NDArray[np.int64]
    wavenumber: NDArray[np.int64]


def chains(thickness: Array, wanted: NDArray[np.bool_]) -> Chains:
    """Sort layers into chains: of one wavenumber, and thicker than another by a power of 2.

    Thicknesses are written m 2^e, m from 0.5 to 1: a chain has one m, to ``SAME`` from one to the next.

    Parameters
    ----------
    thickness : ndarray (T, V)
        Optical thickness.
    wanted : ndarray of bool (T, V)
        Layers to be solved.
    """
    cell = np.flatnonzero(wanted)
    tau = thickness.ravel()[cell]
    wavenumber, column = np.unique(cell % thickness.shape[1], return_inverse=True)
    m, e = np.frexp(tau)
    # Just below a power of 2 is a power of 2.
    below = m > 1.0 - SAME
    m, e = np.where(below, 0.5 * m, m), np.where(below, e + 1, e)
    order = np.lexsort((m, column))
    apart = (np.diff(column[order]) > 0) | (np.diff(m[order]) > SAME * m[order][1:])
    chain = np.empty(cell.size, dtype=np.int64)
    chain[order] = np.concatenate([np.zeros(min(cell.size, 1), dtype=np.int64), np.cumsum(apart)])
    order = np.lexsort((e, chain))
    chain, e = chain[order], e[order].astype(np.int64)
    begins = np.diff(chain, prepend=-1) > 0
    doublings = np.where(begins, 0, np.diff(e, prepend=0))
    first = np.append(np.flatnonzero(begins), cell.size)
    return Chains(cell[order], column[order], tau[order], doublings, first, wavenumber)
