"""The cloud generator `fall-streaks`: cirrus that falls out of a generating level into a sheared wind."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blending import displaced
from hcss_skies.fall_streaks.parameters import FallStreakParameters
from hcss_skies.fall_streaks.streaks import LONGER, WAVELENGTH, Fall, Lattices, stencils, variances
from hcss_skies.flow import Octave, flow_nodes
from hcss_skies.pace import Pace
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, CloudDeclaration, CloudInputs

BENDS = (Octave(500e3, 9000.0, 40_000.0),)
"""Flows that bend fields of streaks, so that they are not parallel over hundreds of km."""

THICKEST = 0.998
"""Quantile of the ice water path of the sky that has the greatest thickness of the layer."""

_OF_SHEAR = 0x5EA2
"""Distinguishes the seed of the random angle between wind and shear."""

_TILE = 512
_MEASURED = 512  # pixels along a side of the sky whose distribution is measured
_PLACES, _PLACE = 96, 12  # places, and pixels along their side, that tell what smaller pixels add


class FallStreaks:
    """Cirrus after R. J. Hogan and S. F. Kew (2005): ice water path of a log-normal generating level in shear.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion and seed.
    parameters : FallStreakParameters
        Shear, fall and fluctuations.

    Attributes
    ----------
    fall : Fall
        How ice falls.
    """

    declares: CloudDeclaration
    honours: tuple[str, ...] = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: FallStreakParameters) -> None:
        self._inputs, self._of = inputs, parameters
        self.fall = Fall(
            inputs.layer.thickness_max_m, parameters.shear, parameters.fall_speed, math.radians(parameters.turning),
            _towards(inputs, parameters),
        )  # fmt: skip
        self._pace = Pace.of(inputs.motion)
        self._lattices = self._lattices_of(inputs.grid.pixel_size_m)
        self._least, self._most = self._limits()
        farthest = float(np.hypot(*self.fall.displacement_m(np.array([0.0, self.fall.depth_m])))[1])
        self.declares = CloudDeclaration(
            depends_on=self._pace.depends_on,
            evolves=self._pace.evolves,
            notes=(f"The last ice is {farthest / 1e3:.3g} km behind the cell from which it fell.",),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window; 0 is clear sky.

        Raises
        ------
        ValueError
            If the time is not finite.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        grid, layer = self._inputs.grid, self._inputs.layer
        out = np.empty((max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)), np.float32)
        for i in range(0, out.shape[0], _TILE):
            for j in range(0, out.shape[1], _TILE):
                tile = out[i : i + _TILE, j : j + _TILE]
                y, x = self._pace.positions_m(grid, (rows.start + i, columns.start + j), tile.shape, time_s)
                path = self._path(self._lattices, grid.pixel_size_m, y, x, time_s)
                scale = (layer.thickness_max_m - layer.thickness_min_m) / (self._most - self._least)
                _write(tile, path, self._least, scale, layer.thickness_min_m, layer.thickness_max_m)
        return out

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def _lattices_of(self, pixel_m: float) -> Lattices:
        """Return the lattices for a pixel size, with nodes one to two pixels apart if the outer scale has them."""
        outer_m = 1e3 * self._of.outer_scale
        longest = 2.0**LONGER * outer_m / WAVELENGTH
        count = 1 + max(0, math.floor(math.log2(longest / pixel_m) + 1e-9))
        spacings: Array = np.asarray(longest * 0.5 ** np.arange(count), np.float64)
        shares = self._of.deviation**2 * variances(outer_m, self._of.cells)
        return Lattices(spacings, stencils(self.fall, spacings), shares, self._inputs.seed)

    def _path(self, lattices: Lattices, pixel_m: float, y: Any, x: Any, time_s: float) -> NDArray[np.float32]:
        """Return the ice water path at (rows,), (columns,) in m."""
        time = time_s * self._pace.rate
        nodes, bounds = flow_nodes(BENDS, y, x, 1.0, pixel_m, self._inputs.seed, time)
        at_y, at_x = np.empty((y.size, x.size)), np.empty((y.size, x.size))
        _bend(at_y, at_x, y, x, nodes, bounds)
        return lattices.integral(at_y, at_x, time)

    def _limits(self) -> tuple[float, float]:
        """Return the ice water paths of the thinnest and of the thickest cloud."""
        layer, grid = self._inputs.layer, self._inputs.grid
        if layer.coverage_mode == "frame":
            step = max(1, math.ceil(max(grid.rows, grid.columns) / _MEASURED))
            y, x = (
                grid.pixel_size_m * (np.arange(0, size, step) + 0.5 - 0.5 * size) for size in (grid.rows, grid.columns)
            )
            found = self._path(self._lattices, grid.pixel_size_m, y, x, 0.0).ravel().astype(np.float64)
        else:
            found = self._of_sky()
        least, most = np.quantile(found, [1.0 - layer.coverage, THICKEST])
        if layer.coverage >= 1.0:
            least = 0.0
        return float(least if layer.coverage > 0.0 else np.inf), float(max(most, 1.001 * least))

    def _of_sky(self) -> Array:
        """Return ice water paths of the unbounded sky: those of a coarse picture, times what smaller pixels add."""
        pixel_m = self._inputs.grid.pixel_size_m
        coarse_m = max(pixel_m, 1e3 * self._of.outer_scale / 16.0)
        side = coarse_m * (np.arange(_MEASURED) - 0.5 * _MEASURED)
        coarse = self._lattices_of(coarse_m)
        found = self._path(coarse, coarse_m, side, side, 0.0).ravel().astype(np.float64)
        if self._lattices.spacings_m.size == coarse.spacings_m.size:
            return found
        ratios = []
        rng = np.random.default_rng(1)
        for place in rng.uniform(side[0], side[-1], (_PLACES, 2)):
            y, x = (centre + pixel_m * np.arange(_PLACE) for centre in place)
            fine = self._path(self._lattices, pixel_m, y, x, 0.0)
            ratios.append(fine / self._path(coarse, pixel_m, y, x, 0.0))
        added = np.array(ratios, np.float64).ravel()
        return found * rng.choice(added / added.mean(), found.size)


def _towards(inputs: CloudInputs, parameters: FallStreakParameters) -> tuple[float, float]:
    """Return the direction (y, x) into which streaks trail: by default where clouds come from, turned by the seed.

    Wind comes mostly along an axis of the image, and so would all streaks. The wind does not fall with height.
    """
    if parameters.shear_from is not None:
        angle = math.radians(parameters.shear_from)
    else:
        wind_x, wind_y = inputs.motion.cloud_velocity_m_s
        against = math.atan2(-wind_x, -wind_y) if wind_x or wind_y else -0.5 * math.pi
        angle = against + math.pi * (np.random.default_rng([inputs.seed, _OF_SHEAR]).random() - 0.5)
    return math.cos(angle), math.sin(angle)


@kernel()
def _bend(at_y: Any, at_x: Any, y: Any, x: Any, flow: Any, bounds: Any) -> None:
    """Write the positions (rows, columns) to which flows bend a grid."""
    octaves, columns = flow.shape[0], x.size
    interval, past = np.empty((octaves, columns), np.uint64), np.empty((octaves, columns))
    for octave in range(octaves):
        for j in range(columns):
            position = x[j] / bounds[octave, 0]
            whole = math.floor(position)
            interval[octave, j], past[octave, j] = np.uint64(whole - bounds[octave, 2] - 1.0), position - whole
    curves = np.empty((octaves, max(flow.shape[2] - 3, 1), 7))
    for i in range(y.size):
        displaced(at_y[i], at_x[i], y[i], x, 0.0, 0.0, flow, bounds, interval, past, curves)


@kernel()
def _write(out: Any, path: Any, least: float, scale: float, thinnest: float, thickest: float) -> None:
    """Write thickness: linear in the ice water path above the least one, below it clear."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            above = path[i, j] - least
            out[i, j] = min(thinnest + scale * above, thickest) if above > 0.0 else 0.0
