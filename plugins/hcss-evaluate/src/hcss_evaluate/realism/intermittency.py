"""Intermittency: how much of all change is concentrated in few places, by scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcss_twin.providers import Array

_FINEST, _COARSEST = 2, 8
"""Boxes of the line, from 2 pixels to an eighth of the shorter side of a frame."""


def gradient_size(field: Array) -> Array:
    """Return the modulus of the differences between neighbours along both axes (rows - 1, columns - 1)."""
    along_y, along_x = field[1:, :-1] - field[:-1, :-1], field[:-1, 1:] - field[:-1, :-1]
    size: Array = np.hypot(along_y, along_x)
    return size


def codimension(fluxes: Sequence[Array]) -> float | None:
    """Return C1, the codimension of the mean: 0 for an even field, more where few places have all of it.

    Moments of the flux averaged over boxes grow with the ratio of scales as ratio^K(q), and C1 = K'(1) (S. Lovejoy and
    D. Schertzer; A. Marshak et al., J. Atmos. Sci. 54, 1423, 1997): the slope of <flux ln flux> / <flux> against the
    logarithm of the ratio, means over all frames. None if frames have fewer than 32 pixels a side or no flux.

    Parameters
    ----------
    fluxes : sequence of ndarray (rows, columns)
        Nonnegative values, such as ``gradient_size`` of a field.
    """
    side = min((min(flux.shape) for flux in fluxes), default=0)
    sizes, entropies = [], []
    box = 1
    while box * _COARSEST <= side:
        if box >= _FINEST:
            means = np.concatenate([_box_means(flux, box).ravel() for flux in fluxes])
            mean = means.mean()
            if not mean > 0.0:
                return None
            share = means / mean
            entropies.append(float(np.mean(share * np.log(np.where(share > 0.0, share, 1.0)))))
            sizes.append(box)
        box *= 2
    return float(-np.polyfit(np.log(sizes), entropies, 1)[0]) if len(sizes) >= 2 else None


def _box_means(flux: Array, box: int) -> Array:
    rows, columns = (length // box for length in flux.shape)
    cut = flux[: rows * box, : columns * box]
    means: Array = cut.reshape(rows, box, columns, box).mean(axis=(1, 3))
    return means
