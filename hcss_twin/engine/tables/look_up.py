"""Radiance of a frame: table look-up for every point of the image and averaging over each pixel, in one pass.

For each point every band and term is interpolated linearly in the cloud thickness of one or both layers; then the
points of a pixel are averaged. The kernels find the interval of a thickness with a guide table over the leading bits
of its single-precision representation, which approximate its logarithm.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.radiance_tables import DenseTable

Thickness = NDArray[np.float32]

ROUNDING = 1e-6
"""Relative rounding of float32 thickness: values this far beyond the outermost nodes are clipped."""

ENTRIES_PER_NODE = 4
"""Minimum entries of the guide table per node, so that the search rarely needs a second step."""

MANTISSA_BITS = 23

PIXELS_AT_ONCE = 64
"""Number of neighbouring pixels whose radiance is written together."""


class LookUp:
    """Look-up in the tables of one instant.

    Parameters
    ----------
    table : DenseTable
        Table with at most two layers.
    before : LookUp, optional
        Of another instant; its guides are reused if the tables share their nodes.
    """

    def __init__(self, table: DenseTable, before: LookUp | None = None) -> None:
        self._table = table
        self._guides: list[tuple[NDArray[np.int32], int, int]]
        if before is not None and before._table.nodes_m is table.nodes_m:
            self._guides = before._guides
        else:
            self._guides = [_guide(nodes) for nodes in table.nodes_m]
        # Clear sky is a separate interval before the nodes, channel by channel.
        clear = table.clear[:, None]
        self._lifted = [np.concatenate((clear, clear, alone.T), axis=1) for alone in table.alone]

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
    ) -> None:
        """Write the radiance of a window of the image.

        Parameters
        ----------
        radiance : ndarray of float32 (C, y, x)
            Radiance of the whole image, every band and term; the window is filled.
        thickness_m : sequence of ndarray of float32 (window rows x samples, window columns x samples)
            Thickness of each layer at the points of the window; 0 without cloud.
        samples : int
            Points along each side of a pixel.
        corner : (int, int)
            First row and column of the window, in pixels.

        Raises
        ------
        ProviderError
            If a thickness is outside its layer's table.
        """
        table, (row, column) = self._table, corner
        layers = [np.ascontiguousarray(each) for each in thickness_m]
        if not layers:
            radiance[:] = table.clear[:, None, None]
            return
        if len(layers) == 1 and samples == 1:
            values, nodes = layers[0], table.nodes_m[0]
            inside = _points(
                radiance, row, column, self._lifted[0], values, values.view(np.int32), nodes, *self._guides[0]
            )
            if not inside:
                _refuse_outside(values, nodes)
            return
        arguments = (
            argument
            for values, nodes, guide, alone in zip(layers, table.nodes_m, self._guides, table.alone, strict=True)
            for argument in (values, values.view(np.int32), nodes, *guide, alone)
        )
        if len(layers) == 1:
            inside = _one_layer(radiance, row, column, samples, table.clear, *arguments)
        else:
            # Without a table for both layers no point can have both.
            both = np.empty((0, 0, table.clear.size), np.float32) if table.both is None else table.both
            inside = _two_layers(radiance, row, column, samples, table.clear, both, *arguments)
        if not inside:
            for values, nodes in zip(layers, table.nodes_m, strict=True):
                _refuse_outside(values, nodes)


def _refuse_outside(thickness_m: Thickness, nodes: Array) -> None:
    cloudy = thickness_m[~(thickness_m <= 0)].astype(np.float64)  # with NaN
    if cloudy.size == 0:
        return
    least, most = float(cloudy.min()), float(cloudy.max())
    if nodes.size == 0:
        raise ProviderError(f"cloud thickness {least:g} to {most:g} m; the layer's coverage is 0 and allows none")
    low, high = float(nodes[0]), float(nodes[-1])
    if not (low * (1 - ROUNDING) <= least and most <= high * (1 + ROUNDING)):
        raise ProviderError(f"cloud thickness {least:g} to {most:g} m; the layer allows {low:g} to {high:g} m")


def _guide(nodes: Array) -> tuple[NDArray[np.int32], int, int]:
    """Return the guide table of ascending nodes.

    Positive single-precision numbers have the order of their bits; the leading bits are the exponent and part of the
    mantissa.

    Returns
    -------
    guide : ndarray of int32
        For each value of the leading bits, the interval of the smallest number with these bits.
    shift, first : int
        Index of a number in the guide: bits >> shift, minus ``first``.
    """
    if nodes.size == 0:
        return np.zeros(0, np.int32), 0, 0
    ends = np.array([nodes[0] * (1 - 2 * ROUNDING), nodes[-1] * (1 + 2 * ROUNDING)], np.float32)
    low, high = (int(bits) for bits in ends.view(np.int32))
    shift = MANTISSA_BITS
    while shift > 0 and (high >> shift) - (low >> shift) < ENTRIES_PER_NODE * nodes.size:
        shift -= 1
    first = low >> shift
    entries = np.arange(first, (high >> shift) + 1, dtype=np.int64)
    smallest = (entries << shift).astype(np.int32).view(np.float32).astype(np.float64)
    index = np.clip(np.searchsorted(nodes, smallest, side="right") - 1, 0, nodes.size - 2)
    return index.astype(np.int32), shift, first


@kernel()
def _outside(thickness, nodes):  # type: ignore[no-untyped-def]
    """Whether a thickness is outside the nodes by more than rounding, or NaN."""
    if nodes.size == 0:
        return True
    # Not "below or above": NaN is neither, and must not be looked up.
    return not (nodes[0] * (1 - ROUNDING) <= thickness <= nodes[nodes.size - 1] * (1 + ROUNDING))


@kernel()
def _locate(thickness, bits, nodes, guide, shift, first):  # type: ignore[no-untyped-def]
    """Interval of a thickness, and its position in the interval, 0 to 1."""
    last = nodes.size - 2
    index = guide[(bits >> shift) - first]
    while index < last and nodes[index + 1] <= thickness:
        index += 1
    low, high = nodes[index], nodes[index + 1]
    inside = min(max(thickness, low), high)
    return index, (inside - low) / (high - low)


@kernel()
def _points(  # type: ignore[no-untyped-def]
    radiance, row, column, table, thickness, bits, nodes, guide, shift, first
):
    """Faster, bit-identical version of :func:`_one_layer` for one point per pixel.

    ``table`` (C, 2 + N) has clear sky twice before the nodes. Returns False if a thickness is outside the table.
    """
    channels, width = table.shape[0], thickness.shape[1]
    interval, share = np.empty(PIXELS_AT_ONCE, np.uint32), np.empty(PIXELS_AT_ONCE)
    for y in range(thickness.shape[0]):
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            for x in range(count):
                value = np.float64(thickness[y, left + x])
                if value <= 0.0:
                    interval[x], share[x] = np.uint32(0), 0.0
                    continue
                if _outside(value, nodes):
                    return False
                index, part = _locate(value, bits[y, left + x], nodes, guide, shift, first)
                interval[x], share[x] = np.uint32(index + 2), part
            for c in range(channels):
                values, plane = table[c], radiance[c, row + y, column + left : column + left + count]
                for x in range(count):
                    low, high = values[interval[x]], values[interval[x] + np.uint32(1)]
                    plane[x] = np.float32(low + share[x] * (high - low))
    return True


@kernel()
def _one_layer(  # type: ignore[no-untyped-def]
    radiance, row, column, samples, clear, thickness, bits, nodes, guide, shift, first, alone
):
    """Fill a window of a scene with one layer; False if a thickness is outside the table."""
    channels = clear.size
    width = thickness.shape[1] // samples
    sums = np.empty((min(width, PIXELS_AT_ONCE), channels))
    for y in range(thickness.shape[0] // samples):
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            for x in range(count):
                for c in range(channels):
                    sums[x, c] = 0.0
                clear_points = 0
                for i in range(y * samples, (y + 1) * samples):
                    for j in range((left + x) * samples, (left + x + 1) * samples):
                        value = np.float64(thickness[i, j])
                        if value <= 0.0:
                            clear_points += 1
                            continue
                        if _outside(value, nodes):
                            return False
                        index, part = _locate(value, bits[i, j], nodes, guide, shift, first)
                        _add_linear(sums, x, alone, index, part)
                if clear_points:
                    for c in range(channels):
                        sums[x, c] += clear_points * clear[c]
            _write(radiance, row + y, column + left, sums, count, 1.0 / (samples * samples))
    return True


@kernel()
def _two_layers(  # type: ignore[no-untyped-def]
    radiance, row, column, samples, clear, both,
    thickness_a, bits_a, nodes_a, guide_a, shift_a, first_a, alone_a,
    thickness_b, bits_b, nodes_b, guide_b, shift_b, first_b, alone_b,
):  # fmt: skip
    """Fill a window of a scene with two layers; False if a thickness is outside its table."""
    channels = clear.size
    width = thickness_a.shape[1] // samples
    sums = np.empty((min(width, PIXELS_AT_ONCE), channels))
    for y in range(thickness_a.shape[0] // samples):
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            for x in range(count):
                for c in range(channels):
                    sums[x, c] = 0.0
                clear_points = 0
                for i in range(y * samples, (y + 1) * samples):
                    for j in range((left + x) * samples, (left + x + 1) * samples):
                        a, b = np.float64(thickness_a[i, j]), np.float64(thickness_b[i, j])
                        if a > 0.0:
                            if _outside(a, nodes_a):
                                return False
                            index, part = _locate(a, bits_a[i, j], nodes_a, guide_a, shift_a, first_a)
                        if b > 0.0:
                            if _outside(b, nodes_b):
                                return False
                            above, rest = _locate(b, bits_b[i, j], nodes_b, guide_b, shift_b, first_b)
                        if a > 0.0 and b > 0.0:
                            _add_bilinear(sums, x, both, index, above, part, rest)
                        elif a > 0.0:
                            _add_linear(sums, x, alone_a, index, part)
                        elif b > 0.0:
                            _add_linear(sums, x, alone_b, above, rest)
                        else:
                            clear_points += 1
                if clear_points:
                    for c in range(channels):
                        sums[x, c] += clear_points * clear[c]
            _write(radiance, row + y, column + left, sums, count, 1.0 / (samples * samples))
    return True


@kernel()
def _add_linear(sums, x, table, index, part):  # type: ignore[no-untyped-def]
    """Add to ``sums[x]`` the value interpolated between two nodes of a table (N, C)."""
    for c in range(sums.shape[1]):
        low = table[index, c]
        sums[x, c] += low + part * (table[index + 1, c] - low)


@kernel()
def _add_bilinear(sums, x, table, index, above, part, rest):  # type: ignore[no-untyped-def]
    """Add to ``sums[x]`` the value interpolated between four nodes of a table (N, M, C)."""
    for c in range(sums.shape[1]):
        # In double precision: differences of single-precision numbers would lose digits.
        near, far = np.float64(table[index, above, c]), np.float64(table[index + 1, above, c])
        near += rest * (np.float64(table[index, above + 1, c]) - near)
        far += rest * (np.float64(table[index + 1, above + 1, c]) - far)
        sums[x, c] += near + part * (far - near)


@kernel()
def _write(radiance, row, column, sums, count, share):  # type: ignore[no-untyped-def]
    """Write means of neighbouring pixels plane by plane, several times as fast as pixel by pixel."""
    for c in range(sums.shape[1]):
        for x in range(count):
            radiance[c, row, column + x] = np.float32(sums[x, c] * share)
