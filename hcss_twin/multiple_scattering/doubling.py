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

from typing import Any

import numpy as np
from numba import njit

from hcss_twin.multiple_scattering.operators import eliminate
from hcss_twin.multiple_scattering.starting_layer import halvings, starting_layer

# A layer that lets through less than this share in every way does not change any more when doubled.
OPAQUE = 1e-18


@njit(cache=True, nogil=True)
def solve_layer(
    same: Any, other: Any, thickness: float, mu: Any, scale: Any, co_albedo: float, beams: int
) -> tuple[Any, Any, Any, Any]:
    """Return scaled kernels (D, C) of reflection and transmission, scaled emissivity and far share (D,).

    Parameters as for :func:`starting_layer`, for any ``thickness``.
    """
    times = halvings(thickness, mu.min())
    reflection, transmission, emissivity, far = starting_layer(
        same, other, thickness * 0.5**times, mu, scale, co_albedo, beams
    )
    rows, columns = same.shape
    between = np.empty((rows, columns + 2))
    up = np.empty((rows, columns + 2))
    for done in range(times):
        direct = np.exp(-thickness * 0.5 ** (times - done) / mu)
        if direct.max() < OPAQUE and np.abs(transmission).max() < OPAQUE:
            transmission[:] = 0.0
            far *= 0.5 ** (times - done)
            break
        _double(reflection, transmission, direct, emissivity, far, beams, between, up)
    return reflection, transmission, emissivity, far


@njit(cache=True, nogil=True)
def _double(
    reflection: Any,
    transmission: Any,
    direct: Any,
    emissivity: Any,
    far: Any,
    beams: int,
    down: Any,
    up: Any,
) -> None:
    """Replace the layer by two of it. ``down`` and ``up`` (D, C + 2) are room for the light between.

    Their last columns are the light of an isothermal layer and of one whose base alone is warm.
    """
    rows, columns = reflection.shape
    streams = columns - beams
    matrix = np.empty((streams, streams))
    for k in range(streams):
        i = beams + k
        for j in range(columns):
            down[i, j] = 0.0
        down[i, columns] = emissivity[i]
        down[i, columns + 1] = 0.5 * (emissivity[i] + far[i])
        for l in range(beams, columns):  # noqa: E741
            factor = reflection[i, l]
            for j in range(columns):
                down[i, j] += factor * reflection[l, j]
            down[i, columns] += factor * emissivity[l]
            down[i, columns + 1] += factor * 0.5 * (emissivity[l] - far[l])
        for j in range(streams):
            matrix[k, j] = -down[i, beams + j]
        matrix[k, k] += 1.0
        for j in range(columns):
            down[i, j] = transmission[i, j] + down[i, j] * direct[j]
    eliminate(matrix, down[beams:columns])
    # The last column holds what goes up: what goes down is d + R U.
    for i in range(rows):
        for j in range(columns):
            up[i, j] = reflection[i, j] * direct[j]
        up[i, columns] = emissivity[i]
        up[i, columns + 1] = 0.5 * (emissivity[i] - far[i])
        for l in range(beams, columns):  # noqa: E741
            factor = reflection[i, l]
            for j in range(columns + 2):
                up[i, j] += factor * down[l, j]
    for i in range(rows):
        if i < beams or i >= columns:
            for j in range(columns):
                down[i, j] = transmission[i, j]
            down[i, columns] = up[i, columns]
            down[i, columns + 1] = 0.5 * (emissivity[i] + far[i])
            for l in range(beams, columns):  # noqa: E741
                factor = reflection[i, l]
                for j in range(columns):
                    down[i, j] += factor * up[l, j]
                down[i, columns + 1] += factor * up[l, columns + 1]
    for i in range(rows):
        # T of this row is still needed while its new values are summed: they replace ``down``'s and R's.
        for j in range(columns):
            reflection[i, j] += direct[i] * up[i, j]
        emissivity[i] += direct[i] * down[i, columns]
        far[i] = 0.5 * far[i] + direct[i] * down[i, columns + 1]
        for l in range(beams, columns):  # noqa: E741
            factor = transmission[i, l]
            for j in range(columns):
                reflection[i, j] += factor * up[l, j]
            emissivity[i] += factor * down[l, columns]
            far[i] += factor * down[l, columns + 1]
    _transmit(transmission, direct, beams, down)


@njit(cache=True, nogil=True)
def _transmit(transmission: Any, direct: Any, beams: int, down: Any) -> None:
    """Replace T by E D + T E + T D."""
    rows, columns = transmission.shape
    row = np.empty(columns)
    for i in range(rows):
        for j in range(columns):
            row[j] = direct[i] * down[i, j] + transmission[i, j] * direct[j]
        for l in range(beams, columns):  # noqa: E741
            factor = transmission[i, l]
            for j in range(columns):
                row[j] += factor * down[l, j]
        for j in range(columns):
            transmission[i, j] = row[j]
