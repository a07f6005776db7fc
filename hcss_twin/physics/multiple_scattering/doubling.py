"""Doubling of homogeneous layers, compiled, for one azimuth mode.

A layer lies on its copy; E, T and R are the direct transmission, diffuse transmission and reflection of one. Light that
enters from above along a column becomes, between the two, diffuse light D downward and U upward:

    D = T + R U,   U = R E + R D,   and so   (1 - R R) D = T + R R E,

and for the pair R' = R + (E + T) U, T' = E D + T E + T D. For a Planck radiance that rises linearly from 0 at the top
to 1 at the base, e (emissivity) and f (far share) give u = (e + f) / 2 toward the upper and d = (e - f) / 2 toward the
lower layer, U = u + R D, D = d + R U and f' = f / 2 + (E + T) U. Only small numbers are subtracted.

H. C. van de Hulst, "Multiple Light Scattering", Academic Press 1980, chapter 4; extra directions of weight 0 as in J.
F. de Haan, P. B. Bosma and J. W. Hovenier, Astron. Astrophys. 183, 371-391 (1987); linear sources after W. J. Wiscombe,
J. Quant. Spectrosc. Radiat. Transfer 16, 477-489 (1976).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import inner, kernel
from hcss_twin.physics.multiple_scattering.chains import DoublingChains, Team
from hcss_twin.physics.multiple_scattering.directions import Directions, scattering_kernels
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.physics.multiple_scattering.starting_layer import (
    START,
    START_OF_MODES,
    accumulate,
    eliminate,
    halvings,
    starting_layer,
)

OPAQUE = 1e-18
"""A layer whose direct and diffuse transmission are below this no longer changes when doubled."""

SPARE = 3
"""Number of doublings that cost about as much as a starting layer."""


@kernel(error_model="numpy")
def solve_chains(
    kernels: tuple[Any, Any, Any],
    directions: tuple[Any, Any],
    chains: tuple[Any, Any, Any, Any, Any],
    whole: tuple[int, int],
    part: tuple[int, int],
    out: tuple[Any, Any, Any],
) -> None:
    """Solve every layer of every ``part[1]``-th chain from ``part[0]`` on.

    Layers and sunlight share one compilation, for contiguous arrays; each further type takes seconds.

    Parameters
    ----------
    kernels : (ndarray (V, D, C), ndarray (V, D, C), ndarray (V,))
        k+, k- as for :func:`starting_layer`, and 1 - w.
    directions : (ndarray (D,), ndarray (D,))
        mu and scale.
    chains
        ``cell``, ``column``, ``thickness``, ``doublings`` and ``first`` of
        :class:`hcss_twin.physics.multiple_scattering.chains.DoublingChains`. Where the previous layer is so much
        thinner that a new start costs less, the chain restarts.
    whole : (int, int)
        Number of beams; 1 if the kernels are means over azimuth, whose rows sum to 1 with direct transmission and
        emissivity, else 0; then nothing is emitted.
    part : (int, int)
        First chain and step.
    out : (ndarray (cells, R, S), ndarray (cells, R, S), ndarray (2, cells, R))
        Unscaled kernels of reflection and transmission toward the last R directions from the first S; emissivity and
        far share toward the last R, for means over azimuth.
    """
    same, other, co_albedo = kernels
    mu, scale = directions
    cells, column, thickness, doublings, first = chains
    beams, closed = whole
    reflected, transmitted, emitted = out
    rows, columns = same.shape[1], same.shape[2]
    unseen, sources = rows - reflected.shape[1], reflected.shape[2]
    # Light toward the beams is needed for results only.
    skipped = min(unseen, beams)
    # Two more columns: beside T the emissivity and the far share, beside R the emissivity and the
    # light (e - f) / 2 toward the lower layer.
    width = columns + 2 * closed
    reflection = np.empty((rows, width))
    transmission = np.empty((rows, width))
    down = np.empty((rows, width))
    up = np.empty((rows, width))
    matrix = np.empty((columns - beams, columns - beams))
    direct = np.empty(rows)
    least_mu = mu[0]
    for i in range(1, rows):
        least_mu = min(least_mu, mu[i])
    for chain in range(part[0], first.size - 1, part[1]):
        depth = 0.0
        opaque = False
        for place in range(first[chain], first[chain + 1]):
            v = column[place]
            times = halvings(thickness[place], least_mu, START if closed else START_OF_MODES)
            if place > first[chain] and doublings[place] <= times + SPARE:
                times = doublings[place]
            else:
                depth = thickness[place] * 0.5**times
                opaque = False
                starting_layer(
                    same[v], other[v], depth, mu, scale, co_albedo[v], beams, skipped, reflection, transmission
                )
            for _ in range(times):
                if not opaque:
                    for i in range(rows):
                        direct[i] = math.exp(-depth / mu[i])
                    opaque = _is_opaque(transmission, direct, skipped, columns)
                if opaque:
                    for i in range(skipped, rows):
                        for j in range(columns):
                            transmission[i, j] = 0.0
                        if closed:
                            transmission[i, columns + 1] *= 0.5
                else:
                    _double(reflection, transmission, direct, beams, columns, skipped, down, up, matrix)
                    if closed:
                        _close(reflection, transmission, direct, scale, beams, columns)
                depth *= 2.0
            cell = cells[place]
            for i in range(unseen, rows):
                if closed:
                    emitted[0, cell, i - unseen] = transmission[i, columns] / scale[i]
                    emitted[1, cell, i - unseen] = transmission[i, columns + 1] / scale[i]
                for j in range(sources):
                    unscaled = 1.0 / (scale[i] * scale[j])
                    reflected[cell, i - unseen, j] = reflection[i, j] * unscaled
                    transmitted[cell, i - unseen, j] = transmission[i, j] * unscaled


@inner(error_model="numpy")
def _is_opaque(transmission: Any, direct: Any, skipped: int, columns: int) -> bool:
    for i in range(skipped, direct.size):
        if direct[i] > OPAQUE:
            return False
        for j in range(columns):
            if abs(transmission[i, j]) > OPAQUE:
                return False
    return True


@inner(error_model="numpy")
def _double(
    reflection: Any,
    transmission: Any,
    direct: Any,
    beams: int,
    columns: int,
    skipped: int,
    down: Any,
    up: Any,
    matrix: Any,
) -> None:
    """Replace the layer by two copies of it; ``down``, ``up`` (as ``reflection``) and ``matrix`` are working memory."""
    rows, width = reflection.shape
    streams = columns - beams
    emits = width > columns
    if emits:
        for i in range(skipped, rows):
            reflection[i, columns] = transmission[i, columns]
            reflection[i, columns + 1] = 0.5 * (transmission[i, columns] - transmission[i, columns + 1])
    for i in range(beams, columns):
        for j in range(width):
            down[i, j] = 0.0
    accumulate(down, reflection, reflection, beams, columns, beams, columns)
    for k in range(streams):
        i = beams + k
        for j in range(streams):
            matrix[k, j] = -down[i, beams + j]
        matrix[k, k] += 1.0
        for j in range(columns):
            down[i, j] = transmission[i, j] + down[i, j] * direct[j]
        if emits:
            down[i, columns] += transmission[i, columns]
            down[i, columns + 1] += 0.5 * (transmission[i, columns] + transmission[i, columns + 1])
    # Symmetric, and positive definite because no layer reflects more than it receives.
    eliminate(matrix, down, beams)
    # From here on the last column of ``down`` is the upward light if only the base is warm.
    for i in range(skipped, rows):
        for j in range(columns):
            up[i, j] = reflection[i, j] * direct[j]
        for j in range(columns, width):
            up[i, j] = reflection[i, j]
    accumulate(up, reflection, down, skipped, rows, beams, columns)
    for side in range(2):
        start, stop = (skipped, beams) if side == 0 else (columns, rows)
        for i in range(start, stop):
            for j in range(columns):
                down[i, j] = transmission[i, j]
            if emits:
                down[i, columns] = transmission[i, columns]
                down[i, columns + 1] = 0.5 * (transmission[i, columns] + transmission[i, columns + 1])
        accumulate(down, reflection, up, start, stop, beams, columns)
    for i in range(skipped, rows):
        for j in range(columns):
            reflection[i, j] += direct[i] * up[i, j]
    accumulate(reflection, transmission, up, skipped, rows, beams, columns)
    # ``up`` is no longer needed and becomes the new T.
    for i in range(skipped, rows):
        for j in range(columns):
            up[i, j] = direct[i] * down[i, j] + transmission[i, j] * direct[j]
        if emits:
            up[i, columns] = transmission[i, columns] + direct[i] * down[i, columns]
            up[i, columns + 1] = 0.5 * transmission[i, columns + 1] + direct[i] * down[i, columns + 1]
    accumulate(up, transmission, down, skipped, rows, beams, columns)
    for i in range(skipped, rows):
        for j in range(width):
            transmission[i, j] = up[i, j]


@inner(error_model="numpy")
def _close(reflection: Any, transmission: Any, direct: Any, scale: Any, beams: int, columns: int) -> None:
    """Make the rows of a layer just doubled sum to 1 in spite of rounding.

    Energy lost to rounding acts as absorption: it would double with every doubling and absorb 1e-6 of the light in
    conservative layers of thickness 1e6. It is added to the diagonal of R and to the emissivity, in proportion to the
    scattered and the emitted light.
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


@dataclass(frozen=True)
class SolvedMode:
    """One azimuth mode of n layers in the order of their chains, from S toward R directions.

    Attributes
    ----------
    reflection, transmission : ndarray (n, R, S)
        sr-1.
    emissivity, far_share : ndarray (n, R)
        Meaningful for mode 0 only.
    same, other : ndarray (V, D, C)
        Kernels of scattering, for the wavenumbers that have layers.
    """

    reflection: Array
    transmission: Array
    emissivity: Array
    far_share: Array
    same: Array
    other: Array


def solve_mode(
    where: Directions,
    scaled: ScaledScattering,
    layers: DoublingChains,
    mode: int,
    team: Team,
    toward: int | None = None,
    sources: int | None = None,
) -> SolvedMode:
    """Solve one mode of ``layers``.

    Parameters
    ----------
    toward, sources : int, optional
        Results are computed toward the last ``toward`` and from the first ``sources`` directions; default: all.
    """
    few = ScaledScattering(
        scaled.thickness[:, layers.wavenumber],
        scaled.albedo[layers.wavenumber],
        scaled.co_albedo[layers.wavenumber],
        scaled.moments[:, layers.wavenumber],
        scaled.peak[layers.wavenumber],
    )
    same, other = scattering_kernels(where, few, mode)
    rows = where.mu.size if toward is None else toward
    columns = where.columns if sources is None else sources
    count = layers.cell.size
    reflection, transmission = np.empty((count, rows, columns)), np.empty((count, rows, columns))
    emitted = np.empty((2, count, rows))
    place = np.arange(count)

    def part(start: int, step: int) -> None:
        solve_chains(
            (same, other, few.co_albedo),
            (where.mu, where.scale),
            (place, layers.column, layers.thickness, layers.doublings, layers.first),
            (where.beams, int(mode == 0)),
            (start, step),
            (reflection, transmission, emitted),
        )

    team.run(part, layers.first.size - 1)
    return SolvedMode(reflection, transmission, emitted[0], emitted[1], same, other)
