"""Successive orders of scattering along 16 directions, swept through horizontal slices.

Directions come in four rings: two cosines of the zenith angle, down and up, with four azimuths each. The exchange
between directions depends on differences of azimuth alone, so that each harmonic of the azimuths has a matrix of its
own between rings (:func:`coupling`): a fifth of the work of the whole matrix.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

AZIMUTHS = 4
RINGS = 4
DIRECTIONS = 16
EVEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps that cover a square evenly: powers of the inverse of the real root of x^3 = x + 1."""

BLOCK = 128
"""Voxels whose directions are mixed together, so that they stay in the nearest cache."""


def directions() -> Array:
    """Return 16 directions (D, 3) of flight of equal weight, first those that go down: 2 cosines, 4 azimuths each."""
    cosine = 0.5 + np.array([0.5, -0.5]) / math.sqrt(3.0)
    vectors = []
    for sign in (-1.0, 1.0):
        for ring, up in enumerate(cosine):
            for step in range(AZIMUTHS):
                azimuth = 2.0 * math.pi * (step + 0.25 + 0.5 * ring) / AZIMUTHS
                across = math.sqrt(1.0 - up * up)
                vectors.append((across * math.cos(azimuth), across * math.sin(azimuth), sign * up))
    return np.array(vectors)


def henyey_greenstein_at(cosine: Array, asymmetry: float) -> Array:
    """Return Henyey and Greenstein's function, whose mean over the sphere is 1."""
    g = asymmetry
    result: Array = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine) ** 1.5
    return result


def exchange(asymmetry: float) -> Array:
    """Return the shares (D, D) of light scattered between directions; rows and columns sum to 1."""
    flight = directions()
    cosine = np.clip(np.sum(flight[:, None] * flight[None], axis=-1), -1.0, 1.0)
    matrix = henyey_greenstein_at(cosine, asymmetry)
    for _ in range(200):
        scale = 1.0 / np.sqrt(np.sum(matrix, axis=1))
        matrix = scale[:, None] * matrix * scale
    return matrix


def coupling(matrix: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return a matrix (D, D) of exchange as matrices (4, R, R) between rings, and cosine and sine (R, 2) of azimuths.

    One matrix for the sum over azimuths, the alternating sum, and the first cosine and sine harmonics.
    """
    flight = directions().reshape(RINGS, AZIMUTHS, 3)
    turn = flight[:, 0, :2] / np.hypot(flight[:, 0, 0], flight[:, 0, 1])[:, None]
    basis = np.zeros((4, RINGS, RINGS, AZIMUTHS))
    for ring, azimuth in enumerate(np.arctan2(flight[..., 1], flight[..., 0])):
        basis[:, ring, ring] = np.ones(4), np.array([1.0, -1.0, 1.0, -1.0]), np.cos(azimuth), np.sin(azimuth)
    harmonics = basis.reshape(DIRECTIONS, DIRECTIONS)
    mixed = (harmonics @ matrix @ np.linalg.inv(harmonics)).reshape(4, RINGS, 4, RINGS)
    # Back from harmonics to directions: means for the sums, twice these for cosine and sine.
    result = (
        np.array([mixed[harmonic, :, harmonic] for harmonic in range(4)])
        * np.array([0.25, 0.25, 0.5, 0.5])[:, None, None]
    )
    return result.astype(np.float32), turn.astype(np.float32)


def displacements(moves: Array, shape: tuple[int, ...], orders: int) -> NDArray[np.int64]:
    """Return by how many rows and columns (N, D, Z, 2) rays are displaced in each slice since the first they cross.

    Whole points: mixtures of neighbours in each slice would spread light as if it were scattered. Rays of different
    orders and directions cross columns in different parts, evenly over their areas.

    Parameters
    ----------
    moves : ndarray (D, 2)
        Rows and columns in each slice.
    """
    crossed = np.arange(shape[0])
    crossed = np.where(np.arange(DIRECTIONS)[:, None] < DIRECTIONS // 2, crossed[::-1], crossed)
    start = (0.5 + np.arange(orders * DIRECTIONS).reshape(orders, DIRECTIONS, 1, 1) * EVEN) % 1.0
    places = np.floor(crossed[:, :, None] * moves[:, None] + start).astype(np.int64)
    result: NDArray[np.int64] = places % np.array(shape[1:])
    return result


@kernel()
def block_means(density: Any, sunlight: Any, high: int, wide: int) -> Any:
    """Return the mean density of blocks of slices and points, and the sunlight that their cloud receives."""
    count, rows, columns = density.shape
    shape = -(-count // high), -(-rows // wide), -(-columns // wide)
    lit = sunlight.shape[0] > 0
    means, light = np.zeros(shape, dtype=np.float32), np.zeros(shape if lit else (0, 1, 1), dtype=np.float32)
    for s in range(count):
        for y in range(rows):
            for x in range(columns):
                voxel_density = density[s, y, x]
                if voxel_density > 0.0:
                    means[s // high, y // wide, x // wide] += voxel_density
                    if lit:
                        light[s // high, y // wide, x // wide] += voxel_density * sunlight[s, y, x]
    for s in range(shape[0]):
        for y in range(shape[1]):
            for x in range(shape[2]):
                if means[s, y, x] > 0.0:
                    if lit:
                        light[s, y, x] /= means[s, y, x]
                    # Blocks at the edge have fewer voxels.
                    size = (min((s + 1) * high, count) - s * high) * (min((y + 1) * wide, rows) - y * wide)
                    means[s, y, x] /= size * (min((x + 1) * wide, columns) - x * wide)
    return means, light


@kernel()
def successive_orders(
    density: Any, kind: Any, depths: Any, coupled: Any, turn: Any, toward: Any, emission: Any, opaque: Any,
    of_sun: Any, sunlight: Any, displaced: Any, in_gas: Any, sky: float, below: float, start: Any, started: Any,
    high: int, wide: int,
) -> Any:  # fmt: skip
    """Sweep the slices along all directions, once for each order.

    Parameters
    ----------
    density : ndarray (Z, y, x)
    kind : ndarray of int (Z,)
        Number of the particles of each slice, 0 to K - 1, ascending.
    depths : ndarray (D,)
        Optical thickness of a slice of density 1.
    coupled, turn : ndarray (K, 4, R, R), (R, 2)
        Exchange between directions, times the albedo, by particles; see :func:`coupling`.
    toward : ndarray (K, D)
        Share of the light from each direction that is scattered toward the view.
    emission, opaque : ndarray (Z,)
        Source function of each slice by emission alone, and of opaque cloud.
    of_sun : ndarray (K, D)
        Source function along each direction for sunlight 1.
    sunlight : ndarray (Z, y, x)
        Empty: none.
    displaced : ndarray of int (N, D, Z, 2)
        Of each order; see :func:`displacements`.
    in_gas : ndarray (D, Z)
        Transmittance of the gas.
    sky, below : float
        Radiance from above and below.
    start : ndarray (D, N)
        Light scattered along each direction in blocks of ``high`` slices and ``wide`` points; empty: that of opaque
        cloud.
    started : ndarray of int (Z, y, x)
        Columns of ``start``.

    Returns
    -------
    ndarray (Z, y, x), ndarray (D, N), ndarray of int (Z, y, x)
        Light scattered toward the view, and along each direction in cloudy voxels, with the numbers of these.
    """
    count, rows, columns = density.shape
    half = DIRECTIONS // 2
    # Cloudy voxels alone are stored, one row of a slice after the other.
    first_of_row, cloudy = np.empty((count, rows + 1), dtype=np.int64), 0
    first_of_kind = np.zeros(coupled.shape[0] + 1, dtype=np.int64)
    for s in range(count):
        for y in range(rows):
            first_of_row[s, y] = cloudy
            for x in range(columns):
                if density[s, y, x] > 0.0:
                    cloudy += 1
        first_of_row[s, rows] = cloudy
        first_of_kind[kind[s] + 1 :] = cloudy
    number = np.empty((count, rows, columns), dtype=np.int32)
    column_of, fixed = np.empty(cloudy, dtype=np.int32), np.empty(cloudy, dtype=np.float32)
    kept, inside = np.empty((2, cloudy), dtype=np.float32), np.empty((2, cloudy), dtype=np.float32)
    source = np.empty((DIRECTIONS, cloudy), dtype=np.float32)
    mean = np.empty((DIRECTIONS, cloudy), dtype=np.float32)
    lit, voxel = sunlight.shape[0] > 0, 0
    for s in range(count):
        own_sun = of_sun[kind[s]]
        for y in range(rows):
            for x in range(columns):
                voxel_density = density[s, y, x]
                if voxel_density <= 0.0:
                    continue
                column_of[voxel] = x
                for ring in range(2):
                    depth = voxel_density * depths[ring * AZIMUTHS]
                    weakened = np.exp(-depth)
                    kept[ring, voxel] = weakened
                    inside[ring, voxel] = 1.0 - 0.5 * depth if depth < 1e-3 else (1.0 - weakened) / depth
                fixed[voxel] = sunlight[s, y, x] if lit else 0.0
                number[s, y, x] = voxel
                for d in range(DIRECTIONS):
                    source[d, voxel] = own_sun[d] * fixed[voxel]
                    if start.shape[1] > 0:
                        source[d, voxel] += emission[s] + start[d, started[s // high, y // wide, x // wide]]
                    else:
                        source[d, voxel] += opaque[s]
                voxel += 1
    # Rays keep their place in memory; each meets the voxels to which it is displaced.
    ray = np.empty((half, rows, columns), dtype=np.float32)
    for order in range(displaced.shape[0]):
        for upward in range(2):
            first = upward * half
            ray[:] = below if upward else sky
            for step in range(count):
                s = step if upward else count - 1 - step
                for d in range(half):
                    own_gas, black = in_gas[first + d, s], np.float32(opaque[s])
                    if own_gas != np.float32(1.0):
                        for y in range(rows):
                            for x in range(columns):
                                ray[d, y, x] = black + (ray[d, y, x] - black) * own_gas
                for y in range(rows):
                    low, end = first_of_row[s, y], first_of_row[s, y + 1]
                    if low == end:
                        continue
                    at_x = column_of[low:end]
                    for d in range(half):
                        along = ray[d, (y - displaced[order, first + d, s, 0]) % rows]
                        back, ring = displaced[order, first + d, s, 1], d // AZIMUTHS
                        ours, light = source[first + d, low:end], mean[first + d, low:end]
                        through, within = kept[ring, low:end], inside[ring, low:end]
                        for n in range(at_x.size):
                            at = at_x[n] - back
                            at += columns if at < 0 else 0
                            excess = along[at] - ours[n]
                            along[at] = ours[n] + excess * through[n]
                            light[n] = ours[n] + excess * within[n]
        mix_kinds(mean, coupled, turn, first_of_kind, source)
        if order < displaced.shape[0] - 1:
            for s in range(count):
                low, end, own_sun = first_of_row[s, 0], first_of_row[s, rows], of_sun[kind[s]]
                for d in range(DIRECTIONS):
                    ours, sun = source[d, low:end], fixed[low:end]
                    for n in range(sun.size):
                        ours[n] += np.float32(emission[s]) + np.float32(own_sun[d]) * sun[n]
    result = np.zeros((count, rows, columns), dtype=np.float32)
    for s in range(count):
        shares = toward[kind[s]]
        for y in range(rows):
            for voxel in range(first_of_row[s, y], first_of_row[s, y + 1]):
                for d in range(DIRECTIONS):
                    result[s, y, column_of[voxel]] += shares[d] * mean[d, voxel]
    return result, source, number


@kernel()
def mix_kinds(light: Any, coupled: Any, turn: Any, first: Any, scattered: Any) -> None:
    """Write the light (D, N) that all voxels scatter; those of each kind of particles follow each other."""
    for k in range(coupled.shape[0]):
        mix(light, coupled[k], turn, first[k], first[k + 1], scattered)


@kernel()
def mix(light: Any, coupled: Any, turn: Any, first_of_all: int, end: int, scattered: Any) -> None:
    """Write the light (D, N) that some voxels scatter along each direction; see :func:`coupling`."""
    harmonics = np.empty((4, RINGS, BLOCK), dtype=np.float32)
    mixed = np.empty((4, BLOCK), dtype=np.float32)
    for start in range(first_of_all, end, BLOCK):
        size = min(BLOCK, end - start)
        for ring in range(RINGS):
            first, second = light[4 * ring, start : start + size], light[4 * ring + 1, start : start + size]
            third, fourth = light[4 * ring + 2, start : start + size], light[4 * ring + 3, start : start + size]
            cosine, sine = turn[ring, 0], turn[ring, 1]
            for n in range(size):
                even, odd = first[n] + third[n], second[n] + fourth[n]
                x, y = first[n] - third[n], second[n] - fourth[n]
                harmonics[0, ring, n], harmonics[1, ring, n] = even + odd, even - odd
                harmonics[2, ring, n], harmonics[3, ring, n] = x * cosine - y * sine, x * sine + y * cosine
        for ring in range(RINGS):
            for harmonic in range(4):
                a, b, c, d = coupled[harmonic, ring]
                for n in range(size):
                    mixed[harmonic, n] = (
                        a * harmonics[harmonic, 0, n] + b * harmonics[harmonic, 1, n]
                        + c * harmonics[harmonic, 2, n] + d * harmonics[harmonic, 3, n]
                    )  # fmt: skip
            first, second = scattered[4 * ring, start : start + size], scattered[4 * ring + 1, start : start + size]
            third, fourth = scattered[4 * ring + 2, start : start + size], scattered[4 * ring + 3, start : start + size]
            cosine, sine = turn[ring, 0], turn[ring, 1]
            for n in range(size):
                even, odd = mixed[0, n] + mixed[1, n], mixed[0, n] - mixed[1, n]
                x, y = mixed[2, n] * cosine + mixed[3, n] * sine, mixed[3, n] * cosine - mixed[2, n] * sine
                first[n], third[n], second[n], fourth[n] = even + x, even - x, odd + y, odd - y
