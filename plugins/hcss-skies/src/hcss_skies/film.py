"""Films of clouds: what a large-eddy run left, packed so that a generator can play it, as NetCDF files.

A film has a few pieces of snapshots, periodic along y and x. A pixel has the rank of its optical thickness among all
pixels of the film, clear ones included, and cloud has a top and a base. Ranks are evenly spaced in a score, so that
the clouds of several patches meet by the larger score and cover is changed by adding to it: with Gumbel's score
-ln(-ln u) of the probability u, the larger of two scores shifted by the logarithms of weights that sum to 1 has the
distribution of one. In sheets, where holes are what is rare, it is mirrored, and the smaller one has (S. Coles, An
Introduction to Statistical Modeling of Extreme Values, Springer 2001, section 3.1.3: max-stability).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError, NetcdfFile

LEVELS = 256
"""Ranks of a film."""

MAX_CELLS = 7.0
"""Largest displacement along an axis between snapshots in cells."""

PER_CELL = 16
"""Steps of a displacement in a cell."""

SIDES, SNAPSHOTS, PIECES = (8, 1024), (2, 1000), (1, 16)
"""Allowed cells along an axis, snapshots of a piece, and pieces."""

CELLS_M, INTERVALS_S, LAYER_M, THICKEST = (1.0, 5000.0), (1.0, 3600.0), (0.0, 20_000.0), 1e4
"""Allowed sides of a cell, times between snapshots, altitudes, and the largest optical thickness."""

FORMAT = 1

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Film:
    """A film of clouds.

    Attributes
    ----------
    ranks : ndarray of uint8 (pieces, snapshots, rows, columns)
        Ranks of optical thickness; periodic, rows northward, columns eastward.
    optical_thickness : ndarray (256,)
        Visible, at the ranks, ascending; 0 at the ranks of clear sky.
    scores : ndarray (256,)
        Scores of the ranks, ascending, evenly spaced: see :func:`score_of`.
    top, base : ndarray of uint8 (pieces, snapshots, rows, columns)
        Top and lowest base, 1 to 255, in 255ths of the layer between ``base_m`` and ``top_m``; 0 where it is clear.
    motion : ndarray of int8 (pieces, snapshots - 1, 2, block_rows, block_columns)
        Displacements along y and x to the next snapshot in 1/16 cells, at the middles of blocks.
    block : int
        Cells along a side of a block.
    cell_m : float
        Side of a cell.
    interval_s : float
        Between snapshots.
    base_m, top_m : float
        The layer.
    sheet : bool
        Whether more than half is cloud: scores are then those of sheets.
    kind, source, licence : str
        Kind of clouds, where the film comes from, and the terms of use.
    frame_m_s : (float, float)
        Speed along x and y with which the box moved; motion is relative to it.
    """

    ranks: Bytes
    optical_thickness: Array
    scores: Array
    top: Bytes
    base: Bytes
    motion: NDArray[np.int8]
    block: int
    cell_m: float
    interval_s: float
    base_m: float
    top_m: float
    sheet: bool
    kind: str
    source: str
    licence: str
    frame_m_s: tuple[float, float]

    @property
    def coverage(self) -> float:
        """Mean share of cloud."""
        return self.share_above(0.0)

    def share_above(self, optical_thickness: float) -> float:
        """Return the share of pixels of all snapshots with more than an optical thickness."""
        return float(self._counts[self.optical_thickness > optical_thickness].sum() / self.ranks.size)

    @cached_property
    def _counts(self) -> NDArray[np.int64]:
        """Number of pixels (256,) of each rank: a plan makes dozens of skies of a film."""
        return np.bincount(self.ranks.ravel(), minlength=LEVELS)


def score_of(u: Array, sheet: bool) -> Array:
    """Return the scores of probabilities u: -ln(-ln u), of sheets ln(-ln(1 - u)); both ascend."""
    return np.log(-np.log1p(-u)) if sheet else -np.log(-np.log(u))


def described(path: Path) -> str:
    """Return kind, cell, cover, layer and duration of a film in words; its pictures are not read.

    The cover is that of the scores, which have the distribution of the pixels.

    Raises
    ------
    CatalogError
        If the file is damaged or no film.
    """
    with _open(path) as file:
        first, last = (float(score) for score in file.first_and_last_score)
        clear = np.count_nonzero(np.asarray(file["optical_thickness"][:]) == 0.0)
        least = first + (clear - 0.5) * (last - first) / (LEVELS - 1)
        cover = math.exp(-math.exp(least)) if file.sheet else -math.expm1(-math.exp(-least))
        minutes = file.dimensions["piece"].size * (file.dimensions["snapshot"].size - 1) * file.interval_s / 60.0
        return (
            f"{file.kind}: {file.cell_m:g} m, cover {cover:.2f}, clouds from {file.base_m / 1e3:.1f} to "
            f"{file.top_m / 1e3:.1f} km, film of {minutes:g} min"
        )


_RANKS = {
    "rank": "rank of optical thickness",
    "top": "cloud top, 255ths of the layer; 0: clear",
    "base": "lowest cloud base, 255ths of the layer; 0: clear",
}
_GRID = "piece", "snapshot", "y", "x"


def write_film(path: Path, film: Film) -> None:
    """Write a film as NetCDF. Raises CatalogError if it could not be read again."""
    _check(path, film)
    with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
        file.setncatts(
            {
                "title": f"Film of clouds: {film.kind}", "hcss_skies_film_format": FORMAT, "kind": film.kind,
                "source": film.source, "license": film.licence, "cell_m": film.cell_m, "interval_s": film.interval_s,
                "base_m": film.base_m, "top_m": film.top_m, "sheet": int(film.sheet), "block": film.block,
                "frame_m_s": np.array(film.frame_m_s), "first_and_last_score": film.scores[[0, -1]],
            }
        )  # fmt: skip
        sizes = *film.ranks.shape, LEVELS, film.motion.shape[1], 2, *film.motion.shape[3:]
        names = *_GRID, "level", "interval", "axis", "block_y", "block_x"
        for name, size in zip(names, sizes, strict=True):
            file.createDimension(name, size)
        for (name, what), field in zip(_RANKS.items(), (film.ranks, film.top, film.base), strict=True):
            one = (1, 1, *field.shape[2:])
            coded = file.createVariable(name, "u1", _GRID, zlib=True, complevel=9, fill_value=False, chunksizes=one)
            coded[:] = _coded(field)
            coded.long_name = f"{what}; differences along x modulo 256"
        motion = file.createVariable("motion", "i1", names[:1] + names[5:], zlib=True, complevel=9, fill_value=False)
        motion[:] = film.motion
        motion.setncatts({"units": "1/16 cell", "long_name": "displacement along y and x to the next snapshot"})
        values = file.createVariable("optical_thickness", "f4", ("level",), fill_value=False)
        values[:] = film.optical_thickness
        values.setncatts({"units": "1", "long_name": "optical thickness, visible, at each rank; 0: clear"})


def read_film(path: Path) -> Film:
    """Read a film.

    Raises
    ------
    CatalogError
        If the file is damaged, is no film, or has values out of range.
    """
    with _open(path) as file:
        ranks, top, base = (_decoded(_of_kind(file[name], np.uint8)) for name in _RANKS)
        first, last = (float(score) for score in file.first_and_last_score)
        along_x, along_y = (float(speed) for speed in file.frame_m_s)
        film = Film(
            ranks, np.asarray(file["optical_thickness"][:], dtype=np.float64), np.linspace(first, last, LEVELS),
            top, base, _of_kind(file["motion"], np.int8), int(file.block), float(file.cell_m), float(file.interval_s),
            float(file.base_m), float(file.top_m), bool(file.sheet), str(file.kind), str(file.source),
            str(file.license), (along_x, along_y),
        )  # fmt: skip
    _check(path, film)
    return film


@contextmanager
def _open(path: Path) -> Iterator[Any]:
    with Reading(path, CatalogError, "not a film of clouds, or damaged").netcdf() as file:
        if getattr(file, "hcss_skies_film_format", None) != FORMAT:
            raise CatalogError(f"{path}: no film of clouds; `hcss skies pack` makes one from a simulation")
        file.set_auto_mask(False)
        yield file


def _of_kind(variable: Any, kind: Any) -> NDArray[Any]:
    values = np.asarray(variable[:])
    if values.dtype != kind:
        raise TypeError(f"{variable.name} of {values.dtype}; allowed: {np.dtype(kind)}")
    return values


def _coded(field: Bytes) -> Bytes:
    """Return differences along x."""
    coded: Bytes = np.diff(field, axis=-1, prepend=np.uint8(0))
    return coded


def _decoded(coded: Bytes) -> Bytes:
    field: Bytes = np.cumsum(coded, axis=-1, dtype=np.uint8)
    return field


def _check(path: Any, film: Film) -> None:
    """Raise CatalogError unless the parts of a film fit together and are in range."""
    wrong = _wrong_shapes(film) or _wrong_values(film)
    if wrong:
        raise CatalogError(f"{path}: {wrong}")


def _wrong_shapes(film: Film) -> str:
    shape = film.ranks.shape
    if len(shape) != 4 or film.top.shape != shape or film.base.shape != shape:
        return f"fields of {shape}, {film.top.shape} and {film.base.shape}; allowed: the same four sizes"
    ranges = {"pieces": PIECES, "snapshots": SNAPSHOTS, "rows": SIDES, "columns": SIDES}
    for size, (name, (low, high)) in zip(shape, ranges.items(), strict=True):
        if not low <= size <= high:
            return f"{size} {name}; allowed: {low} to {high}"
    rows, columns = shape[2:]
    if not 1 <= film.block <= min(rows, columns) or rows % film.block or columns % film.block:
        return f"block {film.block}; allowed: a divisor of {rows} and {columns} cells"
    blocks = shape[0], shape[1] - 1, 2, rows // film.block, columns // film.block
    if film.motion.shape != blocks:
        return f"motion of {film.motion.shape}; allowed: {blocks}"
    if film.optical_thickness.shape != (LEVELS,) or film.scores.shape != (LEVELS,):
        return f"tables of other length than {LEVELS}"
    return ""


def _wrong_values(film: Film) -> str:
    table, high = film.optical_thickness, LAYER_M[1]
    if not (np.all((table >= 0.0) & (table <= THICKEST)) and np.all(np.diff(table) >= 0.0)):
        return f"optical thickness that does not ascend, or outside 0 to {THICKEST:g}"
    step = np.diff(film.scores)
    if not (np.all(np.abs(film.scores) < 100.0) and step[0] > 0.0 and np.allclose(step, step[0], atol=0.0)):
        return "scores that are not evenly spaced and ascending within -100 to 100"
    if not np.all(np.abs(film.motion.astype(np.int16)) <= MAX_CELLS * PER_CELL):
        return f"displacements beyond {MAX_CELLS:g} cells"
    for name, value, (least, most) in (
        ("cell_m", film.cell_m, CELLS_M),
        ("interval_s", film.interval_s, INTERVALS_S),
        ("base_m", film.base_m, LAYER_M),
        ("frame_m_s along x", film.frame_m_s[0], (-100.0, 100.0)),
        ("frame_m_s along y", film.frame_m_s[1], (-100.0, 100.0)),
    ):
        if not least <= value <= most:
            return f"{name} {value:g}; allowed: {least:g} to {most:g}"
    if not film.base_m < film.top_m <= high:
        return f"top_m {film.top_m:g}; allowed: above base_m {film.base_m:g}, at most {high:g}"
    cloudy = table[film.ranks] > 0.0
    if not np.any(cloudy):
        return "no cloud"
    if not (np.array_equal(film.top > 0, cloudy) and np.array_equal(film.base > 0, cloudy)):
        return "tops or bases of clear sky, or cloud without; allowed: 1 to 255 exactly in cloud"
    if np.any(film.base > film.top):
        return "bases above tops"
    if film.sheet != (film.coverage > 0.5):
        return f"sheet {int(film.sheet)} with a cover of {film.coverage:.2f}; allowed: 1 above .5, else 0"
    return ""
