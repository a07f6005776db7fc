"""Doubling of homogeneous layers, compiled.

A layer on a copy of itself; E, T, R are the direct and diffuse transmission and the reflection of one.
Between both, for light from above that enters along a column: D diffuse down, U up,

    D = T + R U,   U = R E + R D,   and so   (1 - R R) D = T + R R E,

and of both R' = R + (E + T) U, T' = E D + T E + T D. Where the Planck radiance is 0 at the top and
1 at the base, linear between, e (emissivity) and f (far share) give u = (e + f) / 2 toward the upper and
d = (e - f) / 2 toward the lower layer, U = u + R D, D = d + R U and f' = f / 2 + (E + T) U. Nothing is
subtracted that is not small; H. C. van de Hulst, "Multiple Light Scattering", Academic Press 1980,
chapter 4; extra directions of weight 0 as J. F. de Haan, P. B. Bosma and J. W. Hovenier, Astron.
Astrophys. 183, 371-391 (1987); linear sources after W. J. Wiscombe, J. Quant. Spectrosc. Radiat.
Transfer 16, 477-489 (1976).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hcss_twin.multiple_scattering.operators import accumulate, eliminate
from hcss_twin.multiple_scattering.starting_layer import halvings, starting_layer

# A layer that lets through less than this share in every way does not change any more when doubled.
OPAQUE = 1e-18


@njit(cache=True, nogil=True)
def solve_layer(
    same: Any, other: Any, thickness: float, mu: Any, scale: Any, co_albedo: float, beams: int, closed: bool
) -> tuple[Any, Any, Any, Any]:
    """Return scaled kernels (D, C) of reflection and transmission, scaled emissivity and far share (D,).

    Parameters as for :func:`starting_layer`, for any ``thickness``; ``closed`` where the kernels are means
    over azimuth, whose rows with direct transmission and emissivity make 1.
    """
    rows, columns = same.shape
    times = halvings(thickness, mu.min())
    # Two more columns: beside T the emissivity and the far share, beside R the emissivity and the
    # light (e - f) / 2 toward the lower layer.
    reflection = np.empty((rows, columns + 2))
    transmission = np.empty((rows, columns + 2))
    r, t, emissivity, far = starting_layer(same, other, thickness * 0.5**times, mu, scale, co_albedo, beams)
    reflection[:, :columns] = r
    transmission[:, :columns] = t
    transmission[:, columns] = emissivity
    transmission[:, columns + 1] = far
    down = np.empty((rows, columns + 2))
    up = np.empty((rows, columns + 2))
    direct = np.empty(rows)
    for done in range(times):
        left = 0.5 ** (times - done)
        for i in range(rows):
            direct[i] = math.exp(-thickness * left / mu[i])
        if _is_opaque(transmission, direct, columns):
            transmission[:, :columns] = 0.0
            transmission[:, columns + 1] *= left
            break
        _double(reflection, transmission, direct, beams, columns, down, up)
        if closed:
            _close(reflection, transmission, direct, scale, beams, columns)
    return reflection, transmission, transmission[:, columns].copy(), transmission[:, columns + 1].copy()


@njit(cache=True, nogil=True)
def _is_opaque(transmission: Any, direct: Any, columns: int) -> bool:
    for i in range(direct.size):
        if direct[i] > OPAQUE:
            return False
        for j in range(columns):
            if abs(transmission[i, j]) > OPAQUE:
                return False
    return True


@njit(cache=True, nogil=True)
def _double(
    reflection: Any, transmission: Any, direct: Any, beams: int, columns: int, down: Any, up: Any
) -> None:
    """Replace the layer by two of it. ``down`` and ``up`` (D, C + 2) are room for the light between."""
    rows = direct.size
    streams = columns - beams
    for i in range(rows):
        reflection[i, columns] = transmission[i, columns]
        reflection[i, columns + 1] = 0.5 * (transmission[i, columns] - transmission[i, columns + 1])
    down[beams:columns] = 0.0
    accumulate(down, reflection, reflection, beams, columns, beams, columns)
    matrix = np.empty((streams, streams))
    for k in range(streams):
        i = beams + k
        for j in range(streams):
            matrix[k, j] = -down[i, beams + j]
        matrix[k, k] += 1.0
        for j in range(columns):
            down[i, j] = transmission[i, j] + down[i, j] * direct[j]
        down[i, columns] += transmission[i, columns]
        down[i, columns + 1] += 0.5 * (transmission[i, columns] + transmission[i, columns + 1])
    # Symmetric, and positive definite because no layer reflects more than it receives.
    eliminate(matrix, down[beams:columns])
    # From here the last column of ``down`` is what goes up where the base alone is warm.
    for i in range(rows):
        for j in range(columns):
            up[i, j] = reflection[i, j] * direct[j]
        for j in range(columns, columns + 2):
            up[i, j] = reflection[i, j]
    accumulate(up, reflection, down, 0, rows, beams, columns)
    for start, stop in ((0, beams), (columns, rows)):
        for i in range(start, stop):
            for j in range(columns):
                down[i, j] = transmission[i, j]
            down[i, columns] = transmission[i, columns]
            down[i, columns + 1] = 0.5 * (transmission[i, columns] + transmission[i, columns + 1])
        accumulate(down, reflection, up, start, stop, beams, columns)
    for i in range(rows):
        for j in range(columns):
            reflection[i, j] += direct[i] * up[i, j]
    accumulate(reflection, transmission, up, 0, rows, beams, columns)
    # ``up`` has served: it becomes the new T.
    for i in range(rows):
        for j in range(columns):
            up[i, j] = direct[i] * down[i, j] + transmission[i, j] * direct[j]
        up[i, columns] = transmission[i, columns] + direct[i] * down[i, columns]
        up[i, columns + 1] = 0.5 * transmission[i, columns + 1] + direct[i] * down[i, columns + 1]
    accumulate(up, transmission, down, 0, rows, beams, columns)
    transmission[:] = up


@njit(cache=True, nogil=True)
def _close(reflection: Any, transmission: Any, direct: Any, scale: Any, beams: int, columns: int) -> None:
    """Give back the rounding errors by which the rows of a layer just doubled miss 1.

    Energy lost to rounding is absorption: it would double with every doubling and take 1e-6 of the light
    in conservative layers of thickness 1e6. It goes to the diagonal of R and to the emissivity in
    proportion to what was reflected and transmitted, and emitted.
    """
    for i in range(beams, columns):
        through = direct[i] * direct[i]
        scattered = 0.0
        for j in range(beams, columns):
            scattered += (reflection[i, j] + transmission[i, j]) * scale[j]
        emitted = transmission[i, columns]
        whole = scattered + emitted
        missing = scale[i] * (1.0 - through) - whole
        reflection[i, i] += missing * (scattered / whole) / scale[i]
        transmission[i, columns] += missing * (emitted / whole)
