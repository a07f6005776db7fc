"""Iterative amplitude-adjusted Fourier transform (IAAFT) in two dimensions.

T. Schreiber and A. Schmitz, "Improved Surrogate Data for Nonlinearity Tests", Phys. Rev. Lett. 77, 635-638 (1996). Two
steps alternate: one imposes the template's Fourier magnitudes and keeps the phases of the field, the other imposes the
template's amplitudes and keeps their order. V. Venema et al., "Surrogate cloud fields generated with the iterative
amplitude adapted Fourier transform algorithm", Tellus A 58, 104-120 (2006), applied it to clouds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft2, rfft2

from hcss_twin.core.kernels import kernel

# Mean number of values per bin: few enough for insertion sort.
_PER_BIN = 4
_FEWEST_BINS, _MAX_BINS = 1 << 10, 1 << 20

# With more values in a bin (many equal values, a far outlier), insertion sort is slower than a general sort.
_FULLEST_BIN = 512


def ascending_order(values: NDArray[Any]) -> NDArray[np.int64]:
    """Return the flat indices (N,) that sort finite ``values`` (any shape); equal values keep the order of indices.

    Equivalent to ``np.argsort(values, axis=None, kind="stable")``, but several times faster. Fields from a Fourier
    synthesis have bell-shaped histograms: sorting into bins of equal width (one pass to count, one to place) leaves few
    values per bin.
    """
    flat = np.ascontiguousarray(values).ravel()
    if flat.size == 0:
        return np.zeros(0, dtype=np.int64)
    low, high = float(flat.min()), float(flat.max())
    bins = min(max(1 << (flat.size // _PER_BIN).bit_length(), _FEWEST_BINS), _MAX_BINS)
    span = high - low
    # The scale of a subnormal span would overflow, as would the span of the largest numbers.
    if np.finfo(np.float64).tiny * bins < span < np.inf:
        bin_of, ends = _count(flat, low, bins / span, bins)
        if int(np.diff(ends, prepend=0).max()) <= _FULLEST_BIN:
            return np.asarray(_place(flat, bin_of, ends), dtype=np.int64)
    return np.argsort(flat, kind="stable")


def match_ranks(field: NDArray[Any], amplitudes: NDArray[Any]) -> NDArray[Any]:
    """Assign amplitudes to pixels by rank: the smallest value gets ``amplitudes[0]``, and so on.

    Parameters
    ----------
    field : ndarray of float32 or float64, any shape
        Finite values; equal ones are ranked by their flat index.
    amplitudes : ndarray (field.size,)
        Ascending.

    Returns
    -------
    ndarray, shape of ``field`` and type of ``amplitudes``
        A permutation of ``amplitudes``.

    Raises
    ------
    ValueError
        If the numbers of pixels and amplitudes differ.
    """
    if amplitudes.shape != (field.size,):
        raise ValueError(f"amplitudes: shape {amplitudes.shape} given, allowed: ({field.size},)")
    matched = np.empty(field.size, dtype=amplitudes.dtype)
    matched[ascending_order(field)] = amplitudes
    return matched.reshape(field.shape)


@kernel()
def _count(values: Any, low: float, scale: float, bins: int) -> Any:
    """Return the bin of each value (N,) and the cumulative number of values up to and including each bin (bins,)."""
    bin_of = np.empty(values.size, np.int32)
    ends = np.zeros(bins, np.int64)
    for i in range(values.size):
        b = min(int((np.float64(values[i]) - low) * scale), bins - 1)
        bin_of[i] = b
        ends[b] += 1
    for b in range(1, bins):
        ends[b] += ends[b - 1]
    return bin_of, ends


@kernel()
def _place(values: Any, bin_of: Any, ends: Any) -> Any:
    """Place the values in their bins, sort each bin, and return the sorting indices (N,)."""
    order = np.empty(values.size, np.int64)
    keys = np.empty_like(values)
    next_free = ends.copy()
    # From last to first, so that each bin fills from its end and keeps the order of the indices.
    for i in range(values.size - 1, -1, -1):
        next_free[bin_of[i]] -= 1
        free = next_free[bin_of[i]]
        order[free] = i
        keys[free] = values[i]
    start = 0
    for b in range(ends.size):
        for i in range(start + 1, ends[b]):
            key, index = keys[i], order[i]
            j = i - 1
            while j >= start and keys[j] > key:
                keys[j + 1] = keys[j]
                order[j + 1] = order[j]
                j -= 1
            keys[j + 1] = key
            order[j + 1] = index
        start = ends[b]
    return order


@dataclass(frozen=True)
class AdjustedSpectrum:
    """State of the iteration after its last spectral step.

    Attributes
    ----------
    coefficients : ndarray of complex (rows, columns // 2 + 1)
        Unnormalised transform of the field with exact magnitudes; 0 at wavenumber 0. The surrogate is ``match_ranks``
        of its inverse transform, which has exact amplitudes.
    misfit : tuple of float
        One number per iteration: rms difference between the magnitudes after the amplitude step and those of the
        template, divided by the rms of the latter.
    """

    coefficients: NDArray[Any]
    misfit: tuple[float, ...]


def adjust_amplitudes(
    start: NDArray[Any],
    shape: tuple[int, int],
    amplitudes: NDArray[Any],
    magnitude: NDArray[Any],
    iterations: int,
    tolerance: float = 0.0,
) -> AdjustedSpectrum:
    """Iteratively adjust amplitudes and spectrum.

    With a fixed number of iterations (``tolerance`` 0), the result varies smoothly with the start; a convergence test
    would stop neighbouring frames after different numbers of iterations.

    Parameters
    ----------
    start : ndarray of complex (rows, columns // 2 + 1)
        Transform (``rfft2``) of the field to start from; its mean is not used. With complex64, the iteration is in
        single precision.
    shape : (int, int)
        Rows and columns of the field.
    amplitudes : ndarray (rows * columns,)
        Of the template, ascending.
    magnitude : ndarray (rows, columns // 2 + 1)
        Of the template's ``rfft2``; the value at wavenumber 0 is not used.
    iterations : int
        Maximum number of iterations, 0 or more.
    tolerance : float
        The iteration ends when the misfit falls by less than this fraction of itself.

    Raises
    ------
    ValueError
        If shapes do not fit or the magnitudes are all 0.
    """
    expected = (shape[0], shape[1] // 2 + 1)
    for name, array in (("start", start), ("magnitude", magnitude)):
        if array.shape != expected:
            raise ValueError(f"{name}: shape {array.shape} given, allowed: {expected} for a field of {shape}")
    # Multiplicity of each rfft2 column in the full transform.
    weight = np.full(shape[1] // 2 + 1, 2.0)
    weight[0] = 1.0
    if shape[1] % 2 == 0:
        weight[-1] = 1.0
    wanted = np.array(magnitude, dtype=start.real.dtype)
    wanted[0, 0] = 0.0
    total = _sum_of_squares(wanted, weight)
    if total == 0.0:
        raise ValueError("magnitude: all 0 given, allowed: a field that varies")
    values = np.asarray(amplitudes, dtype=wanted.dtype)
    coefficients = np.array(start)
    coefficients[0, 0] = 0.0
    misfit: list[float] = []
    for _ in range(iterations):
        adjusted = match_ranks(irfft2(coefficients, s=shape), values)
        coefficients = rfft2(adjusted)
        modulus = np.abs(coefficients)
        modulus[0, 0] = 0.0
        misfit.append(float(np.sqrt(_sum_of_squares(modulus - wanted, weight) / total)))
        # A coefficient of 0 has no phase and stays 0.
        np.maximum(modulus, np.finfo(modulus.dtype).tiny, out=modulus)
        coefficients *= wanted / modulus
        if len(misfit) > 1 and misfit[-2] - misfit[-1] < tolerance * misfit[-2]:
            break
    return AdjustedSpectrum(coefficients, tuple(misfit))


def _sum_of_squares(magnitude: NDArray[Any], weight: NDArray[np.float64]) -> float:
    return float(np.einsum("ij,ij->j", magnitude, magnitude, dtype=np.float64) @ weight)
