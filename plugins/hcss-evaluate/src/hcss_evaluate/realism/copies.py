"""Copies: simulated patches that are pieces of a real image, moved or mirrored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from hcss_twin.providers import Array

_FLATTEST = 1e-6
"""Places whose variance is below this share of the image's are skipped: rounding decides their correlation."""


class Example:
    """A real image that patches are searched in.

    Parameters
    ----------
    field : ndarray (rows, columns)
        Any unit; missing values (NaN) count as the mean.
    size : int
        Side of the patches.
    """

    def __init__(self, field: Array, size: int) -> None:
        deviation = np.nan_to_num(field - np.nanmean(field)).astype(np.float64)
        self.size = size
        self.places = (field.shape[0] - size + 1, field.shape[1] - size + 1)
        self.shape = tuple(next_fast_len(length, real=True) for length in field.shape)
        self.waves = rfft2(deviation.astype(np.float32), self.shape)
        sums, squares = self._box_sums(deviation), self._box_sums(deviation**2)
        energy = squares - sums**2 / size**2
        floor = _FLATTEST * size**2 * deviation.var()
        self.scale = np.where(energy > floor, 1.0 / np.sqrt(np.maximum(energy, floor or 1.0)), 0.0)

    def _box_sums(self, values: Array) -> Array:
        """Return the sum over the patch at each place."""
        total = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
        n = self.size
        boxes: Array = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]
        return boxes

    def largest_correlation(self, patch: Array) -> float:
        """Return the largest correlation of a patch (n, n) at any place, as it is or mirrored along either axis."""
        deviation = (patch - patch.mean()).astype(np.float32)
        norm = float(np.linalg.norm(deviation))
        flips = np.stack([deviation, deviation[::-1], deviation[:, ::-1], deviation[::-1, ::-1]])
        products = irfft2(self.waves * np.conj(rfft2(flips, self.shape)), self.shape)
        return float((products[:, : self.places[0], : self.places[1]] * self.scale).max()) / norm


def largest_correlations(patches: Array, examples: Sequence[Example]) -> Array:
    """Return the largest correlation (P,) of each patch (P, n, n) with any example, moved or mirrored."""
    return np.array([max(example.largest_correlation(patch) for example in examples) for patch in patches])
