"""White noise in Fourier space that evolves in time; small structures evolve faster than large ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, rfftfreq

from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.providers import Problem, ScenarioError

NEAREST_FROM = 2.5
"""Cells per frame from which the nearest time node replaces the interpolation, as of fractal clouds."""

_T = 2


@dataclass(frozen=True)
class Ring:
    """Wavenumbers of one octave, which evolve at the same rate.

    Attributes
    ----------
    number : int
        0 for all structures larger than half the dominant wavelength; each further ring is one octave.
    cell_s : float
        Spacing of the time nodes; infinite if shapes are frozen.
    nearest : bool
        Whether each frame has its own time node instead of an interpolation.
    rows, wavenumbers : ndarray of int64 (M,)
        Rows of ``rfft2`` that the ring reaches, in the order of ``fftfreq``, and their signed wavenumbers.
    inside : ndarray of bool (M, K)
        Which of the first K columns belong to the ring.
    """

    number: int
    cell_s: float
    nearest: bool
    rows: NDArray[np.int64]
    wavenumbers: NDArray[np.int64]
    inside: NDArray[np.bool_]


class EvolvingNoise:
    """Transform of a white Gaussian field on a torus, at any time.

    Each wavenumber blends the independent normals of four time nodes with cubic weights of unit norm
    (:meth:`Lattice.weights`), so that the distribution of the field is the same at all times. Times
    four or more cells apart are independent. A value depends only on seed, wavenumber and time: no frame needs an
    earlier one.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the torus.
    seed : int
        Seed.
    dominant_frequency : float
        In cycles per pixel: structures at or below this frequency evolve in ``evolution_time_s``.
    evolution_time_s : float
        Spacing of the time nodes of those structures; infinity freezes all shapes.
    exponent : float
        Structures half as large evolve ``2**exponent`` times as fast.
    frame_interval_s : float
        Time between frames; 0 if unknown.

    Raises
    ------
    ScenarioError
        If a time is out of range.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        seed: int,
        dominant_frequency: float,
        evolution_time_s: float,
        exponent: float,
        frame_interval_s: float,
    ) -> None:
        _check(evolution_time_s, frame_interval_s)
        self._shape = shape
        self._seed = seed
        self.rings = _rings(shape, dominant_frequency, evolution_time_s, exponent, frame_interval_s)

    def coefficients(self, time_s: float) -> NDArray[np.complex64]:
        """Return ``rfft2`` of a white field (rows, columns // 2 + 1), of unit mean square per wavenumber."""
        rows, columns = self._shape
        noise = np.zeros((rows, columns // 2 + 1), dtype=np.complex64)
        for ring in self.rings:
            width = ring.inside.shape[1]
            blend = np.zeros((ring.rows.size, 2 * width))
            # Real and imaginary parts are neighbours along x.
            x = np.arange(2 * width, dtype=np.int64)
            for node, weight in self._nodes(ring, time_s):
                blend += weight * FractalField.Lattice(self._seed, ring.number).normals(node, ring.wavenumbers, x)
            blend *= math.sqrt(0.5)
            noise[ring.rows, :width] += np.where(ring.inside, blend.view(np.complex128), 0.0).astype(np.complex64)
        _make_hermitian(noise, columns)
        return noise

    def _nodes(self, ring: Ring, time_s: float) -> list[tuple[int, float]]:
        if math.isinf(ring.cell_s):
            return [(0, 1.0)]
        position = time_s / ring.cell_s + FractalField.Lattice(self._seed, ring.number).offset(_T)
        cell = math.floor(position)
        if ring.nearest:
            return [(cell, 1.0)]
        weights = FractalField.Lattice.weights(np.array([position - cell]))[0]
        return [(cell + tap - 1, float(weights[tap])) for tap in range(4)]


def _check(evolution_time_s: float, frame_interval_s: float) -> None:
    problems = []
    if not evolution_time_s > 0.0:
        problems.append(Problem("evolution_time_s", f"{evolution_time_s} given, allowed: greater than 0"))
    if not 0.0 <= frame_interval_s < math.inf:
        problems.append(Problem("frame_interval_s", f"{frame_interval_s} given, allowed: 0 or more and finite"))
    if problems:
        raise ScenarioError(problems, origin="surrogate clouds")


def _rings(
    shape: tuple[int, int], dominant_frequency: float, evolution_time_s: float, exponent: float, frame_interval_s: float
) -> tuple[Ring, ...]:
    along_y, along_x = fftfreq(shape[0]), rfftfreq(shape[1])
    frequency = np.hypot(along_y[:, None], along_x[None, :])
    with np.errstate(divide="ignore"):
        octave = np.floor(np.log2(frequency / dominant_frequency))
    number_of = np.maximum(octave, 0.0).astype(np.int64)
    if math.isinf(evolution_time_s):
        number_of[:] = 0
    wavenumber = np.rint(along_y * shape[0]).astype(np.int64)
    rings = []
    for number in range(int(number_of.max()) + 1):
        inside = number_of == number
        if not inside.any():
            continue
        rows = np.flatnonzero(inside.any(axis=1))
        width = int(np.flatnonzero(inside.any(axis=0))[-1]) + 1
        cell_s = evolution_time_s / 2.0 ** (exponent * number)
        rings.append(
            Ring(
                number, cell_s, frame_interval_s >= NEAREST_FROM * cell_s, rows, wavenumber[rows], inside[rows, :width]
            )
        )
    return tuple(rings)


def _make_hermitian(noise: NDArray[np.complex64], columns: int) -> None:
    """Impose the symmetry of a real field, in place, on the columns that are their own mirror images.

    Averaging with the mirror image would halve the variance; dividing the sum by the root of 2 preserves it.
    """
    for column in (0, columns // 2) if columns % 2 == 0 else (0,):
        values = noise[:, column].astype(np.complex128)
        mirrored = np.conj(np.roll(values[::-1], 1))
        noise[:, column] = (values + mirrored) * math.sqrt(0.5)
