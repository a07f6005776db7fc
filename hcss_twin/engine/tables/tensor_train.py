"""Radiance as a function of several variables: a product of small matrices, one for each variable.

A tensor train holds the values of a function at all combinations of nodes of its variables: the value at nodes i, j, k
is the product A[i] B[j] C[k] of a row, matrices and a column. Radiance over the thicknesses of several cloud layers
needs matrices of 4 to 6 rows. They follow from the function along a few lines through chosen nodes (skeleton or cross
approximation), and elements elsewhere measure the error.

I. V. Oseledets, *Tensor-train decomposition*, SIAM J. Sci. Comput. 33, 2295-2317 (2011); S. A. Goreinov, E. E.
Tyrtyshnikov and N. L. Zamarashkin, *A theory of pseudoskeleton approximations*, Linear Algebra Appl. 261 (1997).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

Indices = NDArray[np.intp]
Elements = Callable[[Indices], Array]
"""Maps the nodes (N, L) of elements to their values (N, C)."""

TRIED = 48
"""Number of elements that are computed for each error estimate."""

MOST_PIVOTS = 48

_RANK = 0.1
"""Singular values below this share of the tolerance, relative to the largest, are not divided by."""

MANY_STATES = 4
"""States from which on it pays to look for fewer (:func:`fewest_states`)."""

LOST = 1e-5
"""Largest relative error of fewer states."""


@dataclass(frozen=True)
class TensorTrain:
    """Values of C functions at all nodes of L variables.

    Attributes
    ----------
    cores : tuple of ndarray (C, r, n, s)
        For each variable the matrices (r, s) at its n nodes; s of one is r of the next, and 1 for the last. Where r of
        the first is above 1, there are so many functions for each C.
    """

    cores: tuple[Array, ...]

    def values(self, nodes: Indices) -> Array:
        """Return the values (N, C, r) of all functions at the nodes (N, L) of some elements."""
        row = self.cores[0][:, :, nodes[:, 0]]
        for core, node in zip(self.cores[1:], nodes.T[1:], strict=True):
            row = np.einsum("crns,csnt->crnt", row, core[:, :, node])
        return np.moveaxis(row[..., 0], 2, 0)

    def at(self, nodes: Indices) -> Array:
        """Return the values (N, C) of the first functions."""
        return self.values(nodes)[:, :, 0]

    def of(self, functions: slice | Indices) -> TensorTrain:
        """Return some of the C functions."""
        return TensorTrain(tuple(core[functions] for core in self.cores))

    def mixed(self, weights: Array) -> TensorTrain:
        """Return sums of the functions with weights (m, r), or (C, m, r)."""
        weights = np.broadcast_to(weights, (self.cores[0].shape[0], *weights.shape[-2:]))
        return TensorTrain((np.einsum("cmr,crns->cmns", weights, self.cores[0]), *self.cores[1:]))

    def over(self, other: TensorTrain, where_none: float) -> TensorTrain:
        """Return the ratio to another train of one variable, and where that vanishes, another value."""
        whole = other.cores[0]
        ratio = np.full_like(whole, where_none)
        return TensorTrain((np.divide(self.cores[0], whole, out=ratio, where=whole != 0.0),))

    def times(self, ratio: TensorTrain) -> TensorTrain:
        """Return the product with a ratio of one variable."""
        return TensorTrain((self.cores[0] * ratio.cores[0],))

    def each(self, change: Callable[[int, Array], Array]) -> TensorTrain:
        """Return the train whose values along variable number l are ``change(l, values (n, ...))``, a linear map."""
        cores = (np.moveaxis(change(which, np.moveaxis(core, 2, 0)), 0, 2) for which, core in enumerate(self.cores))
        return TensorTrain(tuple(np.ascontiguousarray(core) for core in cores))

    def rounded(self, tolerance: float) -> TensorTrain:
        """Return a train of the smallest matrices whose values differ by at most a share of their root mean square."""
        cores, elements = list(self.cores), self.cores[0].shape[1] * prod(core.shape[2] for core in self.cores)
        for k in range(len(cores) - 1, 0, -1):  # orthogonal rows, from the last to the second
            core = cores[k]
            lines, rest = np.linalg.qr(core.reshape(*core.shape[:2], -1).swapaxes(1, 2))
            cores[k] = lines.swapaxes(1, 2).reshape(core.shape[0], -1, *core.shape[2:])
            cores[k - 1] = np.einsum("crns,cts->crnt", cores[k - 1], rest)
        for k in range(len(cores) - 1):
            core = cores[k]
            left, strength, right = np.linalg.svd(core.reshape(core.shape[0], -1, core.shape[3]), full_matrices=False)
            # What is left out, by Frobenius' norm, which no element exceeds; the other cores are orthogonal.
            lost = np.sqrt(np.cumsum(strength[:, ::-1] ** 2, axis=1)[:, ::-1])
            allowed = tolerance * lost[:, :1] / np.sqrt(elements)
            rank = max(1, int(np.max(np.count_nonzero(lost > allowed, axis=1))))
            cores[k] = left[:, :, :rank].reshape(*core.shape[:3], rank)
            passed_on = strength[:, :rank, None] * right[:, :rank]
            cores[k + 1] = np.einsum("cts,csnu->ctnu", passed_on, cores[k + 1])
        return TensorTrain(tuple(cores))


def stacked(trains: Sequence[TensorTrain]) -> TensorTrain:
    """Return several trains as the functions of one."""
    if len(trains) == 1:
        return trains[0]
    last = len(trains[0].cores) - 1
    return TensorTrain(tuple(_blocks([train.cores[k] for train in trains], k == last) for k in range(last + 1)))


def _blocks(cores: Sequence[Array], last: bool) -> Array:
    """Put the matrices of several trains below each other, those before the last variable also beside each other."""
    if last:
        return np.concatenate(cores, axis=1)
    rows, columns = (np.cumsum([0, *(core.shape[axis] for core in cores)]).tolist() for axis in (1, 3))
    whole = np.zeros((cores[0].shape[0], rows[-1], cores[0].shape[2], columns[-1]))
    for number, core in enumerate(cores):
        whole[:, rows[number] : rows[number + 1], :, columns[number] : columns[number + 1]] = core
    return whole


def total(trains: Sequence[TensorTrain], factors: Sequence[float]) -> TensorTrain:
    """Return the sum of trains with factors."""
    if not trains[0].cores:
        return trains[0]
    return stacked(trains).mixed(np.array([factors]))


def beside(trains: Sequence[TensorTrain]) -> TensorTrain:
    """Return the functions of several trains, one after another, as those of one."""
    cores = []
    for of_trains in zip(*(train.cores for train in trains), strict=True):
        sizes = np.max([core.shape[1:] for core in of_trains], axis=0)
        cores.append(np.concatenate([_padded(core, sizes) for core in of_trains]))
    return TensorTrain(tuple(cores))


def _padded(core: Array, sizes: Array) -> Array:
    return np.pad(core, ((0, 0), *((0, size - own) for size, own in zip(sizes, core.shape[1:], strict=True))))


def cross(
    elements: Elements,
    sizes: Sequence[int],
    error: Callable[[Array, Array], Array],
    tolerance: float,
    near: TensorTrain | None = None,
) -> tuple[TensorTrain, float]:
    """Return the train of a function from its values along some lines.

    Lines run through the first, the middle and the last nodes of all variables, and then through the worst of the
    elements that were tried, until all that are tried next are within the tolerance.

    Parameters
    ----------
    elements : callable
    sizes : sequence of int (L,)
        Numbers of nodes.
    error : callable
        Relative errors (N,) of guessed values (N, C), beside exact ones.
    near : TensorTrain, optional
        A function that differs little: only the difference is approximated.

    Returns
    -------
    TensorTrain
        Of the function, or of its difference.
    float
        The largest error among the elements that were tried last; 0 for one variable.
    """
    last = np.array(sizes) - 1
    starts = (0, 1, 2) if near is None else (0, 2)
    pivots = list(dict.fromkeys(tuple((start * last // 2).tolist()) for start in starts))
    start = 0
    while True:
        train = _skeleton(elements, sizes, pivots, near, _RANK * tolerance)
        if len(sizes) == 1:
            return train, 0.0
        tried, start = _elsewhere(sizes, pivots, start), start + TRIED
        exact = elements(tried)
        errors = error(train.at(tried) if near is None else near.at(tried) + train.at(tried), exact)
        worst = int(np.argmax(errors))
        if errors[worst] <= tolerance or len(pivots) == MOST_PIVOTS:
            return train, float(errors[worst])
        pivots.append(tuple(tried[worst].tolist()))


def _elsewhere(sizes: Sequence[int], pivots: Sequence[tuple[int, ...]], start: int) -> Indices:
    """Return elements (N, L) on no line through the pivots, all of them where they are few; else from everywhere."""
    free = [
        np.setdiff1d(np.arange(size), of_axis) for size, of_axis in zip(sizes, zip(*pivots, strict=True), strict=True)
    ]
    counts = [nodes.size for nodes in free]
    if 0 in counts:
        return spread(sizes, start, TRIED)
    few = prod(counts) <= 2 * TRIED
    which = np.array(list(np.ndindex(*counts))) if few else spread(counts, start, TRIED)
    return np.stack([nodes[of_axis] for nodes, of_axis in zip(free, which.T, strict=True)], axis=1)


def spread(sizes: Sequence[int], start: int, count: int) -> Indices:
    """Return so many elements (N, L), spread evenly over all, from a sequence that does not repeat itself."""
    elements: Indices = (evenly(len(sizes), start, count) * np.array(sizes)).astype(np.intp)
    return elements


def evenly(dimensions: int, start: int, count: int) -> Array:
    """Return so many points (N, L) of a cube of side 1, spread evenly, of a sequence that does not repeat itself.

    A Kronecker sequence of powers of the root of x^(L + 1) = x + 1: M. Roberts, *The unreasonable effectiveness of
    quasirandom sequences* (2018).
    """
    root = 2.0
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (dimensions + 1))
    number = np.arange(start + 1, start + 1 + count)
    points: Array = np.mod(0.5 + number[:, None] * root ** -np.arange(1.0, dimensions + 1), 1.0)
    return points


def _inverse(matrices: Array, smallest: float) -> Array:
    """Return the pseudo-inverses of matrices (C, m, n) of any size; 0 for those that vanish."""
    size = np.max(np.abs(matrices), axis=(1, 2), keepdims=True)
    lit = size > np.finfo(float).tiny / np.finfo(float).eps
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=lit)
    inverse: Array = np.linalg.pinv(matrices * scale, rcond=smallest) * scale
    return inverse


def _skeleton(
    elements: Elements,
    sizes: Sequence[int],
    pivots: Sequence[tuple[int, ...]],
    near: TensorTrain | None,
    smallest: float,
) -> TensorTrain:
    """Return the train that is exact along the lines through the pivots."""

    def lines(before: Sequence[tuple[int, ...]], size: int, after: Sequence[tuple[int, ...]]) -> Array:
        """Values (C, before, nodes, after) of elements with any node of a variable."""
        nodes = np.array([(*left, node, *right) for left, node, right in product(before, range(size), after)])
        values = elements(nodes) if near is None else elements(nodes) - near.at(nodes)
        return np.moveaxis(values.reshape(len(before), size, len(after), -1), -1, 0)

    before: list[tuple[int, ...]] = [()]
    cores = list[Array]()
    inverse: Array | None = None
    for k, size in enumerate(sizes):
        after = list(dict.fromkeys(pivot[k + 1 :] for pivot in pivots))
        through = lines(before, size, after)
        cores.append(through if inverse is None else np.einsum("crs,csnt->crnt", inverse, through))
        rows = list(dict.fromkeys(pivot[: k + 1] for pivot in pivots))
        centre = through[:, [before.index(row[:-1]) for row in rows], [row[-1] for row in rows]]
        inverse, before = _inverse(centre, smallest), rows
    return TensorTrain(tuple(cores))


def fewest_states(every: Array, size: Array, lost: float) -> tuple[Array, Array]:
    """Return the fewest states (R, V) and weights (S, R) whose combinations equal tables (S, V) within an error.

    Radiance is nearly a sum of few products of a function of the cloud and one of the direction: of the 16 tables
    toward a frame of a camera 4 or 5 combinations tell all of them within 1e-5. They are the singular vectors of the
    table of all tables.

    Parameters
    ----------
    size : ndarray (S, V) or (V,)
        To which the error ``lost`` is relative.
    """
    largest = np.max(np.abs(every), axis=0)
    scale = np.where(largest > 0.0, largest, 1.0)
    of_table, strength, of_column = np.linalg.svd(every / scale, full_matrices=False)
    for count in range(1, strength.size + 1):
        weights, states = of_table[:, :count], strength[:count, None] * of_column[:count] * scale
        if np.max(np.abs(weights @ states - every) / size) <= lost:
            break
    return weights, states
