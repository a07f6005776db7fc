"""Doubling of homogeneous layers, compiled, for one azimuth mode.

A layer lies on its copy; E, T and R are the direct transmission, diffuse transmission and reflection of one. Light that
enters from above along a column becomes, between the two, diffuse light D downward and U upward:

    D = T + R U,   U = R E + R D,   and so   D + U = (1 - R)^-1 (T + R E),   D - U = (1 + R)^-1 (T - R E).

For the pair R' = R + (E + T) U and T' = E D + T E + T D. R is symmetric and no layer reflects more than it receives, so
that 1 - R and 1 + R have Cholesky factors L; with Y = L^-1 (E + T) among streams, and L^-1 (T +- R E) from other
directions, sums of products Y'Y give R' and T' as sum and difference: less than half the operations of solving for
(1 - R R) D = T + R R E, and symmetric to the last bit. What is kept of Y is Y - E, and of L's diagonal what it lacks
to 1, because R and T of thin layers would be lost beside 1. For a Planck radiance that rises linearly from 0 at the top
to 1 at the base, e (emissivity) and f (far share) give u = (e + f) / 2 toward the upper and d = (e - f) / 2 toward the
lower layer, so that U + D = (1 - R)^-1 e, U - D = (1 + R)^-1 f and f' = f / 2 + (E + T) U.

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
from hcss_twin.core.kernels import kernel
from hcss_twin.physics.multiple_scattering.chains import DoublingChains, Team
from hcss_twin.physics.multiple_scattering.directions import Directions, scattering_kernels
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering
from hcss_twin.physics.multiple_scattering.starting_layer import START, START_OF_MODES, halvings, starting_layers

OPAQUE = 1e-18
"""A layer whose direct and diffuse transmission are below this no longer changes when doubled."""

SPARE = 6
"""Number of doublings that cost about as much as a starting layer."""

LANES = 8
"""Rows of working memory have multiples of so many numbers: what remains of vectors costs as much as they do."""

LEAST_PIVOT = 1e-18
"""Pivots of layers that reflect everything but for rounding."""


@kernel()
def solve_chains(
    starts: tuple[Any, Any, Any, Any],
    directions: tuple[Any, Any],
    chains: tuple[Any, Any, Any, Any],
    whole: tuple[int, int],
    out: tuple[Any, Any, Any],
) -> None:
    """Solve every layer of some chains.

    Layers and sunlight share one compilation, for contiguous arrays; each further type takes seconds.

    Parameters
    ----------
    starts : (ndarray (m, D, C + 1), ndarray (m, D, C + 1), ndarray (m,), ndarray (m,))
        Reflection and transmission of the starting layer of each chain, its thickness, and how often it is doubled to
        become the first layer.
    directions : (ndarray (D,), ndarray (D,))
        mu and scale.
    chains : (ndarray (m,), ndarray (m,), ndarray (n,), ndarray (n,))
        Where the layers of each chain begin and end; ``cell`` and ``doublings`` of
        :class:`hcss_twin.physics.multiple_scattering.chains.DoublingChains`.
    whole : (int, int)
        Number of beams; 1 if the kernels are means over azimuth, whose rows sum to 1 with direct transmission and
        emissivity, else 0; then nothing is emitted.
    out : (ndarray (cells, R, S), ndarray (cells, R, S), ndarray (2, cells, R))
        Unscaled kernels of reflection and transmission toward the last R directions from the first S; emissivity and
        far share toward the last R, for means over azimuth.
    """
    thin_reflection, thin_transmission, thin, times = starts
    mu, scale = directions
    begin, end, cells, doublings = chains
    beams, closed = whole
    reflected, transmitted, emitted = out
    rows, columns = mu.size, thin_reflection.shape[2] - 1
    unseen, sources = rows - reflected.shape[1], reflected.shape[2]
    # Light toward the beams is needed for results only.
    skipped = min(unseen, beams)
    streams, others = columns - beams, rows - columns
    # Streams come first, beams last; beyond the directions, T has the emissivity and R the far share.
    width = (rows // LANES + 1) * LANES
    reflection = np.zeros((rows, width))
    transmission = np.zeros((rows, width))
    factor = np.zeros((streams, ((streams - 1) // LANES + 1) * LANES + width))
    products = np.zeros((2, rows, width))
    direct = np.zeros(width)
    position = np.empty(rows, dtype=np.int64)
    for i in range(rows):
        position[i] = i - beams if i >= beams else streams + others + i
    for chain in range(begin.size):
        depth = thin[chain]
        opaque = False
        for i in range(skipped, rows):
            for j in range(columns):
                reflection[position[i], position[j]] = thin_reflection[chain, i, j]
                transmission[position[i], position[j]] = thin_transmission[chain, i, j]
            if closed:
                reflection[position[i], rows] = thin_reflection[chain, i, columns]
                transmission[position[i], rows] = thin_transmission[chain, i, columns]
        for i in range(columns, rows):
            for j in range(beams, columns):
                reflection[position[j], position[i]] = thin_reflection[chain, i, j]
                transmission[position[j], position[i]] = thin_transmission[chain, i, j]
        for number in range(begin[chain], end[chain]):
            for _ in range(times[chain] if number == begin[chain] else doublings[number]):
                if not opaque:
                    for i in range(rows):
                        direct[position[i]] = math.exp(-depth / mu[i])
                    opaque = _is_opaque(transmission, direct, rows - skipped, streams, others)
                if opaque:
                    for i in range(rows):
                        for j in range(width):
                            if j != rows:
                                transmission[i, j] = 0.0
                        reflection[i, rows] *= 0.5
                else:
                    _double(reflection, transmission, direct, rows - skipped, streams, others, factor, products)
                    if closed:
                        _close(reflection, transmission, direct, scale[beams:columns])
                depth *= 2.0
            cell = cells[number]
            for i in range(unseen, rows):
                if closed:
                    emitted[0, cell, i - unseen] = transmission[position[i], rows] / scale[i]
                    emitted[1, cell, i - unseen] = reflection[position[i], rows] / scale[i]
                for j in range(sources):
                    low, high = min(position[i], position[j]), max(position[i], position[j])
                    unscaled = 1.0 / (scale[i] * scale[j])
                    reflected[cell, i - unseen, j] = reflection[low, high] * unscaled
                    transmitted[cell, i - unseen, j] = transmission[low, high] * unscaled


@kernel(inner=True)
def _is_opaque(transmission: Any, direct: Any, rows: int, streams: int, others: int) -> bool:
    for i in range(rows):
        if direct[i] > OPAQUE:
            return False
        for j in range(_first_column(i, streams, others), direct.size):
            if j != streams + others and abs(transmission[i, j]) > OPAQUE:
                return False
    return True


@kernel(inner=True)
def _first_column(row: int, streams: int, others: int) -> int:
    """Return where the part of a row begins that matters: the diagonal, or the beams for another extra direction."""
    return streams + others if streams <= row < streams + others else row


@kernel(inner=True, fastmath={"contract"})
def _add_products(target: Any, factor: Any, column: int, count: int, start: int, sign: float) -> None:
    """Add to ``target`` the sum over ``count`` rows k of ``factor``: sign times [k, column] times [k, start:]."""
    width = target.size
    whole = count - count % 4
    for k in range(0, whole, 4):
        f0, f1 = sign * factor[k, column], sign * factor[k + 1, column]
        f2, f3 = sign * factor[k + 2, column], sign * factor[k + 3, column]
        r0, r1, r2, r3 = factor[k, start:], factor[k + 1, start:], factor[k + 2, start:], factor[k + 3, start:]
        for j in range(width):
            target[j] = target[j] + f0 * r0[j] + f1 * r1[j] + f2 * r2[j] + f3 * r3[j]
    for k in range(whole, count):
        f0, r0 = sign * factor[k, column], factor[k, start:]
        for j in range(width):
            target[j] += f0 * r0[j]


@kernel(inner=True, fastmath={"contract"})
def _double(
    reflection: Any, transmission: Any, direct: Any, rows: int, streams: int, others: int, factor: Any, products: Any
) -> None:
    """Replace the layer by two copies of it.

    Parameters
    ----------
    reflection, transmission : ndarray (D, W)
        Elements from the diagonal on; among streams, all.
    direct : ndarray (W,)
        0 beyond the directions.
    rows : int
        How many of them are needed.
    factor, products : ndarray (N, M + W), (2, D, W)
        Working memory: Cholesky factor and Y - E, and Y'Y - E E for both signs.
    """
    directions, width = reflection.shape
    margin = factor.shape[1] - width
    for side in range(2):
        sign = 1.0 - 2.0 * side
        for i in range(streams):
            back, through = reflection[i], transmission[i]
            left, right = factor[i, :margin], factor[i, margin:]
            for j in range(left.size):
                left[j] = -sign * back[j]
            for j in range(streams):
                right[j] = through[j]
            for j in range(i):
                right[j] -= factor[j, i] * direct[j]
            for j in range(streams, width):
                right[j] = through[j] + sign * back[j] * direct[j]
            right[directions] = back[directions] if side else through[directions]
            begin = i // LANES * LANES
            row = factor[i, begin:]
            _add_products(row, factor, i, i, begin, -1.0)
            root = math.sqrt(max(1.0 + left[i], LEAST_PIVOT))
            right[i] -= left[i] / (1.0 + root) * direct[i]
            inverse = 1.0 / root
            for j in range(row.size):
                row[j] *= inverse
        for i in range(rows):
            begin = _first_column(i, streams, others) // LANES * LANES
            target = products[side, i, begin:]
            if i < streams:
                shifted = factor[i, margin + begin :]
                for j in range(target.size):
                    target[j] = direct[i] * shifted[j]
                for j in range(begin, streams):
                    products[side, i, j] += factor[j, margin + i] * direct[j]
            else:
                for j in range(target.size):
                    target[j] = 0.0
            _add_products(target, factor, margin + i, streams, margin + begin, 1.0)
    for i in range(rows):
        begin = _first_column(i, streams, others) // LANES * LANES
        plus, minus = products[0, i, begin:], products[1, i, begin:]
        back, through, carried = reflection[i, begin:], transmission[i, begin:], direct[begin:]
        emitted, far = transmission[i, directions], reflection[i, directions]
        sent, sent_far = products[0, i, directions], products[1, i, directions]
        if i < streams:
            for j in range(plus.size):
                is_extra = 1.0 if begin + j >= streams else 0.0  # among streams, Y contains it
                back[j] += 0.5 * (plus[j] - minus[j])
                through[j] = through[j] * carried[j] * is_extra + 0.5 * (plus[j] + minus[j])
            beam_direct = 0.0
        else:
            beam_direct = direct[i]
            for j in range(plus.size):
                back[j] += beam_direct * carried[j] * back[j] + 0.5 * (plus[j] - minus[j])
                through[j] = through[j] * (carried[j] + beam_direct) + 0.5 * (plus[j] + minus[j])
        transmission[i, directions] = emitted * (1.0 + beam_direct) + sent
        reflection[i, directions] = 0.5 * (far + beam_direct * (emitted + far) + sent + sent_far)
    for i in range(streams):
        for j in range(i):
            reflection[i, j] = reflection[j, i]
            transmission[i, j] = transmission[j, i]


@kernel(inner=True)
def _close(reflection: Any, transmission: Any, direct: Any, scale: Any) -> None:
    """Make the rows of a layer just doubled sum to 1 in spite of rounding.

    Energy lost to rounding acts as absorption: it would double with every doubling and absorb 1e-6 of the light in
    conservative layers of thickness 1e6. It is added to the diagonal of R and to the emissivity, in proportion to the
    scattered and the emitted light.
    """
    directions = reflection.shape[0]
    for i in range(scale.size):
        through = direct[i] * direct[i]
        scattered = 0.0
        for j in range(scale.size):
            scattered += (reflection[i, j] + transmission[i, j]) * scale[j]
        emitted = transmission[i, directions]
        whole = scattered + emitted
        missing = scale[i] * (1.0 - through) - whole
        reflection[i, i] += missing * (scattered / whole) / scale[i]
        transmission[i, directions] += missing * (emitted / whole)


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
    cells = np.arange(count)

    # Where the previous layer is so much thinner that a new start costs less, the chain starts again.
    times = halvings(layers.thickness, where.mu.min(), START_OF_MODES if mode else START)
    begin = np.union1d(layers.first[:-1], np.flatnonzero(layers.doublings > times + SPARE))
    end = np.append(begin[1:], count)

    def part(start: int, step: int) -> None:
        first, last = (np.ascontiguousarray(ends[start::step]) for ends in (begin, end))
        column, often = layers.column[first], times[first]
        thin = layers.thickness[first] * 0.5**often
        of_start = same[column], other[column], thin, where.mu, where.scale, few.co_albedo[column], where.beams
        for which, reflected, transmitted in starting_layers(*of_start):
            solve_chains(
                (reflected, transmitted, thin[which], often[which]),
                (where.mu, where.scale),
                (first[which], last[which], cells, layers.doublings),
                (where.beams, int(mode == 0)),
                (reflection, transmission, emitted),
            )

    team.run(part, begin.size)
    return SolvedMode(reflection, transmission, emitted[0], emitted[1], same, other)
