"""Compiled loops of live frames: rays at the nodes of a mesh, and the look-up of the sky and its radiance."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel

TILE, BORDER = 256, 1
"""Points along each side of a tile, and those it shares with the next."""

WIDE = TILE + BORDER

VALUE_STEP = np.float32(2e-4)
"""Step of the field in a tile of 16 bits, which ends 6.55 standard deviations from 0."""

CHUNK_PIXELS = 512
"""Neighbouring pixels that are computed together; a multiple of any step of the mesh."""

TABLE_PER_VALUE, TABLE_HALF = 100.0, 700
"""Intervals of the table of radiance per standard deviation of the field, and those below the cloud's edge."""


@kernel()
def node_places(directions: Any, turn: Any, origin: Any, axes: Any, frame: Any, powers: Any, fit: Any, out: Any) -> Any:
    """Write the places that the nodes of a mesh see; return the number of nodes beyond the limb.

    Parameters
    ----------
    directions : ndarray (N, M, 3)
        Unit vectors in the body.
    turn : ndarray (3, 3)
        From the body to the Earth.
    origin : ndarray (3,)
        Earth-fixed position of the camera.
    axes : ndarray (3,)
        Semi-axes of the surface.
    frame : ndarray (3, 3)
        Rows: centre, and east and north of the plane of the fit, over its size.
    powers, fit : ndarray (K, 2), (K, 2)
        Exponents of east and north, and coefficients of x and y.
    out : ndarray (N, M, 2)
        x and y in the plane of the scene; NaN beyond the limb or the fit.
    """
    missed = 0
    most = 0
    for k in range(powers.shape[0]):
        most = max(most, powers[k, 0], powers[k, 1])
    east_powers, north_powers = np.ones(most + 1), np.ones(most + 1)
    sx, sy, sz = origin[0] / axes[0], origin[1] / axes[1], origin[2] / axes[2]
    for i in range(directions.shape[0]):
        for j in range(directions.shape[1]):
            a, b, c = directions[i, j, 0], directions[i, j, 1], directions[i, j, 2]
            dx = turn[0, 0] * a + turn[0, 1] * b + turn[0, 2] * c
            dy = turn[1, 0] * a + turn[1, 1] * b + turn[1, 2] * c
            dz = turn[2, 0] * a + turn[2, 1] * b + turn[2, 2] * c
            # As hcss_payload.rays.meet: the point closest to the centre decides.
            px, py, pz = dx / axes[0], dy / axes[1], dz / axes[2]
            square = px * px + py * py + pz * pz
            along = -(sx * px + sy * py + sz * pz) / square
            cx, cy, cz = sx + along * px, sy + along * py, sz + along * pz
            inside = (1.0 - (cx * cx + cy * cy + cz * cz)) / square
            distance = along - np.sqrt(max(inside, 0.0))
            if inside < 0.0 or distance <= 0.0:
                missed += 1
                out[i, j, 0], out[i, j, 1] = np.nan, np.nan
                continue
            x = origin[0] + distance * dx - frame[0, 0]
            y = origin[1] + distance * dy - frame[0, 1]
            z = origin[2] + distance * dz - frame[0, 2]
            east = frame[1, 0] * x + frame[1, 1] * y + frame[1, 2] * z
            north = frame[2, 0] * x + frame[2, 1] * y + frame[2, 2] * z
            if not (abs(east) <= 1.0 and abs(north) <= 1.0):
                missed += 1
                out[i, j, 0], out[i, j, 1] = np.nan, np.nan
                continue
            for k in range(most):
                east_powers[k + 1] = east_powers[k] * east
                north_powers[k + 1] = north_powers[k] * north
            u, v = 0.0, 0.0
            for k in range(powers.shape[0]):
                both = east_powers[powers[k, 0]] * north_powers[powers[k, 1]]
                u += fit[k, 0] * both
                v += fit[k, 1] * both
            out[i, j, 0], out[i, j, 1] = u, v
    return missed


@kernel()
def to_points(places: Any, x: Any, y: Any, point_m: Any) -> Any:
    """Turn places (N, M, 2) in m, moved by x and y, into points in place; return the smallest and largest x and y.

    numpy would allocate as much as there are places.
    """
    low_x = low_y = np.inf
    high_x = high_y = -np.inf
    for i in range(places.shape[0]):
        for j in range(places.shape[1]):
            own_x, own_y = (places[i, j, 0] + x) / point_m, (places[i, j, 1] + y) / point_m
            places[i, j, 0], places[i, j, 1] = own_x, own_y
            low_x, high_x = min(low_x, own_x), max(high_x, own_x)
            low_y, high_y = min(low_y, own_y), max(high_y, own_y)
    return low_x, low_y, high_x, high_y


@kernel()
def between_samples(values: Any, nodes: Any, parts: Any, corner: Any, out: Any) -> None:
    """Write what is between samples (Y, X) from a corner (row, column) on, at the nodes of a mesh and between them.

    Parameters
    ----------
    nodes : ndarray (N, M, 2)
        Places as column and row of samples.
    parts : int
        Places along each side between two nodes, of which the first is a node.
    out : ndarray ((N - 1) x parts + 1, (M - 1) x parts + 1)
    """
    for i in range(out.shape[0]):
        by = min(i // parts, nodes.shape[0] - 2)
        down = i / parts - by
        for j in range(out.shape[1]):
            bx = min(j // parts, nodes.shape[1] - 2)
            right = j / parts - bx
            x, y = 0.0, 0.0
            for k in range(4):
                weight = (down if k > 1 else 1.0 - down) * (right if k % 2 else 1.0 - right)
                x += weight * nodes[by + k // 2, bx + k % 2, 0]
                y += weight * nodes[by + k // 2, bx + k % 2, 1]
            x, y = x - corner[1], y - corner[0]
            column, row = np.int64(np.floor(x)), np.int64(np.floor(y))
            x, y = x - column, y - row
            near = values[row, column] + x * (values[row, column + 1] - values[row, column])
            far = values[row + 1, column] + x * (values[row + 1, column + 1] - values[row + 1, column])
            out[i, j] = near + y * (far - near)


@kernel()
def pack(first: Any, second: Any, tile: Any) -> None:
    """Write two keyframes (WIDE, WIDE) of the field into a tile (WIDE, WIDE, 2) of 16 bits."""
    per = np.float32(1.0) / VALUE_STEP
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            a = min(max(np.rint(first[y, x] * per), np.float32(-32767)), np.float32(32767))
            b = min(max(np.rint(second[y, x] * per), np.float32(-32767)), np.float32(32767))
            tile[y, x, 0], tile[y, x, 1] = np.int16(a), np.int16(b)


@kernel(inner=True)
def _place_block(nodes: Any, by: Any, bx: Any, slots: Any, first: Any, corner: Any, places: Any) -> Any:
    """Write what all rows of a block of pixels share.

    Parameters
    ----------
    corner : ndarray (8,)
        Place of the upper left node, x and y, relative to a whole point near the block, which only the block decides;
        those of the nodes to its right, below and across from it, relative to the upper left one.
    places : ndarray of int64 (5,)
        Upper left point in the pool, or -1 if the block lies in several tiles; column and row of the whole point in its
        tile, and column and row of this tile.
    """
    u, v = nodes[by, bx, 0], nodes[by, bx, 1]
    u01, v01 = nodes[by, bx + 1, 0] - u, nodes[by, bx + 1, 1] - v
    u10, v10 = nodes[by + 1, bx, 0] - u, nodes[by + 1, bx, 1] - v
    u11, v11 = nodes[by + 1, bx + 1, 0] - u, nodes[by + 1, bx + 1, 1] - v
    corner_x = np.int64(np.floor(u + min(min(0.0, u01), min(u10, u11)))) - 1
    corner_y = np.int64(np.floor(v + min(min(0.0, v01), min(v10, v11)))) - 1
    du, dv = u - corner_x, v - corner_y
    corner[0], corner[1], corner[2], corner[3] = du, dv, u01, v01
    corner[4], corner[5], corner[6], corner[7] = u10, v10, u11, v11
    reach_x = du + max(max(0.0, u01), max(u10, u11))
    reach_y = dv + max(max(0.0, v01), max(v10, v11))
    tile_x, tile_y = corner_x // TILE, corner_y // TILE
    in_x, in_y = corner_x - tile_x * TILE, corner_y - tile_y * TILE
    places[0], places[1], places[2], places[3], places[4] = -1, in_x, in_y, tile_x, tile_y
    if in_x + reach_x + 1.0 < TILE and in_y + reach_y + 1.0 < TILE:
        places[0] = slots[tile_y - first[0], tile_x - first[1]] * (WIDE * WIDE) + in_y * WIDE + in_x


@kernel(inner=True, inline="always")
def _place_points(
    corner: Any,
    block: Any,
    part: Any,
    step: Any,
    slots: Any,
    first: Any,
    start: Any,
    places: Any,
    across: Any,
    down: Any,
) -> None:
    """Write the upper left points in the pool, and the places after them, of a row of a block."""
    f, size = np.float32, WIDE * WIDE
    du, dv, u01, v01 = corner[0], corner[1], corner[2], corner[3]
    u10, v10, u11, v11 = corner[4], corner[5], corner[6], corner[7]
    x0, x1 = f(du + part * u10), f(du + u01 + part * (u11 - u01))
    y0, y1 = f(dv + part * v10), f(dv + v01 + part * (v11 - v01))
    step_x, step_y = (x1 - x0) / f(step), (y1 - y0) / f(step)
    if block[0] >= 0:
        base = np.int32(block[0])
        for x in range(step):
            place_x, place_y = x0 + f(x) * step_x, y0 + f(x) * step_y
            whole_x, whole_y = np.int32(place_x), np.int32(place_y)
            across[start + x], down[start + x] = place_x - f(whole_x), place_y - f(whole_y)
            places[start + x] = np.uint32(base + whole_y * np.int32(WIDE) + whole_x)
    else:
        in_x, in_y, tile_x, tile_y = block[1], block[2], block[3], block[4]
        for x in range(step):
            place_x, place_y = x0 + f(x) * step_x, y0 + f(x) * step_y
            whole_x, whole_y = np.int32(place_x), np.int32(place_y)
            across[start + x], down[start + x] = place_x - f(whole_x), place_y - f(whole_y)
            more_x, more_y = (in_x + whole_x) // TILE, (in_y + whole_y) // TILE
            slot = slots[tile_y + more_y - first[0], tile_x + more_x - first[1]]
            rest = (in_y + whole_y - more_y * TILE) * WIDE + in_x + whole_x - more_x * TILE
            places[start + x] = np.uint32(slot * size + rest)


@kernel(inner=True)
def _gather_points(pool: Any, places: Any, around: Any) -> None:
    """Write the four points (4, X) of the pool around each pixel of a row: at its place, beside, below and across.

    Nothing waits for these loads, so that many are under way at once; arithmetic between them would take twice as long.
    """
    one, line, both = np.uint32(1), np.uint32(WIDE), np.uint32(WIDE + 1)
    beside, below, across = around[1], around[2], around[3]
    nearest = around[0]
    for x in range(places.size):
        k = places[x]
        nearest[x], beside[x], below[x], across[x] = pool[k], pool[k + one], pool[k + line], pool[k + both]


@kernel(inner=True)
def _look_up_points(around: Any, across: Any, down: Any, later: Any, field: Any) -> None:
    """Write the field, in steps, between the four points of each pixel of a row.

    A number of the pool holds both keyframes, the first in its lower half.
    """
    f, i = np.float32, np.int32
    low = np.int32(16)
    nearest, beside, below, opposite = around[0], around[1], around[2], around[3]
    for x in range(field.size):
        p, q, r, s = nearest[x], beside[x], below[x], opposite[x]
        a, b = f(i(p << low) >> low), f(i(q << low) >> low)
        c, d = f(i(r << low) >> low), f(i(s << low) >> low)
        a += later * (f(p >> low) - a)
        b += later * (f(q >> low) - b)
        c += later * (f(r >> low) - c)
        d += later * (f(s >> low) - d)
        top = a + across[x] * (b - a)
        bottom = c + across[x] * (d - c)
        field[x] = top + down[x] * (bottom - top)


@kernel(inner=True)
def _place_values(field: Any, per: Any, middle: Any, most: Any, step: Any, part: Any, places: Any) -> None:
    """Write where the values of a row are in a flat table with ``step`` numbers in an interval, and the parts of it."""
    f = np.float32
    for x in range(field.size):
        at = field[x] * per + middle
        at = at if at > f(0.0) else f(0.0)
        at = at if at < most else most
        interval = np.int32(at)
        part[x], places[x] = at - f(interval), np.uint32(interval) * step


@kernel(inner=True)
def _between_nodes(values: Any, y: Any, first: Any, step: Any, row: Any) -> None:
    """Write a row y of pixels, from the pixel of a node on, between nodes (N, M) that are some steps apart."""
    f = np.float32
    above, below = values[y // step], values[y // step + 1]
    part, per = f(y % step) / f(step), f(1.0) / f(step)
    near = above[first // step] + part * (below[first // step] - above[first // step])
    for node in range(-(-row.size // step)):
        column = first // step + node + 1
        far = above[column] + part * (below[column] - above[column])
        change, left = (far - near) * per, node * step
        for x in range(min(step, row.size - left)):
            row[left + x] = near + f(x) * change
        near = far


@kernel(inner=True)
def _look_up_radiance(table: Any, places: Any, part: Any, band: Any, values: Any, more: Any, row: Any) -> None:
    """Write the radiance of a band of a row, with what clear pixels have more; ``values`` (4, X) is overwritten."""
    first = np.uint32(4 * band)
    second, third, fourth = first + np.uint32(1), first + np.uint32(2), first + np.uint32(3)
    start, change, shown, fading = values[0], values[1], values[2], values[3]
    for x in range(row.size):
        k = places[x]
        start[x], change[x], shown[x], fading[x] = (
            table[k + first],
            table[k + second],
            table[k + third],
            table[k + fourth],
        )
    for x in range(row.size):
        row[x] = start[x] + part[x] * change[x] + more[x] * (shown[x] + part[x] * fading[x])


@kernel()
def sky_rows(
    nodes: Any,
    step: Any,
    rows: Any,
    pool: Any,
    slots: Any,
    first: Any,
    later: Any,
    table: Any,
    middle: Any,
    clear: Any,
    fine: Any,
    radiance: Any,
) -> None:
    """Write the radiance of the rows of a strip of blocks.

    Parameters
    ----------
    nodes : ndarray (N, M, 2)
        Places of the nodes in the sky, x and y in points of the tiles.
    step : int
        Pixels between nodes.
    rows : (int, int)
        First block row and the one after the last.
    pool : ndarray of int32 (S x WIDE x WIDE)
        Tiles, flat; both keyframes of a point in one number.
    slots : ndarray of int64 (Y, X)
        Position of each tile in the pool.
    first : (int, int)
        Row and column of the first tile in ``slots``.
    later : float32
        Weight of the second keyframe.
    table : ndarray of float32 (I x B x 4)
        Flat: radiance at the start of each interval of the field, and its change over it; then the share of what clear
        pixels have more that shows there, and its change.
    middle : float32
        Position of the field's value 0 in the table, in intervals.
    clear : ndarray of float32 (B, n, m)
        What clear pixels have more at finer nodes.
    fine : int
        Pixels between these.
    radiance : ndarray of float32 (B, rows, columns)
    """
    f = np.float32
    bands, height, width = radiance.shape
    blocks = nodes.shape[1] - 1
    per, most = f(TABLE_PER_VALUE) * VALUE_STEP, f(table.size // (4 * bands) - 1)
    # A chunk of blocks is small enough for the cache, whatever the direction of the rows in the sky.
    chunk = CHUNK_PIXELS // step
    places, field = np.empty(chunk * step, np.uint32), np.empty(chunk * step, np.float32)
    across, down = np.empty(chunk * step, np.float32), np.empty(chunk * step, np.float32)
    around, values = np.empty((4, chunk * step), np.int32), np.empty((4, chunk * step), np.float32)
    more = np.empty(chunk * step, np.float32)
    corners, of_blocks = np.empty((chunk, 8)), np.empty((chunk, 5), np.int64)
    for by in range(rows[0], rows[1]):
        for left in range(0, blocks, chunk):
            right = min(left + chunk, blocks)
            count = min(right * step, width) - left * step
            for bx in range(left, right):
                _place_block(nodes, by, bx, slots, first, corners[bx - left], of_blocks[bx - left])
            for y in range(by * step, min((by + 1) * step, height)):
                part = (y - by * step) / step
                for b in range(right - left):
                    corner, block = corners[b], of_blocks[b]
                    _place_points(corner, block, part, step, slots, first, b * step, places, across, down)
                _gather_points(pool, places[:count], around)
                _look_up_points(around, across, down, later, field[:count])
                _place_values(field[:count], per, middle, most, np.uint32(4 * bands), across, places)
                for c in range(bands):
                    row = radiance[c, y, left * step : left * step + count]
                    _between_nodes(clear[c], y, left * step, fine, more[:count])
                    _look_up_radiance(table, places, across, c, values, more, row)
