"""The middle of a sky, as large as the example, gets the distribution of the example.

By chance it has other clouds: it shows a few patches. Scores are mapped to those with the same rank in a normal
distribution. The middle and the seed decide, not the image, so that all windows and pixel sizes show one sky.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from hcss_skies.example import MAX_SCORE
from hcss_twin.providers import Array

# Samples along a side of the middle, ranks that are mapped, and the largest score of a rank.
_SAMPLES, _RANKS, _RANKED = 128, 25, 3.0

Table = NDArray[np.float32]


def ranked(expected: Table, shape: tuple[int, ...], blend: Callable[[Table, Array, Array, Table], None]) -> Table:
    """Return tables (N, 2) of p and x at scores, with which the middle of a sky has the distribution of its example.

    Parameters
    ----------
    expected : ndarray of float32 (N, 2)
        Tables with which skies have it in the mean over seeds.
    shape : (int, int)
        Rows and columns of the example.
    blend : callable
        ``blend(out, y, x, tables)`` writes the values of tables (rows, columns, 2) at positions in pixels of the
        example from the middle of the sky, at time 0.
    """
    y, x = (side * ((np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5) for side in shape)
    scores = np.linspace(-MAX_SCORE, MAX_SCORE, len(expected))
    found = np.empty((_SAMPLES, _SAMPLES, 2), np.float32)
    blend(found, y, x, np.repeat(scores[:, None], 2, axis=1).astype(np.float32))
    knots = np.linspace(-_RANKED, _RANKED, _RANKS)
    mapped = []
    for field in range(2):
        rank = np.quantile(found[..., field], ndtr(knots)) + 1e-6 * np.arange(_RANKS)
        beyond = np.clip(scores, rank[0], rank[-1])
        mapped.append(np.interp(np.interp(beyond, rank, knots) + scores - beyond, scores, expected[:, field]))
    return np.stack(mapped, axis=1).astype(np.float32)
