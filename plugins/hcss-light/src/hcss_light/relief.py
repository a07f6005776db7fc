"""Fractal clouds with a shape in height: rounded sides and tops of three-dimensional octaves, and soft edges.

Thickness is that of the generator ``fractal``, so that columns keep their optical thickness. Columns of thickness alone
would stand as needles side by side, because neighbours differ at all scales: seen aslant, their sides are streaks.
Here the coarse octaves V' of the same field give a smooth body, cloudy where V' exceeds a threshold that grows with
the height above the base; V(x, y, z, t) of eqs 2-4 of the HCSS paper, with z as the other axes, gives it lumps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.special import ndtr, ndtri

from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, CloudInputs

SMOOTHEST = 20.0
"""Finest cell of the smooth body: the greatest thickness over this, and at least the first octave."""

OCTAVES, FINEST_PIXELS = 4, 1.5
"""Octaves of the lumps at most, each with half the cell of the one before, and their finest cell in pixels."""

SOFT = 0.25
"""Depth below the surface at which the extinction is full, in cells of the finest octave (at least a pixel)."""


LEVELS, SAMPLES = 97, 8192
"""Heights whose threshold is found, and random columns from which it is."""

HIGHEST = 9.0
"""Value that no field reaches."""

WITHIN = 1.0
"""Standard deviations of the fine octaves by which the body stays inside the outline of the clouds."""


class ReliefParameters(FractalParameters):
    """Those of ``fractal``, and the shape in height."""

    base_relief: float = Field(
        default=0.05, ge=0.0, le=1.0, description="Part of the free height of the layer by which flat ends move."
    )
    roughness: float = Field(
        default=0.35, ge=0.0, le=3.0, description="Height of the lumps of the surface, over the cell of their octave."
    )


class ReliefClouds(FractalClouds):
    """The generator ``fractal-relief``; see :class:`hcss_twin.providers.clouds.CloudGeneratorOptions`.

    A point lies (V' - threshold of its height) / |gradient| below the surface of the smooth body, to which the lumps
    are added, and within its outline. Thresholds are such that tops are as high as columns are thick, in the mean over
    the sky and in their distribution; single tops differ. The extinction grows over a soft edge, and as the power 2/3
    of the height above the base. A column that the body leaves empty is cloudy up to its thickness at most.
    """

    def __init__(self, inputs: CloudInputs, parameters: ReliefParameters) -> None:
        flat = {name: getattr(parameters, name) for name in FractalParameters.model_fields}
        given = {name: value for name, value in flat.items() if name in parameters.model_fields_set}
        super().__init__(inputs, FractalParameters(**given))
        axis, *others = self.skipped  # the first is the axis of height
        of_columns = "it shapes clouds in height with radiance.light; independent columns have no shape"
        self.skipped = ((axis[0], of_columns), *others)
        self._relief, self._roughness, self._seed = parameters.base_relief, parameters.roughness, inputs.seed
        shape, thickest = self.parameters, inputs.layer.thickness_max_m
        assert shape.gamma is not None
        assert shape.L is not None
        assert shape.k is not None
        octaves = Octave.separate(shape, inputs.grid, inputs.motion, False)
        scale = 16_000.0 / math.sqrt(shape.L[0] * shape.L[1])
        body = [octave for octave in octaves if scale / shape.gamma**octave.k >= thickest / SMOOTHEST] or [octaves[0]]
        variance = math.fsum(octave.variance for octave in body)
        body = [replace(octave, variance=octave.variance / variance) for octave in body]
        self._body = FractalField(inputs.seed, tuple(body))
        # Lumps: from half the greatest thickness, or the first cell, on.
        widest = min(0.5 * thickest, scale / shape.gamma ** shape.k[0])
        finest = FINEST_PIXELS * inputs.grid.pixel_size_m
        self._octaves = []
        for number in range(OCTAVES):
            cell_m = widest * 0.5**number
            if number and cell_m < finest:
                break
            cells = scale / cell_m
            lumps = shape.model_copy(update={"L": (shape.L[0] * cells, shape.L[1] * cells), "k": (0, 0)})
            self._octaves.append((cell_m, Octave.separate(lumps, inputs.grid, inputs.motion, False)))
        self._soft_m = max(SOFT * self._octaves[-1][0], inputs.grid.pixel_size_m)
        # The value of V' at the outline, and how fast that of eqs 5 and 7 grows with thickness, between its quartiles.
        coverage = min(max(inputs.layer.coverage, 1e-4), 1.0 - 1e-4)
        lowest, rest = ndtri(1.0 - coverage), math.sqrt(max(1.0 - variance, 0.0))
        self._edge = float(lowest + WITHIN * rest) / math.sqrt(variance)
        self._growth = float(np.diff(ndtri(1.0 - coverage * np.array([0.75, 0.25])))[0] / (0.5 * thickest))
        self._shape = tuple(body), variance
        self._plane = lru_cache(maxsize=512)(self._new_plane)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_plane"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._plane = lru_cache(maxsize=512)(self._new_plane)

    def _new_plane(self, octave: int, number: int) -> FractalField:
        seed = np.random.SeedSequence([self._seed, octave, number + 2**20]).generate_state(1, np.uint64)
        return FractalField(int(seed[0]) >> 1, self._octaves[octave][1])

    @cached_property
    def _threshold(self) -> Array:
        """Value (N,) of V' at the surface at even heights, with which tops are as high as columns are thick.

        Lumps above the surface hide those below it: with the value whose thickness is the height, tops of cumulus
        would be 600 m too high. From the top down, the value is what as many of some random columns reach for the
        first time as have that thickness.
        """
        layer, draw, (body, explained) = self._layer, np.random.default_rng(22), self._shape
        coarse = ndtri((draw.permutation(SAMPLES) + 0.5) / SAMPLES)
        field = math.sqrt(explained) * coarse + math.sqrt(max(1.0 - explained, 0.0)) * draw.standard_normal(SAMPLES)
        exponent = self.parameters.brightness_exponent
        (thickness,) = FractalClouds.field_thickness(field.astype(np.float32)[None], layer, exponent, in_place=True)
        coarse, thickness = coarse[thickness > 0.0], thickness[thickness > 0.0]
        # Differences over two pixels, as of windows.
        steps, share = (
            np.array([[octave.y.step, octave.x.step] for octave in body]),
            [octave.variance for octave in body],
        )
        spread = np.sqrt(2.0 * np.array(share) @ (1.0 - KernelCorrelation.tabulate()(2.0 * steps)))
        steep = np.hypot(*(spread[:, None] * draw.standard_normal((2, coarse.size)))) / (2.0 * self._grid.pixel_size_m)
        height = np.linspace(0.0, layer.thickness_max_m, LEVELS)
        lumps = self._spread_lumps(height, lambda octave, number: draw.standard_normal(coarse.size))
        slope, result = np.hypot(steep, self._growth), np.empty(LEVELS)
        value, hidden = np.inf, np.zeros(coarse.size, dtype=bool)
        for level in range(LEVELS - 1, -1, -1):
            reached = coarse + slope * lumps[level]
            within = coarse + slope * np.minimum(lumps[level], 0.0) > self._edge
            first = np.sort(reached[within & ~hidden])[::-1]
            wanted = np.count_nonzero(thickness > height[level]) - np.count_nonzero(hidden)
            if first.size:
                value = min(value, float(first[int(np.clip(wanted, 0, first.size - 1))]))
            result[level] = min(value, HIGHEST)
            hidden |= within & (reached > result[level])
        return result

    def _lumps(self, time_s: float, rows: slice, columns: slice, altitude_m: Array) -> NDArray[np.float32]:
        """Return the height of lumps (Z, y, x), m: V between planes of the lattice with unit variance, as in x and y.

        Its modulus makes lumps round, and what lies between them sharp.
        """
        x = self._pixels("columns", columns, self._grid.columns, self._speed_x, time_s)
        y = self._pixels("rows", rows, self._grid.rows, self._speed_y, time_s)
        return self._spread_lumps(altitude_m, lambda *plane: self._plane(*plane).window(time_s, y, x))

    def _spread_lumps(self, altitude_m: Array, field_of: Callable[[int, int], Any]) -> NDArray[np.float32]:
        """Return the same from the fields of planes, by octave and number."""
        result: Any = np.float32(0.0)
        for octave, (cell_m, _) in enumerate(self._octaves):
            position = altitude_m / cell_m + 0.37 * octave
            levels: list[Any] = [np.float32(0.0)] * position.size
            for plane in range(math.floor(position[0]), math.floor(position[-1]) + 2):
                away = np.abs(position - plane)
                field: Any = field_of(octave, plane) if np.any(away < 1.0) else None
                for level in np.flatnonzero(away < 1.0).tolist():
                    levels[level] = levels[level] + np.float32(math.cos(0.5 * math.pi * away[level])) * field
            displacement = np.stack(levels)
            # The coarsest octave bends the body, the others give it lumps.
            result = result + np.float32(self._roughness * cell_m) * (
                displacement if octave == 0 else np.abs(displacement) - np.float32(0.8)
            )
        lumps: NDArray[np.float32] = result
        return lumps

    def height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares (Z, y, x) of each column between altitudes (Z + 1,)."""
        layer, edges = self._layer, np.asarray(edges_m, dtype=np.float64)
        wide = [slice(span.start - 1, span.stop + 1) for span in (rows, columns)]
        x = self._pixels("columns", wide[1], self._grid.columns, self._speed_x, time_s)
        y = self._pixels("rows", wide[0], self._grid.rows, self._speed_y, time_s)
        body = self._body.window(time_s, y, x).astype(np.float32)
        pixel_m = self._grid.pixel_size_m
        steep = np.hypot(body[2:, 1:-1] - body[:-2, 1:-1], body[1:-1, 2:] - body[1:-1, :-2]) / np.float32(2.0 * pixel_m)
        body = body[1:-1, 1:-1]
        free = np.maximum(layer.thickness_max_m - thickness_m, 0.0)
        moved = self._relief * free * ndtr(self._plane(0, -1000).window(time_s, y, x)[1:-1, 1:-1]).astype(np.float32)
        moved = np.minimum(moved, np.float32(0.5) * thickness_m)
        middle = 0.5 * (edges[:-1] + edges[1:])
        height = middle - layer.base_m if layer.anchor == "base" else layer.base_m + layer.thickness_max_m - middle
        above = (height.astype(np.float32)[:, None, None] - moved).clip(0.0)
        below_base = height.astype(np.float32)[:, None, None] < moved
        # Lumps that stand out of the outline would be cut along it.
        slope, lumps = np.hypot(steep, np.float32(self._growth)), self._lumps(time_s, rows, columns, middle)
        threshold = np.interp(height, np.linspace(0.0, layer.thickness_max_m, LEVELS), self._threshold)
        depth = (body - threshold.astype(np.float32)[:, None, None]) / slope + lumps
        np.minimum(depth, (body - np.float32(self._edge)) / slope + np.minimum(lumps, np.float32(0.0)), out=depth)
        depth[below_base] = -1e4
        # Columns that are left empty are cloudy where the body comes nearest below their own top.
        low, soft = height[:, None, None] <= np.maximum(thickness_m, np.max(np.diff(edges))), np.float32(self._soft_m)
        lacking = soft - np.max(np.where(low, depth, np.float32(-1e4)), axis=0)
        lacking[np.max(depth, axis=0) >= 0.5 * soft] = 0.0
        depth += np.where(low, lacking.clip(0.0), np.float32(0.0))
        shares = np.clip(depth / soft, 0.0, 1.0)
        if layer.anchor == "base":
            shares *= (above + np.float32(0.02 * layer.thickness_max_m)) ** np.float32(2.0 / 3.0)
        shares *= np.diff(edges).astype(np.float32)[:, None, None]
        total = np.sum(shares, axis=0, dtype=np.float64)
        cloudy = (thickness_m > 0.0) & (total > 0.0)
        result: NDArray[np.float32] = np.where(cloudy, shares / np.where(cloudy, total, 1.0), 0.0).astype(np.float32)
        return result
