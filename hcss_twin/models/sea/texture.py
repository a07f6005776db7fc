"""Random fields of sea temperature and of column water vapour: the texture of clear sky.

Measured clear sky is not one number. Infrared images of the sea surface have spectra near k^-2 from 8 km down to 80 m
(S. L. Castro et al., Remote Sens. 9 (2017) 1089), and near-infrared images of the vapour column a structure function
near r^(2/3) (X. Calbet et al., Atmos. Meas. Tech. 15 (2022) 7105). Either field is a sum of lattices of random numbers
whose cells halve from octave to octave, with variances in proportion to cell^(2H): below the outer scale its
structure function rises as r^(2H). An octave belongs to a place, a seed and a cell size, not to the image: sensors of
any pixel size see the same field, averaged over their pixels. Wavelengths longer than the image (cells longer than half
of it) are left out: they would only add to what the scenario gives as temperature and vapour of the scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.lattice import fold
from hcss_twin.models.clouds.fractal.octaves import Octave, lifetime_s
from hcss_twin.providers import Grid

COARSE = 4
"""Octaves whose cells have at least COARSE^2 pixels are evaluated at every COARSE-th pixel, and interpolated."""

_SEED_KEY = 2**19
"""Distinguishes the seeds of textures from those of clouds, waves and samples."""


@dataclass(frozen=True)
class TextureShape:
    """Spectrum and lifetime of a field.

    Attributes
    ----------
    number : int
        Distinguishes fields with one seed.
    outer_m, finest_m : float
        Cells of the first octave, and the smallest cells.
    hurst : float
        H of the structure function.
    lifetime_s_per_m : float
        Time in which large structures change, per size of their cells; infinite: they stay.
    """

    number: int
    outer_m: float
    finest_m: float
    hurst: float
    lifetime_s_per_m: float

    @cached_property
    def cells(self) -> tuple[tuple[float, float], ...]:
        """Size (m) and share of the variance of each octave, whatever the pixels."""
        count = int(np.floor(np.log2(self.outer_m / self.finest_m))) + 1
        size = self.outer_m / 2.0 ** np.arange(count)
        power = size ** (2.0 * self.hurst)
        return tuple(zip(size.tolist(), (power / power.sum()).tolist(), strict=True))


SEA_TEMPERATURE = TextureShape(1, 160e3, 50.0, 0.5, np.inf)
"""H of k^-2. The sea changes in days, and does not move with the wind."""

WATER_VAPOUR = TextureShape(2, 160e3, 1000.0, 1.0 / 3.0, 0.33)
"""H of r^(2/3). Below the depth of the boundary layer the column averages vapour over its height. The lifetime is
that of clouds in the same air (``CELL_LIFETIME_S_PER_M`` of :mod:`hcss_twin.plan.assemble`)."""


class TextureField:
    """A Gaussian field of unit variance, averaged over pixels.

    Parameters
    ----------
    seed : int
        Realisation.
    velocity_m_s : (float, float)
        Of the field over the sea, toward +x and +y.
    platform_speed_m_s : float
        Of the image over the sea, toward +x.

    Attributes
    ----------
    is_still : bool
        Whether the image shows the same at all times.
    """

    def __init__(
        self,
        shape: TextureShape,
        seed: int,
        grid: Grid,
        velocity_m_s: tuple[float, float] = (0.0, 0.0),
        platform_speed_m_s: float = 0.0,
    ) -> None:
        self._grid = grid
        self._speeds = platform_speed_m_s - velocity_m_s[0], -velocity_m_s[1]
        self.octaves = octaves_of(shape, grid)
        key = fold(_SEED_KEY, seed, shape.number)
        large = tuple(octave for octave in self.octaves if octave.x.step * COARSE**2 <= 1.0)
        self._fine = FractalField(key, tuple(octave for octave in self.octaves if octave not in large))
        self._coarse = FractalField(key, tuple(_at_every(COARSE, octave) for octave in large)) if large else None
        self.is_still = self._speeds == (0.0, 0.0) and all(octave.t.step == 0.0 for octave in self.octaves)

    def at(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the field (y, x) at pixels of the image, inside or outside; a pixel has the same bits in any window.

        Raises
        ------
        ValueError
            If indices of nodes exceed 64 bits.
        """
        y = self._window(rows, self._grid.rows, self._speeds[1], time_s)
        x = self._window(columns, self._grid.columns, self._speeds[0], time_s)
        field = self._fine.window(time_s, y, x)
        if self._coarse is not None and field.size:
            nodes = self._coarse.window(time_s, _nodes_around(y), _nodes_around(x))
            _add_interpolated(field, nodes, y.first % COARSE, x.first % COARSE, _WEIGHTS)
        return field

    def _window(self, pixels: slice, size: int, speed_m_s: float, time_s: float) -> FractalField.PixelWindow:
        shift = self._grid.displacement_pixels(speed_m_s, time_s)
        return FractalField.PixelWindow(pixels.start, pixels.stop - pixels.start, (0.5 - 0.5 * size) + shift)


def cells_of(shape: TextureShape, grid: Grid) -> list[tuple[float, float]]:
    """Return size (m) and share of variance of the octaves in an image: cells from a pixel to half of it."""
    size_m = grid.pixel_size_m * max(grid.rows, grid.columns)
    return [(cell_m, share) for cell_m, share in shape.cells if grid.pixel_size_m <= cell_m <= 0.5 * size_m]


@lru_cache(maxsize=64)
def octaves_of(shape: TextureShape, grid: Grid) -> tuple[Octave, ...]:
    """Return the octaves of a field averaged over square pixels."""
    correlation = KernelCorrelation.tabulate()
    apart: Array = (np.arange(64, dtype=np.float64) + 0.5) / 64.0
    octaves = []
    for cell_m, variance in cells_of(shape, grid):
        step, k = grid.pixel_size_m / cell_m, round(math.log2(shape.outer_m / cell_m))
        # Mean correlation of two points of the pixel, along either axis.
        mean = float(np.mean(2.0 * (1.0 - apart) * correlation(apart * step)))
        scale, still = Octave.AxisScale(step, False), not np.isfinite(shape.lifetime_s_per_m)
        time = Octave.AxisScale(0.0 if still else 1.0 / lifetime_s(cell_m, shape.lifetime_s_per_m), False)
        octaves.append(Octave(k, variance * mean**2, scale, scale, time, False))
    return tuple(octaves)


def _at_every(pixels: int, octave: Octave) -> Octave:
    scale = Octave.AxisScale(pixels * octave.x.step, False)
    return Octave(octave.k, octave.variance, scale, scale, octave.t, False)


def _nodes_around(pixels: FractalField.PixelWindow) -> FractalField.PixelWindow:
    """Return every COARSE-th pixel, from the second before the first to the second after the last."""
    first, last = pixels.first // COARSE - 1, (pixels.first + pixels.count - 1) // COARSE + 2
    return FractalField.PixelWindow(first, last - first + 1, pixels.origin / COARSE)


_WEIGHTS = np.array(
    [
        [
            -0.5 * t**3 + t**2 - 0.5 * t,
            1.5 * t**3 - 2.5 * t**2 + 1.0,
            -1.5 * t**3 + 2.0 * t**2 + 0.5 * t,
            0.5 * (t**3 - t**2),
        ]
        for t in np.arange(COARSE) / COARSE
    ],
    dtype=np.float32,
)
"""Weights of the four nodes around a pixel, by its place between them (R. G. Keys, IEEE Trans. ASSP 29 (1981) 1153)."""


@kernel()
def _add_interpolated(field, nodes, first_row, first_column, weights):  # type: ignore[no-untyped-def]
    """Add to a field (y, x) the interpolated nodes, of which it starts some pixels after the second of either axis."""
    step, rows, columns = weights.shape[0], field.shape[0], field.shape[1]
    line = np.empty(nodes.shape[1], np.float32)
    for y in range(rows):
        node, w = (first_row + y) // step, weights[(first_row + y) % step]
        for x in range(line.size):
            line[x] = (w[0] * nodes[node, x] + w[1] * nodes[node + 1, x]) + (
                w[2] * nodes[node + 2, x] + w[3] * nodes[node + 3, x]
            )
        for phase in range(step):
            v0, v1, v2, v3 = weights[phase, 0], weights[phase, 1], weights[phase, 2], weights[phase, 3]
            start = (phase - first_column) % step
            node = (first_column + start) // step
            for x in range(start, columns, step):
                field[y, x] += (v0 * line[node] + v1 * line[node + 1]) + (v2 * line[node + 2] + v3 * line[node + 3])
                node += 1
