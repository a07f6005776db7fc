"""The norm of errors of radiance: by it nodes are placed, levels chosen, omissions bounded and references compared."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array


def largest_error(guess: Array, exact: Array, whole: Array | None = None) -> float:
    """Return the largest difference of radiances, relative to the radiance of their band.

    Parameters
    ----------
    guess, exact : ndarray
        Of one shape; may be empty: then it is 0.
    whole : ndarray, optional
        What the difference of a term is compared with, broadcast: the total. By default ``exact``.

    Returns
    -------
    float
        Infinite if they differ where there is no radiance.
    """
    away, size = np.broadcast_arrays(np.abs(guess - exact), np.abs(exact if whole is None else whole))
    lit = size > 0.0
    return float(np.max(away[lit] / size[lit], initial=0.0)) if not np.any(away[~lit]) else np.inf


TERM_TOLERANCE = 10.0
"""Tolerance of terms over that of their total, which is a tenth of the accuracy: other errors of terms are small."""


def error_of_columns(guess: Array, exact: Array) -> float:
    """Return the largest error of columns (..., K, B): of their total, or a tenth of that of a term.

    Where cloud is as bright as what it hides, terms change and their sum does not. All terms count, so that radiance
    does not depend on those that are written.
    """
    total = np.sum(exact, axis=-2, keepdims=True)
    of_terms = largest_error(guess, exact, total) / TERM_TOLERANCE
    return max(of_terms, largest_error(np.sum(guess, axis=-2, keepdims=True), total))
