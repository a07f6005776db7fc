"""Radiance of a frame: table look-up for every point of the image and averaging over each pixel, in one pass.

For each point every band and term is interpolated linearly in the thickness of each cloud layer; then the points of a
pixel are averaged. The kernels find the interval of a thickness with a guide table over the leading bits of its
single-precision representation, which approximate its logarithm. Where pixels differ in more than their clouds, tables
of several states are looked up together, with weights of each pixel.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.radiance_tables import DenseTable, RadianceTables

__all__ = ["LookUp"]

Thickness = NDArray[np.float32]

ROUNDING = 1e-6
"""Relative rounding of float32 thickness: values this far beyond the outermost nodes are clipped."""

ENTRIES_PER_NODE = 4
"""Minimum entries of the guide table per node, so that the search rarely needs a second step."""

MANTISSA_BITS = 23

PIXELS_AT_ONCE = 64
"""Number of neighbouring pixels whose radiance is written together."""

_EVERYWHERE = np.ones((1, 1, 1, 1))
"""Weight of the one state."""


class LookUp:
    """Look-up of band radiance, W m-2 sr-1, in the tables of one instant.

    Parameters
    ----------
    table : DenseTable
    before : LookUp, optional
        Of another instant; its guides are reused if the tables share their nodes.
    """

    def __init__(self, table: DenseTable, before: LookUp | None = None) -> None:
        self.table = table
        self._guides: list[tuple[NDArray[np.int32], int, int]]
        if before is not None and before.table.nodes_m is table.nodes_m:
            self._guides = before._guides
        else:
            self._guides = [_guide(nodes) for nodes in table.nodes_m]
        self._present = [number for number, nodes in enumerate(table.nodes_m) if nodes.size]
        # Clear sky is a separate interval before the nodes.
        self._cores = tuple(
            np.ascontiguousarray(np.concatenate((core[:, :, :1], core), axis=2).transpose(2, 0, 1, 3))
            for core in table.columns.cores
        )
        self._by_state = (
            np.ascontiguousarray(self._cores[0][..., 0].transpose(1, 2, 0)) if len(self._cores) == 1 else None
        )

    @classmethod
    def at(cls, tables: RadianceTables, time_s: float) -> LookUp:
        """Return the look-up at a time, in seconds after the start, within the nodes of the tables."""
        return cls(tables.at(time_s))

    def fill(
        self,
        radiance: NDArray[np.float32],
        thickness_m: Sequence[Thickness],
        samples: int = 1,
        corner: tuple[int, int] = (0, 0),
        weights: Array = _EVERYWHERE,
    ) -> None:
        """Write the radiance of a window of the image.

        Parameters
        ----------
        radiance : ndarray of float32 (C, y, x)
            Radiance of the whole image, every band and term; the window is filled.
        thickness_m : sequence of ndarray of float32 (window rows x samples, window columns x samples)
            Thickness of each layer at the points of the window; 0 without cloud. Without layers, the whole image is
            filled.
        samples : int
            Points along each side of a pixel.
        corner : (int, int)
            First row and column of the window, in pixels.
        weights : ndarray (window rows or 1, window columns or 1, C or 1, R)
            Of the states of the table, in each pixel.

        Raises
        ------
        ProviderError
            If a thickness is outside its layer's table.
        """
        table, (row, column) = self.table, corner
        layers = [np.ascontiguousarray(thickness) for thickness in thickness_m]
        for values, nodes in zip(layers, table.nodes_m, strict=len(layers) > 0):
            if nodes.size == 0:
                _refuse_outside(values, nodes)
        if not self._cores or not layers:
            rows, columns = weights.shape[:2] if not layers else (size // samples for size in layers[0].shape)
            filled = (
                radiance[:, row : row + rows, column : column + columns]
                if layers or weights is not _EVERYWHERE
                else radiance
            )
            mixed = np.moveaxis(np.einsum("yxcr,rc->yxc", weights, table.clear), 2, 0)
            filled[...] = mixed if weights is _EVERYWHERE else np.maximum(mixed, 0.0)
            return
        # A scene has the same bits with a layer that never has cloud as without it.
        places = tuple(
            (layers[number], layers[number].view(np.int32), table.nodes_m[number], *self._guides[number])
            for number in self._present
        )
        if len(places) == 1 and table.clear.shape[0] == 1 and weights is _EVERYWHERE:
            by_node = self._cores[0][:, :, 0, 0]
            if samples == 1:
                inside = _points(radiance, row, column, np.ascontiguousarray(by_node.T), places[0])
            else:
                inside = _one_layer(radiance, row, column, samples, by_node, places[0])
        elif len(places) == 1 and samples == 1 and table.bands == 0:
            inside = _of_states(radiance, row, column, weights, self._by_state, places[0])
        else:
            inside = _several(radiance, row, column, samples, table.clear, table.bands, weights, self._cores, places)
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
def _points(radiance, row, column, table, layer):  # type: ignore[no-untyped-def]
    """Faster, bit-identical version of :func:`_one_layer` for one point per pixel.

    ``table`` (C, 2 + N) has clear sky twice before the nodes. Returns False if a thickness is outside the table.
    """
    channels, (height, width) = table.shape[0], layer[0].shape
    interval, share = np.empty(PIXELS_AT_ONCE, np.uint32), np.empty(PIXELS_AT_ONCE)
    for y in range(height):
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            if not _place(interval, share, y, slice(left, left + count), layer):
                return False
            for c in range(channels):
                values, plane = table[c], radiance[c, row + y, column + left : column + left + count]
                for x in range(count):
                    low, high = values[interval[x]], values[interval[x] + np.uint32(1)]
                    plane[x] = np.float32(low + share[x] * (high - low))
    return True


@kernel(inner=True)
def _place(interval, share, i, points, layer):  # type: ignore[no-untyped-def]
    """Set interval and position, 0 to 1, of points of row i; 0 and 0 without cloud. False if one is outside."""
    thickness, bits, nodes, guide, shift, first = layer
    values, bits_of = thickness[i, points], bits[i, points]
    lowest, highest = np.inf, np.inf
    if nodes.size:
        lowest, highest = nodes[0] * (1 - ROUNDING), nodes[nodes.size - 1] * (1 + ROUNDING)
    # Unsigned numbers: for signed ones every access would test whether it counts from the end.
    one, last = np.uint32(1), np.uint32(nodes.size - 2)
    for x in range(values.size):
        value = np.float64(values[x])
        if value <= 0.0:
            interval[x], share[x] = np.uint32(0), 0.0
            continue
        if not lowest <= value <= highest:  # NaN is neither below nor above
            return False
        index = np.uint32(guide[np.uint32((bits_of[x] >> shift) - first)])
        while index < last and nodes[index + one] <= value:
            index = np.uint32(index + one)
        low, high = nodes[index], nodes[index + one]
        interval[x], share[x] = np.uint32(index + 2), (min(max(value, low), high) - low) / (high - low)
    return True


@kernel()
def _one_layer(radiance, row, column, samples, table, layer):  # type: ignore[no-untyped-def]
    """Fill a window of a scene with one layer; False if a thickness is outside its table.

    ``table`` (2 + N, C) has clear sky twice before the nodes.
    """
    thickness, flat, step = layer[0], table.reshape(-1), np.uint32(table.shape[1])
    channels, width = table.shape[1], thickness.shape[1] // samples
    index, part = np.empty(PIXELS_AT_ONCE * samples, np.uint32), np.empty(PIXELS_AT_ONCE * samples)
    sums = np.empty((PIXELS_AT_ONCE, channels))
    for y in range(thickness.shape[0] // samples):
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            points = slice(left * samples, (left + count) * samples)
            sums[:] = 0.0
            for i in range(y * samples, (y + 1) * samples):
                if not _place(index, part, i, points, layer):
                    return False
                for x in range(count):
                    for j in range(x * samples, (x + 1) * samples):
                        k, share = index[j] * step, part[j]
                        for c in range(channels):
                            n = k + np.uint32(c)
                            sums[x, c] += flat[n] + share * (flat[n + step] - flat[n])
            _write(radiance, row + y, column + left, sums, count, 1.0 / (samples * samples))
    return True


@kernel()
def _of_states(radiance, row, column, weights, table, layer):  # type: ignore[no-untyped-def]
    """Faster version of :func:`_several` for one layer, one point per pixel and no term but the total and some others.

    ``table`` (C, R, 2 + N). Returns False if a thickness is outside the table.
    """
    (channels, states), (height, width) = table.shape[:2], layer[0].shape
    interval, share = np.empty(PIXELS_AT_ONCE, np.uint32), np.empty(PIXELS_AT_ONCE)
    sums = np.empty(PIXELS_AT_ONCE)
    for y in range(height):
        of_row = weights[y if weights.shape[0] > 1 else 0]
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            if not _place(interval, share, y, slice(left, left + count), layer):
                return False
            for c in range(channels):
                sums[:] = 0.0
                own = c if of_row.shape[1] > 1 else 0
                for r in range(states):
                    values = table[c, r]
                    for x in range(count):
                        low, high = values[interval[x]], values[interval[x] + np.uint32(1)]
                        weight = of_row[left + x if of_row.shape[0] > 1 else 0, own, r]
                        sums[x] += weight * (low + share[x] * (high - low))
                for x in range(count):
                    radiance[c, row + y, column + left + x] = np.float32(max(sums[x], 0.0))
    return True


@kernel()
def _several(radiance, row, column, samples, clear, bands, weights, tables, layers):  # type: ignore[no-untyped-def]
    """Fill a window of a scene with several layers, or several states; False if a thickness is outside its table.

    ``tables`` (2 + N, C, r, s) of each layer have no cloud twice before the nodes, so that no point is a special case.
    ``clear`` (R, C); ``weights`` (y, x, C, R), of which the first three may be 1; ``bands`` as of :class:`DenseTable`.
    """
    channels, states = clear.shape[1], clear.shape[0]
    height, width = layers[0][0].shape[0] // samples, layers[0][0].shape[1] // samples
    largest = states
    for table in tables:
        largest = max(largest, table.shape[3])
    points, count_of = PIXELS_AT_ONCE * samples, len(layers)
    index, part = np.empty((count_of, points), np.uint32), np.empty((count_of, points))
    sums, ahead, after = np.empty((PIXELS_AT_ONCE, channels)), np.empty(largest), np.empty(largest)
    values = np.empty(channels)
    for y in range(height):
        of_row = weights[y if weights.shape[0] > 1 else 0]
        for left in range(0, width, PIXELS_AT_ONCE):
            count = min(PIXELS_AT_ONCE, width - left)
            inside = slice(left * samples, (left + count) * samples)
            sums[:] = 0.0
            for i in range(y * samples, (y + 1) * samples):
                for number, layer in enumerate(layers):
                    if not _place(index[number], part[number], i, inside, layer):
                        return False
                for x in range(count):
                    of_pixel = of_row[left + x if of_row.shape[0] > 1 else 0]
                    for j in range(x * samples, (x + 1) * samples):
                        cloudy = False
                        for number in range(count_of):
                            cloudy = cloudy or index[number, j] > 0
                        for c in range(channels):
                            shares = of_pixel[c if of_pixel.shape[0] > 1 else 0]
                            if not cloudy:
                                values[c] = 0.0
                                for r in range(states):
                                    values[c] += shares[r] * clear[r, c]
                                continue
                            for r in range(states):
                                ahead[r] = shares[r]
                            for number, table in enumerate(tables):
                                low, high = table[index[number, j], c], table[index[number, j] + np.uint32(1), c]
                                share = part[number, j]
                                after[: low.shape[1]] = 0.0
                                for r in range(low.shape[0]):
                                    factor = ahead[r]
                                    for s in range(low.shape[1]):
                                        after[s] += factor * (low[r, s] + share * (high[r, s] - low[r, s]))
                                ahead, after = after, ahead
                            values[c] = ahead[0]
                        _none_negative(values, bands)
                        for c in range(channels):
                            sums[x, c] += values[c]
            _write(radiance, row + y, column + left, sums, count, 1.0 / (samples * samples))
    return True


@kernel(inner=True)
def _none_negative(values, bands):  # type: ignore[no-untyped-def]
    """Set what vanishes and became negative between nodes to 0; the largest term takes it, so that their sum stays."""
    for c in range(values.size):
        if values[c] < 0.0:
            if bands > 0 and c >= bands:
                largest = c
                for other in range(c % bands + bands, values.size, bands):
                    if values[other] > values[largest]:
                        largest = other
                values[largest] += values[c]
            values[c] = 0.0


@kernel(inner=True)
def _write(radiance, row, column, sums, count, share):  # type: ignore[no-untyped-def]
    """Write means of neighbouring pixels plane by plane, several times as fast as pixel by pixel."""
    for c in range(sums.shape[1]):
        for x in range(count):
            radiance[c, row, column + x] = np.float32(sums[x, c] * share)
