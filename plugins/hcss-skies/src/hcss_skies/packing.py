"""Films from large-eddy runs: ranks of optical thickness, tops and bases of chosen pieces.

Cloud has the rank of its optical thickness. Clear sky is ranked by how near cloud is in space and time, so that a
generator that adds to the scores makes clouds grow from their edges, and new ones where the film has some soon.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter1d

from hcss_skies.film import LEVELS, SNAPSHOTS, Bytes, Film, score_of
from hcss_skies.motion import motion_between
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError

CLOUDY = 0.05
"""Optical thickness above which a pixel is cloud. Near 10.8 um it is half as large: what is thinner cools an image by
0.025 of the contrast between sea and cloud, 0.1 K of 4 K for clouds near 0.6 km, 0.6 K of 25 K near 4 km."""

MOST_CLEAR, LEAST_CLEAR = 0.02, 0.98
"""Probability of the first rank where clouds are few, and of the last rank in sheets: what is beyond has no ranks."""

SNAPSHOTS_OF_PIECE = 30

APART_S = 5400.0
"""From the first picture of a film to the second piece: clouds have become other ones long since."""

OUTLIERS = 0.005, 0.999
"""Quantiles of bases and tops that limit the layer."""

LARGEST_BLOCK, LEAST_BLOCK = 16, 4
"""Cells along a side of the blocks of motion."""

OWN = "own computation"
"""Terms of use unless they are given."""

_NEAR_CELLS = 1.0
"""Smallest scale of the nearness of cloud; further ones are twice as large, up to a sixth of the box."""

_CELLS_PER_SNAPSHOT = 4.0
"""Scale of nearness in cells whose scale in time is one snapshot."""


@dataclass(frozen=True)
class _Run:
    """The chosen pictures of a run (pieces, snapshots, rows, columns), and what their file says."""

    thickness: Array
    top_m: Array
    base_m: Array
    cell_m: float
    interval_s: float
    title: str
    source: str
    frame_m_s: tuple[float, float]


def pack(
    path: Path,
    starts_h: Sequence[float] = (),
    *,
    snapshots: int = SNAPSHOTS_OF_PIECE,
    kind: str | None = None,
    licence: str = OWN,
) -> Film:
    """Return the film of a run of ``hcss skies simulate``.

    Parameters
    ----------
    path : Path
        The file of the run.
    starts_h : sequence of float
        Hours of the run at which pieces start; default: the first picture, and 90 min later, or as late as there are
        pictures for a piece.
    snapshots : int
        Pictures of a piece.
    kind : str, optional
        Kind of clouds; default: the title of the run.
    licence : str
        Terms of use.

    Raises
    ------
    CatalogError
        If the file is no run, is too short, or has no cloud.
    """
    low, high = SNAPSHOTS
    if not low <= snapshots <= high:
        raise CatalogError(f"{snapshots} snapshots; allowed: {low} to {high}")
    run = _read_run(path, starts_h, snapshots)
    rows, columns = run.thickness.shape[2:]
    block = _block(path, rows, columns)
    cloudy = run.thickness > CLOUDY
    cover = float(np.mean(cloudy))
    if cover == 0.0:
        raise CatalogError(f"{path}: no cloud of optical thickness above {CLOUDY:g} in {snapshots} pictures of a piece")
    sheet = cover > 0.5
    scores = _scores(cloudy.size, sheet)
    ranks, table = _ranked(run.thickness, cloudy, scores, sheet)
    top_m, base_m = (_where_cloudy(path, field, cloudy) for field in (run.top_m, run.base_m))
    bottom, top = float(np.quantile(base_m[cloudy], OUTLIERS[0])), float(np.quantile(top_m[cloudy], OUTLIERS[1]))
    parts = (_parts(field, cloudy, bottom, top) for field in (top_m, np.minimum(base_m, top_m)))
    of_top, of_base = parts
    return Film(
        ranks, table, scores, of_top, of_base, motion_between(ranks, block), block, run.cell_m, run.interval_s,
        bottom, top, sheet, kind or run.title, run.source, licence, run.frame_m_s,
    )  # fmt: skip


def _read_run(path: Path, starts_h: Sequence[float], snapshots: int) -> _Run:
    with Reading(path, CatalogError, "not a run of `hcss skies simulate`, or damaged").netcdf() as file:
        if getattr(file, "hcss_skies_simulation", None) != 1:
            raise CatalogError(f"{path}: no run of `hcss skies simulate`, whose pictures make films")
        file.set_auto_mask(False)
        time = np.asarray(file["time"][:], dtype=np.float64)
        firsts = _firsts(path, time, starts_h, snapshots)
        intervals = np.concatenate([np.diff(time[first : first + snapshots]) for first in firsts])
        if not (intervals[0] > 0.0 and np.allclose(intervals, intervals[0])):
            raise CatalogError(f"{path}: pictures {intervals.min():g} to {intervals.max():g} s apart; allowed: evenly")
        thickness, top_m, base_m = (
            np.stack([np.asarray(file[name][first : first + snapshots], dtype=np.float64) for first in firsts])
            for name in ("optical_thickness", "cloud_top", "cloud_base")
        )
        cells = [float(file[name][1]) - float(file[name][0]) for name in ("x", "y")]
        along_x, along_y = (float(speed) for speed in file.frame_m_s)
        run = _Run(
            thickness, top_m, base_m, cells[0], float(intervals[0]), str(file.title), str(file.source),
            (along_x, along_y),
        )  # fmt: skip
    if cells[0] <= 0.0 or not math.isclose(cells[0], cells[1], rel_tol=1e-6):
        raise CatalogError(f"{path}: cells of {cells[0]:g} x {cells[1]:g} m; allowed: squares")
    if not np.all(run.thickness >= 0.0):
        raise CatalogError(f"{path}: optical thickness that is missing or below 0")
    return run


def _firsts(path: Path, time: Array, starts_h: Sequence[float], snapshots: int) -> list[int]:
    """Return the numbers of the first pictures of the pieces."""
    last = time.size - snapshots
    if not starts_h:
        if last < snapshots:
            raise CatalogError(
                f"{path}: {time.size} pictures; allowed: {2 * snapshots} or more for two pieces of {snapshots}; fewer "
                "with --snapshots, or one piece with --start"
            )
        return [0, min(max(int(np.searchsorted(time, time[0] + APART_S)), snapshots), last)]
    firsts = []
    for hours in starts_h:
        near = int(np.argmin(np.abs(time - 3600.0 * hours)))
        if not abs(time[near] - 3600.0 * hours) < 1.0 or near > last:
            until = f"{time[0] / 3600:g} to {time[last] / 3600:g} h" if last >= 0 else f"none, {time.size} pictures"
            raise CatalogError(
                f"{path}: start {hours:g} h of {snapshots} snapshots; allowed: times of pictures, {until}"
            )
        firsts.append(near)
    return firsts


def _block(path: Path, rows: int, columns: int) -> int:
    common = math.gcd(rows, columns)
    block = max(size for size in range(1, LARGEST_BLOCK + 1) if common % size == 0)
    if block < LEAST_BLOCK:
        raise CatalogError(
            f"{path}: {rows} x {columns} cells; allowed: multiples of a number from {LEAST_BLOCK} to {LARGEST_BLOCK}"
        )
    return block


def _scores(pixels: int, sheet: bool) -> Array:
    """Return the scores (256,): up to the largest pixel, of sheets from the smallest one."""
    ends = np.array([0.5 / pixels, LEAST_CLEAR] if sheet else [MOST_CLEAR, 1.0 - 0.5 / pixels])
    first, last = score_of(ends, sheet)
    return np.linspace(first, last, LEVELS)


def _ranked(thickness: Array, cloudy: NDArray[np.bool_], scores: Array, sheet: bool) -> tuple[Bytes, Array]:
    """Return the ranks of all pixels, and the optical thickness (256,) at the ranks.

    The probability of a pixel is its place among all pixels. No rank is both of clear sky and of cloud.
    """
    near = np.stack([_nearness(piece) for piece in thickness])
    order = np.lexsort((near.ravel(), np.where(cloudy, thickness, 0.0).ravel()))
    u = np.empty(thickness.size)
    u[order] = (np.arange(thickness.size) + 0.5) / thickness.size
    step = scores[1] - scores[0]
    exact = (score_of(u, sheet).reshape(thickness.shape) - scores[0]) / step
    first = 0
    if not np.all(cloudy):
        edge = (score_of(np.array(1.0 - np.mean(cloudy)), sheet) - scores[0]) / step
        first = int(np.clip(math.floor(edge) + 1, 1, LEVELS - 1))
    ranks = np.clip(np.rint(exact), np.where(cloudy, first, 0), np.where(cloudy, LEVELS - 1, first - 1))
    ranks = ranks.astype(np.uint8)
    return ranks, _table(ranks[cloudy], thickness[cloudy], first)


def _table(ranks: Bytes, thickness: Array, first: int) -> Array:
    """Return the median optical thickness of each rank; ranks without a pixel are between their neighbours."""
    order = np.lexsort((thickness, ranks))
    ends = np.searchsorted(ranks[order], np.arange(first, LEVELS + 1))
    held = np.flatnonzero(np.diff(ends))
    medians = [float(np.median(thickness[order[ends[n] : ends[n + 1]]])) for n in held]
    table = np.zeros(LEVELS)
    table[first:] = np.maximum.accumulate(np.interp(np.arange(LEVELS - first), held, medians))
    return table


def _nearness(thickness: Array) -> Array:
    """Return how near cloud is in each pixel of a piece (snapshots, rows, columns): a smooth field without plateaus."""
    present = np.fft.rfft2(np.minimum(thickness, 1.0))
    shape = thickness.shape[1:]
    square = np.add.outer(np.fft.fftfreq(shape[0]) ** 2, np.fft.rfftfreq(shape[1]) ** 2)
    near, scale = np.zeros(thickness.shape), _NEAR_CELLS
    while scale <= max(8.0 * _NEAR_CELLS, max(shape) / 6.0):
        smooth = np.fft.irfft2(present * np.exp(-2.0 * (np.pi * scale) ** 2 * square), s=shape)
        near += gaussian_filter1d(smooth, scale / _CELLS_PER_SNAPSHOT, axis=0, mode="nearest")
        scale *= 2.0
    return near


def _where_cloudy(path: Path, field: Array, cloudy: NDArray[np.bool_]) -> Array:
    """Return altitudes, of the nearest pixel where cloud has none.

    A picture counts cells above a limit of water; a column of thinner ones can be cloud by its optical thickness. Cloud
    of a snapshot without any altitude has the median of all.
    """
    known = cloudy & np.isfinite(field)
    if not np.any(known):
        raise CatalogError(f"{path}: no tops or bases of cloud")
    filled = np.full(field.shape, float(np.median(field[known])))
    for piece, snapshot in np.ndindex(*field.shape[:2]):
        if np.any(known[piece, snapshot]):
            filled[piece, snapshot] = _nearest(field[piece, snapshot], known[piece, snapshot])
    return filled


def _nearest(field: Array, known: NDArray[np.bool_]) -> Array:
    """Return the values of the nearest known pixels of a periodic field."""
    margin = tuple((side // 2, side // 2) for side in field.shape)
    padded: Any = np.pad(known, margin, mode="wrap")
    places = distance_transform_edt(~padded, return_distances=False, return_indices=True)
    inner = tuple(slice(low, low + side) for (low, _), side in zip(margin, field.shape, strict=True))
    values: Array = np.pad(field, margin, mode="wrap")[tuple(places)][inner]
    return values


def _parts(field: Array, cloudy: NDArray[np.bool_], bottom_m: float, top_m: float) -> Bytes:
    """Return altitudes in 255ths of the layer, at least 1 in cloud."""
    parts = np.clip(np.rint((field - bottom_m) * (255.0 / (top_m - bottom_m))), 1.0, 255.0)
    return np.where(cloudy, parts, 0.0).astype(np.uint8)
