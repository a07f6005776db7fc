"""An unbounded sky of single clouds at random places: a Boolean model on the pixel lattice.

The corners of the clouds are a Poisson process of ``density`` clouds per pixel. Each cloud is one of the shapes of a
database entry in one of the orientations, independently of all others. A pixel is clear with a probability of exactly
exp(-density x mean area).

Each cloud has an arrival, the density above which it exists, and the Poisson process extends over space and arrival. A
denser sky therefore contains all clouds of a sparser one at the same places, and more.

Random numbers are functions of the indices of a cell of the plane (a counter-based generator in the sense of Salmon et
al. 2011, "Parallel random numbers: as easy as 1, 2, 3"): windows can be computed in any order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.special import pdtr

from hcss_twin.core.errors import CatalogError, Problem, ScenarioError
from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.models.clouds.imagery.cloudiness import Cloudiness


@dataclass(frozen=True)
class SingleClouds:
    """Cloud shapes in one array: cloud c has ``heights[c]`` x ``widths[c]`` values from ``starts[c]`` on, by rows.

    Attributes
    ----------
    thickness_m : ndarray of float32 (N,)
        Thickness in the rectangles around the clouds, rows northward; 0 outside the cloud.
    starts, heights, widths, areas : ndarray of int64 (clouds,)
        First index in ``thickness_m``, sides of the rectangle, and number of cloudy pixels.
    left_out : int
        Number of other clouds in the entry.
    """

    thickness_m: NDArray[np.float32]
    starts: NDArray[np.int64]
    heights: NDArray[np.int64]
    widths: NDArray[np.int64]
    areas: NDArray[np.int64]
    left_out: int

    @property
    def mean_area(self) -> float:
        """Mean number of cloudy pixels of a cloud."""
        return float(np.mean(self.areas))

    @property
    def largest_side(self) -> int:
        """Longest side of any rectangle."""
        return int(max(self.heights.max(), self.widths.max()))


def single_clouds(
    entry: CloudEntry, thickness_min_m: float, thickness_max_m: float, pixels: tuple[int, int] | None = None
) -> SingleClouds:
    """Return the whole clouds of an entry, with areas within ``pixels`` if given.

    Clouds cut by the image border or by missing pixels are excluded, because the cut is not a cloud outline.

    Raises
    ------
    CatalogError
        If all clouds are cut.
    ScenarioError
        If no whole cloud has an area within ``pixels``.
    """
    labels, grey, missing = entry.labels[::-1], entry.grey[::-1], entry.missing[::-1]
    cut = np.zeros(entry.facts.clouds + 1, dtype=np.bool_)
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        cut[edge] = True
    cut[labels[ndimage.binary_dilation(missing, np.ones((3, 3)))]] = True
    shapes, sides, areas = [], [], []
    for number, where in enumerate(ndimage.find_objects(labels), start=1):
        if cut[number]:
            continue
        cloudy = labels[where] == number
        area = int(np.count_nonzero(cloudy))
        if pixels is not None and not pixels[0] <= area <= pixels[1]:
            continue
        shape = np.zeros(cloudy.shape, dtype=np.float32)
        relative = (grey[where][cloudy].astype(np.float64) - 1.0) / 254.0
        shape[cloudy] = Cloudiness.thickness_of(relative, thickness_min_m, thickness_max_m)
        shapes.append(shape.ravel())
        sides.append(shape.shape)
        areas.append(area)
    if not shapes:
        whole = np.bincount(labels.ravel(), minlength=cut.size)[1:][~cut[1:]]
        if whole.size:
            low, high = int(whole.min()), int(whole.max())
            problem = Problem(
                "clouds.parameters.cloud_pixels",
                f"{list(pixels or ())} given; allowed: a range that meets {low} to {high}, the sizes of the entry's "
                f"whole clouds; closest is [{low}, {high}]",
            )
            raise ScenarioError([problem], origin="imagery clouds")
        raise CatalogError(
            f"the border of the image or missing pixels cut all {entry.facts.clouds} clouds of the entry; allowed: "
            'placement = "scene", or an image with whole clouds'
        )
    sizes = np.array([shape.size for shape in shapes], dtype=np.int64)
    heights, widths = np.array(sides, dtype=np.int64).T
    return SingleClouds(
        thickness_m=np.concatenate(shapes),
        starts=np.cumsum(sizes) - sizes,
        heights=np.ascontiguousarray(heights),
        widths=np.ascontiguousarray(widths),
        areas=np.array(areas, dtype=np.int64),
        left_out=entry.facts.clouds - len(shapes),
    )


# Mean number of clouds per layer and cell: fewer would cost time for cells, more for clouds outside the window.
_PER_CELL = 4.0

# Sky fraction covered by each layer of arrivals: typical coverages need one or two layers.
_LAYER_COVERAGE = 0.5

# Beyond this, the sum of two pixel indices could exceed 64 bits.
FARTHEST_PIXEL = 2**60

_Words = NDArray[np.uint64]

# Weyl increment and multipliers of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable
# pseudorandom number generators", section 5).
_INCREMENT = np.uint64(0x9E3779B97F4A7C15)
_MULTIPLIER_1 = np.uint64(0xBF58476D1CE4E5B9)
_MULTIPLIER_2 = np.uint64(0x94D049BB133111EB)

# Last index of the random numbers for each purpose.
_COUNT, _PLACE, _SHAPE, _ARRIVAL = range(4)


def _mixed(words: _Words) -> _Words:
    """Scatter 64-bit integers (bijective), element by element; array products wrap around silently."""
    words = (words ^ (words >> np.uint64(30))) * _MULTIPLIER_1
    words = (words ^ (words >> np.uint64(27))) * _MULTIPLIER_2
    return words ^ (words >> np.uint64(31))


def _random(*indices: NDArray[np.int64] | int) -> _Words:
    """Fold broadcast integer arrays of any sign into random 64-bit words; order matters."""
    words = np.full(1, _INCREMENT)
    for index in indices:
        folded = np.asarray(index, dtype=np.int64).reshape(-1).view(np.uint64)
        words = _mixed((words + _INCREMENT) ^ folded)
        words = _mixed(words * _INCREMENT + folded)
    return words


def _unit(words: _Words) -> NDArray[np.float64]:
    """Return numbers in [0, 1) with 53 bits."""
    return (words >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _below(words: _Words, limit: int) -> NDArray[np.int64]:
    """Return integers from 0 to ``limit`` - 1, less than 2**31, from the low halves of words."""
    return ((words & np.uint64(0xFFFFFFFF)) * np.uint64(limit) >> np.uint64(32)).astype(np.int64)


class Placed(NamedTuple):
    """Clouds of a part of the sky, in arrays of equal length.

    Attributes
    ----------
    y, x : ndarray of int64 (N,)
        South-west corners of the rectangles, pixels.
    shape, turn : ndarray of int64 (N,)
        Index of the shape, and orientation: bit 0 mirrors north and south, bit 1 mirrors east and west, bit 2 first
        exchanges rows and columns.
    arrival : ndarray of float64 (N,)
        Cloud density, clouds per pixel, above which the cloud exists.
    """

    y: NDArray[np.int64]
    x: NDArray[np.int64]
    shape: NDArray[np.int64]
    turn: NDArray[np.int64]
    arrival: NDArray[np.float64]


class Sky:
    """Clouds at random places in the plane.

    Parameters
    ----------
    clouds : SingleClouds
        The shapes, all equally likely.
    seed : int
        Seed of the realisation, 0 to 2**63 - 1.
    turned : bool
        Whether the eight orientations are equally likely; otherwise clouds keep the orientation of the entry.
    """

    def __init__(self, clouds: SingleClouds, seed: int, turned: bool) -> None:
        self._clouds = clouds
        self._shapes = (clouds.thickness_m, clouds.starts, clouds.heights, clouds.widths)
        self._seed = seed
        self._turns = 8 if turned else 1
        # Clouds per pixel that arrive with each layer: independent of the coverage, so that a denser sky adds clouds.
        self._layer_density = -math.log1p(-_LAYER_COVERAGE) / clouds.mean_area
        self._cell = max(1, round(math.sqrt(_PER_CELL / self._layer_density)))
        mean = self._layer_density * self._cell**2
        # The number of clouds in a cell is Poisson; beyond this table its probability is 0 in double precision.
        self._cumulated = pdtr(np.arange(int(mean + 20.0 * math.sqrt(mean) + 40.0), dtype=np.float64), mean)

    def density(self, coverage: float) -> float:
        """Return the number of clouds per pixel that covers this fraction of the plane, less than 1."""
        return -math.log1p(-coverage) / self._clouds.mean_area

    def thickness_m(self, rows: slice, columns: slice, density: float) -> NDArray[np.float32]:
        """Return the thickness (rows, columns) of a window; where clouds overlap, the thickest counts.

        Parameters
        ----------
        rows, columns : slice
            With start and stop of any sign, within +-2**60 pixels.
        density : float
            Clouds per pixel.
        """
        thickness = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        if thickness.size:
            for layer in range(math.ceil(density / self._layer_density)):
                placed = self.placed(rows, columns, layer)
                _overlay(thickness, False, rows.start, columns.start, density, *self._shapes, *placed)
        return thickness

    def arrivals(self, rows: slice, columns: slice, layers: int) -> NDArray[np.float64]:
        """Return the density (rows, columns) above which each pixel is covered; infinity beyond ``layers`` layers."""
        earliest = np.full((rows.stop - rows.start, columns.stop - columns.start), np.inf)
        for layer in range(layers):
            placed = self.placed(rows, columns, layer)
            _overlay(earliest, True, rows.start, columns.start, math.inf, *self._shapes, *placed)
        return earliest

    def placed(self, rows: slice, columns: slice, layer: int) -> Placed:
        """Return the clouds of one layer of arrivals in all cells whose clouds may reach into a window.

        Raises
        ------
        ValueError
            If the window reaches beyond 2**60 pixels.
        """
        for name, window in (("rows", rows), ("columns", columns)):
            if not -FARTHEST_PIXEL <= window.start <= window.stop <= FARTHEST_PIXEL:
                raise ValueError(f"{name}: {window} given, allowed: -2**60 to 2**60")
        reach = self._clouds.largest_side - 1
        cell_y = np.arange((rows.start - reach) // self._cell, (rows.stop - 1) // self._cell + 1)
        cell_x = np.arange((columns.start - reach) // self._cell, (columns.stop - 1) // self._cell + 1)
        all_y, all_x = np.repeat(cell_y, cell_x.size), np.tile(cell_x, cell_y.size)
        drawn = _unit(_random(self._seed, layer, all_y, all_x, _COUNT))
        counts = np.searchsorted(self._cumulated, drawn, side="right")
        number = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        cell = (self._seed, layer, np.repeat(all_y, counts), np.repeat(all_x, counts), number)
        position, kind = _random(*cell, _PLACE), _random(*cell, _SHAPE)
        return Placed(
            y=cell[2] * self._cell + _below(position, self._cell),
            x=cell[3] * self._cell + _below(position >> np.uint64(32), self._cell),
            shape=_below(kind, self._clouds.areas.size),
            turn=_below(kind >> np.uint64(32), self._turns),
            arrival=(layer + _unit(_random(*cell, _ARRIVAL))) * self._layer_density,
        )


@kernel()  # 9000 clouds of 50 pixels take 1 ms, compared with about 70 ms for array slices
def _overlay(
    target: Any,
    is_arrival: bool,
    row: int,
    column: int,
    density: float,
    values: NDArray[np.float32],
    starts: NDArray[np.int64],
    heights: NDArray[np.int64],
    widths: NDArray[np.int64],
    y: NDArray[np.int64],
    x: NDArray[np.int64],
    shape: NDArray[np.int64],
    turn: NDArray[np.int64],
    arrival: NDArray[np.float64],
) -> None:
    """Overlay the clouds with arrivals up to ``density`` on ``target`` (rows, columns), whose corner is row, column.

    Raises ``target`` to the cloud thickness or, with ``is_arrival``, lowers it to their arrivals. Maxima and minima do
    not depend on the order of the clouds.
    """
    rows, columns = target.shape
    for n in range(y.size):
        if arrival[n] >= density:
            continue
        start, height, width = starts[shape[n]], heights[shape[n]], widths[shape[n]]
        swapped = turn[n] & 4
        tall, wide = (width, height) if swapped else (height, width)
        top, left = y[n] - row, x[n] - column
        for i in range(max(0, -top), min(tall, rows - top)):
            for j in range(max(0, -left), min(wide, columns - left)):
                a, b = (j, i) if swapped else (i, j)
                if turn[n] & 1:
                    a = height - 1 - a
                if turn[n] & 2:
                    b = width - 1 - b
                value = values[start + a * width + b]
                if is_arrival:
                    if value > 0.0 and arrival[n] < target[top + i, left + j]:
                        target[top + i, left + j] = arrival[n]
                elif value > target[top + i, left + j]:
                    target[top + i, left + j] = value
