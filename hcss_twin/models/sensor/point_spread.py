"""Point-spread functions: kernels of finite reach from modulation transfer functions (MTF) or from a file.

An MTF known up to half a cycle per pixel corresponds to an infinite kernel with small tails, so that a pixel would
depend on the whole scene. The kernel is truncated where its tails are negligible, so that a pixel depends only on
pixels within its reach, whatever the image.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.fft import dctn, idct, idctn

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.reading import Reading

NEAR = 32
"""Reach in pixels within which a kernel should be complete except for a fraction ``NEGLIGIBLE``."""

NEGLIGIBLE, SMALL = 1e-6, 2e-3
"""Share of a kernel beyond its reach: of kernels that end within ``NEAR`` pixels, and of slowly decreasing planes."""

EDGE = 1.5e-4
"""Error of a slowly decreasing kernel along one axis at a straight edge, relative to the height of the edge.

The tails of such a kernel alternate: they belong to frequencies near half a cycle per pixel, where its MTF ends, and
nearly cancel in any image without a pattern of that frequency.
"""

LEAST = 7
"""Smallest reach in pixels of a slowly decreasing kernel."""

LONGEST_LINE, LONGEST_PLANE = 2**14, 2**9
"""Largest reach in pixels of a kernel along one axis and along both; what is beyond may then exceed its limit."""

LARGEST = 1025
"""Largest number of rows or columns of a kernel from a file."""


def line_kernel(transfer: Callable[[Array], Array]) -> tuple[Array, float]:
    """Return the kernel (2 R + 1,) along one axis, normalised to sum 1, and the truncated fraction.

    Parameters
    ----------
    transfer : callable
        Maps frequencies from 0 to 0.5, in cycles per pixel, to a real factor; 1 at frequency 0.
    """
    half, cut = _cut(lambda size: idct(transfer(_frequencies(size)), type=1), LONGEST_LINE, _edge_error, EDGE)
    kernel = np.concatenate((half[:0:-1], half))
    return kernel / kernel.sum(), cut


def plane_kernel(transfer: Callable[[Array, Array], Array]) -> tuple[Array, float]:
    """Return the kernel (2 R + 1, 2 R + 1) of a transfer function of frequencies along y (Y, 1) and x (1, X).

    As :func:`line_kernel`; the function is even along both axes.
    """

    def quarter(size: int) -> Array:
        frequency = _frequencies(size)
        kernel: Array = idctn(transfer(frequency[:, None], frequency[None, :]), type=1)
        return kernel

    corner, cut = _cut(quarter, LONGEST_PLANE, _beyond, SMALL)
    right = np.concatenate((corner[:, :0:-1], corner), axis=1)
    kernel = np.concatenate((right[:0:-1], right))
    return kernel / kernel.sum(), cut


def _frequencies(size: int) -> Array:
    return np.arange(size + 1) / (2.0 * size)


def _cut(
    quarter: Callable[[int], Array], longest: int, lost_beyond: Callable[[Array], Array], allowed: float
) -> tuple[Array, float]:
    """Truncate a kernel at its reach, and return the share of its absolute values that is beyond.

    The transform covers at least twice the reach, because a discrete transform folds back what lies beyond it.

    Parameters
    ----------
    quarter : callable
        Computes one quadrant on a given number of pixels.
    lost_beyond : callable
        Maps a quadrant to the error of a kernel that ends at each distance from its middle, if it decreases slowly.
    allowed : float
        Its largest value.
    """
    size = 4 * NEAR
    while True:
        whole = quarter(size)
        beyond = _beyond(whole)
        reach = int(np.argmax(beyond <= NEGLIGIBLE))
        if beyond[reach] > NEGLIGIBLE or reach > NEAR:
            reach = max(LEAST, int(np.argmax(lost_beyond(whole) <= allowed)))
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
    distance = np.max(np.indices(whole.shape, sparse=False), axis=0)
    within = np.cumsum(np.bincount(distance.ravel(), values.ravel()))
    share: Array = 1.0 - within / within[-1]
    return share


def _edge_error(half: Array) -> Array:
    """Largest sum of the values from any distance beyond 0, 1, 2 ... on, along one side: what a step there changes."""
    sums = np.abs(np.append(np.cumsum(half[::-1])[::-1], 0.0))
    largest: Array = np.maximum.accumulate(sums[::-1])[::-1][1:]
    return largest


def gaussian_mtf(frequency: Array, sigma_pixels: float) -> Array:
    """MTF of a Gaussian spread function, exp(-2 (pi sigma f)^2), f in cycles per pixel and sigma in pixels."""
    result: Array = np.exp(-2.0 * (np.pi * sigma_pixels * frequency) ** 2)
    return result


def airy_mtf(frequency: Array, cutoff: float) -> Array:
    """MTF of diffraction at a circular aperture without obscuration; frequency and cut-off in the same unit.

    (2 / pi) (arccos u - u sqrt(1 - u^2)) with u = f / cutoff, 0 from the cut-off on: the overlap of two displaced
    circles (Goodman, Introduction to Fourier Optics, section 6.3).
    """
    u = np.minimum(frequency / cutoff, 1.0)
    result: Array = (2.0 / np.pi) * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
    return result


def read_kernel(path: Path) -> Array:
    """Read a point-spread function sampled at the image pixels from a text file, and normalise it to sum 1.

    Each line is a row of numbers, separated by commas or blanks, with ``#`` comments. The first line is the
    southernmost row, as in the image; the point is in the middle.

    Returns
    -------
    ndarray (K, L)
        K and L odd.

    Raises
    ------
    CatalogError
        If the file is malformed, has an even number of rows or columns, or its numbers sum to 0.
    """
    rows: list[list[float]] = []
    with Reading(path, CatalogError, "not a text file"):
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    for number, line in enumerate(lines, start=1):
        plain = line.partition("#")[0].replace(",", " ").split()
        try:
            values = [float(word) for word in plain]
        except ValueError as error:
            raise CatalogError(f"{path}, line {number}: {error}") from error
        if values and rows and len(values) != len(rows[0]):
            raise CatalogError(f"{path}, line {number}: {len(values)} numbers, the first row has {len(rows[0])}")
        if values:
            rows.append(values)
    kernel = np.array(rows, dtype=np.float64)
    if kernel.ndim != 2 or any(size % 2 == 0 or size > LARGEST for size in kernel.shape):
        size = " x ".join(map(str, kernel.shape)) if kernel.ndim == 2 else "no rows"
        raise CatalogError(f"{path}: {size}; allowed: an odd number of rows and of columns, at most {LARGEST}")
    total = float(kernel.sum())
    if not np.all(np.isfinite(kernel)) or not total > 1e-6 * float(np.abs(kernel).max()):
        raise CatalogError(f"{path}: the numbers sum to {total:g}; allowed: finite numbers with a sum above 0")
    result: Array = kernel / total
    return result


def separated(kernels: Sequence[Array], most: int) -> tuple[list[Array], list[Array]] | None:
    """Return kernels (K,) along columns and (L,) along rows whose products sum to the convolution of planes (K, L).

    Truncated singular value decompositions: the absolute values of the difference sum to less than ``NEGLIGIBLE``, so
    that no pixel is off by more than this share of the largest radiance. None if more than ``most`` numbers are needed.
    """
    down, across = [np.ones(1)], [np.ones(1)]
    for kernel in kernels:
        if sum(kernel.shape) > most:
            return None
        u, size, v = np.linalg.svd(kernel, full_matrices=False)
        terms = 1
        while np.abs(kernel - (u[:, :terms] * size[:terms]) @ v[:terms]).sum() > NEGLIGIBLE:
            terms += 1
        down = [np.convolve(one, u[:, term] * size[term]) for one in down for term in range(terms)]
        across = [np.convolve(one, v[term]) for one in across for term in range(terms)]
    return (down, across) if sum(kernel.size for kernel in (*down, *across)) <= most else None


def mirrored_transfer(kernels: Sequence[Array], shape: tuple[int, int]) -> Array:
    """Return the factors (Y, X) of an image's cosine transform that convolve it, mirrored at its edges.

    Parameters
    ----------
    kernels : sequence of ndarray (K, L)
        Even along both axes; applied in turn.
    shape : (int, int)
        Rows and columns of the image.
    """
    transfer: Array = np.ones(shape)
    for kernel in kernels:
        period = np.zeros((2 * shape[0], 2 * shape[1]))
        places = ((np.arange(n) - n // 2) % (2 * size) for n, size in zip(kernel.shape, shape, strict=True))
        np.add.at(period, np.ix_(*places), kernel)
        transfer *= dctn(period[: shape[0] + 1, : shape[1] + 1], type=1)[:-1, :-1]
    return transfer


def convolve(image: Array, kernel: Array) -> Array:
    """Return the convolution of an image (Y, X), mirrored at its edges, with a kernel (K, L), by FFT.

    A point of the scene becomes the kernel, in the kernel's own orientation.
    """
    from scipy.signal import oaconvolve  # takes .3 s to import; few point spreads need it

    reach_y, reach_x = (size // 2 for size in kernel.shape)
    wide = np.pad(image, ((reach_y, reach_y), (reach_x, reach_x)), mode="symmetric")
    result: Array = oaconvolve(wide, kernel, mode="valid")
    return result
