"""Fractal clouds with a shape in height: bases and tops with relief, soft edges, and three-dimensional octaves.

Thickness is that of the generator ``fractal``, so that columns keep their optical thickness. It is spread over heights
by V(x, y, z, t) of eqs 2-4 of the HCSS paper: two octaves with the lattice cells of the layer's type, also along z.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.special import ndtr

from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.octaves import separate_octaves
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, CloudInputs

STRETCH = 1.3
"""Height of a column over its thickness: extinction falls toward both ends."""

SHARES = (0.8, 0.6)
"""Amplitudes of the coarser and the finer octave."""


class ReliefParameters(FractalParameters):
    """Those of ``fractal``, and the shape in height."""

    base_relief: float = Field(
        default=0.2, ge=0.0, le=1.0, description="Part of the free height of the layer by which flat ends move."
    )
    roughness: float = Field(
        default=0.5, ge=0.0, le=3.0, description="Amplitude of the three-dimensional octaves over the mean extinction."
    )


class ReliefClouds(FractalClouds):
    """The generator ``fractal-relief``; see :class:`hcss_twin.providers.clouds.CloudGeneratorOptions`.

    The extinction of a column is (4 u (1 - u) + roughness V) where this is positive, u being the height over that of
    the column, which is 1.3 times its thickness within the layer.
    """

    def __init__(self, inputs: CloudInputs, parameters: ReliefParameters) -> None:
        flat = {name: getattr(parameters, name) for name in FractalParameters.model_fields}
        given = {name: value for name, value in flat.items() if name in parameters.model_fields_set}
        super().__init__(inputs, FractalParameters(**given))
        self._relief, self._roughness, self._seed = parameters.base_relief, parameters.roughness, inputs.seed
        own = self.parameters
        assert own.gamma is not None
        assert own.L is not None
        assert own.k is not None
        widest = 16_000.0 / math.sqrt(own.L[0] * own.L[1])
        wanted = math.log(widest / (0.5 * inputs.layer.thickness_max_m), own.gamma)
        coarse = min(max(round(wanted), own.k[0]), max(own.k[1] - 1, own.k[0]))
        self._octaves = []
        for k in (coarse, min(coarse + max(round(math.log(2.0, own.gamma)), 1), 16)):
            shape = own.model_copy(update={"k": (k, k)})
            self._octaves.append((k, widest / own.gamma**k, separate_octaves(shape, inputs.grid, inputs.motion, False)))
        self._plane = lru_cache(maxsize=256)(self._new_plane)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_plane"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._plane = lru_cache(maxsize=256)(self._new_plane)

    def _new_plane(self, octave: int, number: int) -> FractalField:
        seed = np.random.SeedSequence([self._seed, octave, number + 2**20]).generate_state(1, np.uint64)
        return FractalField(int(seed[0]) >> 1, self._octaves[octave][2])

    def _noise(self, time_s: float, rows: slice, columns: slice, altitude_m: Array) -> NDArray[np.float32]:
        """Return V (Z, y, x): between planes of the lattice with unit variance, as along the other axes."""
        x = self._pixels("columns", columns, self._grid.columns, self._speed_x, time_s)
        y = self._pixels("rows", rows, self._grid.rows, self._speed_y, time_s)
        result = np.zeros((altitude_m.size, y.count, x.count), dtype=np.float32)
        for octave, (amplitude, (_, cell_m, _)) in enumerate(zip(SHARES, self._octaves, strict=True)):
            place = altitude_m / cell_m + 0.37 * octave
            for plane in range(math.floor(place[0]), math.floor(place[-1]) + 2):
                away = np.abs(place - plane)
                near = np.flatnonzero(away < 1.0)
                if near.size:
                    field = self._plane(octave, plane).window(time_s, y, x)
                    weights = amplitude * np.cos(0.5 * math.pi * away[near])
                    result[near] += weights.astype(np.float32)[:, None, None] * field
        return result

    def height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares (Z, y, x) of each column between altitudes (Z + 1,)."""
        layer, edges = self._layer, np.asarray(edges_m, dtype=np.float64)
        x = self._pixels("columns", columns, self._grid.columns, self._speed_x, time_s)
        y = self._pixels("rows", rows, self._grid.rows, self._speed_y, time_s)
        free = np.maximum(layer.thickness_max_m - thickness_m, 0.0)
        # Ends of columns move with the coarser octave of a plane of its own.
        moved = self._relief * free * ndtr(self._plane(0, -1000).window(time_s, y, x)).astype(np.float32)
        height = np.minimum(STRETCH * thickness_m, layer.thickness_max_m - moved)
        low = moved if layer.anchor == "base" else layer.thickness_max_m - moved - height
        low, height = (low + layer.base_m)[None], np.maximum(height, 1e-3)[None]
        bottom, top = edges[:-1, None, None], edges[1:, None, None]
        inside = np.clip(np.minimum(top, low + height) - np.maximum(bottom, low), 0.0, None).astype(np.float32)
        middle = 0.5 * (np.clip(bottom, low, low + height) + np.clip(top, low, low + height))
        part = ((middle - low) / height).astype(np.float32)
        noise = self._noise(time_s, rows, columns, 0.5 * (edges[:-1] + edges[1:]))
        shares = inside * np.maximum(4.0 * part * (1.0 - part) + np.float32(self._roughness) * noise, 0.0)
        # Where noise leaves nothing, the column is uniform.
        shares = np.where(np.sum(shares, axis=0) > 1e-3 * height[0], shares, inside)
        total = np.sum(shares, axis=0, dtype=np.float64)
        cloudy = (thickness_m > 0.0) & (total > 0.0)
        result: NDArray[np.float32] = np.where(cloudy, shares / np.where(cloudy, total, 1.0), 0.0).astype(np.float32)
        return result
