"""Iterative amplitude-adjusted Fourier transform of T. Schreiber and A. Schmitz, in two dimensions.

"Improved Surrogate Data for Nonlinearity Tests", Phys. Rev. Lett. 77, 635-638 (1996). Two steps take
turns: one gives the field the wanted Fourier magnitudes and keeps its phases, the other gives it the
wanted amplitudes and keeps their order. V. Venema et al., "Surrogate cloud fields generated with the
iterative amplitude adapted Fourier transform algorithm", Tellus A 58, 104-120 (2006), made clouds so.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft2, rfft2

from hcss_twin.clouds.surrogate.ranks import match_ranks


@dataclass(frozen=True)
class AdjustedSpectrum:
    """State of the iteration after its last spectral step.

    Attributes
    ----------
    coefficients : ndarray of complex (rows, columns // 2 + 1)
        Unnormalised transform of the field whose magnitudes are exact; 0 at wavenumber 0. The surrogate
        proper is ``match_ranks`` of its inverse transform, in which the amplitudes are exact.
    misfit : tuple of float
        One number per iteration: rms difference between the magnitudes found after the amplitude step and
        the wanted ones, over the rms of the wanted ones.
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
    """Iterate amplitudes and spectrum.

    A fixed number of iterations (``tolerance`` 0) makes the result follow a slowly changing start: a
    test of convergence would let neighbouring frames stop at different numbers of iterations.

    Parameters
    ----------
    start : ndarray of complex (rows, columns // 2 + 1)
        Transform (``rfft2``) of the field to start from; its mean does not matter. complex64 makes the
        iteration single precision.
    shape : (int, int)
        Rows and columns of the field.
    amplitudes : ndarray (rows * columns,)
        Wanted amplitudes, ascending.
    magnitude : ndarray (rows, columns // 2 + 1)
        Wanted magnitudes of ``rfft2``; that of wavenumber 0 is not used.
    iterations : int
        Largest number of iterations, 0 or more.
    tolerance : float
        The iteration ends when the misfit has not fallen by more than this fraction of itself.

    Raises
    ------
    ValueError
        If shapes do not fit or the wanted magnitudes are all 0.
    """
    expected = (shape[0], shape[1] // 2 + 1)
    for name, array in (("start", start), ("magnitude", magnitude)):
        if array.shape != expected:
            raise ValueError(f"{name}: shape {array.shape} given, allowed: {expected} for a field of {shape}")
    weight = _multiplicity(shape)
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
        found = np.abs(coefficients)
        found[0, 0] = 0.0
        misfit.append(float(np.sqrt(_sum_of_squares(found - wanted, weight) / total)))
        # A coefficient that is 0 has no phase to keep.
        np.maximum(found, np.finfo(found.dtype).tiny, out=found)
        coefficients *= wanted / found
        if len(misfit) > 1 and misfit[-2] - misfit[-1] < tolerance * misfit[-2]:
            break
    return AdjustedSpectrum(coefficients, tuple(misfit))


def _multiplicity(shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return how often each column of ``rfft2`` stands in the full transform, (columns // 2 + 1,)."""
    columns = shape[1]
    weight = np.full(columns // 2 + 1, 2.0)
    weight[0] = 1.0
    if columns % 2 == 0:
        weight[-1] = 1.0
    return weight


def _sum_of_squares(magnitude: NDArray[Any], weight: NDArray[np.float64]) -> float:
    return float(np.einsum("ij,ij->j", magnitude, magnitude, dtype=np.float64) @ weight)
