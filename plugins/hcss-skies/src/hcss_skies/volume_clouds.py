"""The cloud generator `volume`: the clouds of a volume, repeated, for light that sees their sides."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blending import put_in_layer
from hcss_skies.library import find_volume
from hcss_skies.pace import Pace, TurnedPixels, turned
from hcss_skies.parameters import VolumeParameters
from hcss_skies.reel import extinction_m1
from hcss_skies.simulation import MAGNIFIED
from hcss_skies.volume import read_volume
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, CloudDeclaration, CloudInputs, Problem, ProviderError, ScenarioError

_LARGEST = 1.4
"""Largest pixel in cells."""


class VolumeClouds:
    """Clouds of one instant of a large-eddy simulation, with the extinction of every cell.

    The box is repeated without end, displaced by the seed, moves with the wind and is turned along it; clouds do not
    change. Between the middles of cells extinction is interpolated. Altitudes are fractions of the layer. Columns keep
    the optical thickness of the volume as far as the layer is deep enough: their thickness is that which the layer's
    particles need for it. Where the cloud of a column is, light between columns sees (:meth:`height_shares`).

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed and the catalog that records the file.
    parameters : VolumeParameters
        The volume.

    Attributes
    ----------
    image_coverage : float
        Of the volume; that of the layer has no effect.

    Raises
    ------
    CatalogError
        If there is no such volume, or its file is damaged.
    ProviderError
        If pixels are too small or too large for it.
    ScenarioError
        If the layer has tapered edges.
    """

    honours: tuple[str, ...] = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: VolumeParameters) -> None:
        layer = inputs.layer
        if layer.edge_taper != 0.0:
            message = f"{layer.edge_taper:g} given; clouds of a volume have edges of their own; allowed: 0"
            raise ScenarioError([Problem("clouds.edge_taper", message)], origin="clouds of a volume")
        self._inputs = inputs
        self.volume = volume = inputs.catalog.parsed(find_volume(parameters.volume, inputs.catalog), read_volume)
        pixel, cell = inputs.grid.pixel_size_m, volume.cell_m
        if not cell / MAGNIFIED * (1.0 - 1e-9) <= pixel <= _LARGEST * cell * (1.0 + 1e-9):
            raise ProviderError(
                f"volume: pixels of {pixel:g} m; allowed: {cell / MAGNIFIED:g} to {_LARGEST * cell:g} m with the "
                f"volume '{parameters.volume}'"
            )
        self._columns_m = (volume.optical_thickness / extinction_m1(layer)).astype(np.float32)
        cells = self._columns_m.copy()
        put_in_layer(cells, np.float32(layer.thickness_min_m), np.float32(layer.thickness_max_m))
        self.image_coverage = float(np.mean(cells > 0.0))
        self._pace = Pace.of(inputs.motion)
        self._turn = turned(volume.frame_m_s, inputs.motion.cloud_velocity_m_s)
        self._start_m = np.random.default_rng([inputs.seed, 0x701]).random(2) * cell * np.array(self._columns_m.shape)
        moves = any(self._pace.speed_m_s)
        self.declares = CloudDeclaration(
            depends_on=frozenset({"time"} if moves else ()),
            notes=(f"Volume {parameters.volume}: {volume.kind}, {volume.source} ({volume.licence})",),
        )
        self.skipped: tuple[tuple[str, str], ...] = (
            ("heights of the volume without radiance.light", "columns of thickness alone on the base of the layer"),
        ) + ((("change of cloud shapes", "a volume is one instant"),) if self._pace.evolves else ())

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window; 0 is clear sky.

        Raises
        ------
        ValueError
            If the time is not finite.
        """
        layer = self._inputs.layer
        thickness: NDArray[np.float32] = self._between(self._columns_m[None], time_s, rows, columns)[0]
        put_in_layer(thickness, np.float32(layer.thickness_min_m), np.float32(layer.thickness_max_m))
        return thickness

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares (Z, y, x) of each column between altitudes (Z + 1,), of any window."""
        layer, edges = self._inputs.layer, np.asarray(edges_m, np.float64)
        bottom, top = self.volume.edges_m[[0, -1]]
        within = bottom + (edges - layer.base_m) * ((top - bottom) / layer.thickness_max_m)
        # the first and the last slice have what rounding leaves beside them
        place = np.interp(within, self.volume.edges_m, np.arange(self.volume.edges_m.size))
        low = np.minimum(place.astype(np.intp), self.volume.edges_m.size - 2)
        share = (place - low).astype(np.float32)[:, None, None]
        below = self._below[low] + share * (self._below[low + 1] - self._below[low])
        shares = self._between(np.maximum(np.diff(below, axis=0), 0.0), time_s, rows, columns)
        total = shares.sum(axis=0)
        cloudy = (thickness_m > 0.0) & (total > 0.0)
        shares *= np.where(cloudy, np.float32(1.0) / np.where(cloudy, total, np.float32(1.0)), np.float32(0.0))
        return shares

    @cached_property
    def _below(self) -> NDArray[np.float32]:
        """Optical thickness (Z + 1, rows, columns) below the edges of the levels."""
        depth = np.diff(self.volume.edges_m)[:, None, None] * self.volume.extinction_m1
        below: NDArray[np.float32] = np.concatenate((np.zeros_like(depth[:1]), np.cumsum(depth, axis=0)))
        return below.astype(np.float32)

    def _between(self, fields: Any, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return periodic fields (F, rows, columns) of cells at the pixels of a window (F, y, x)."""
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        out = np.empty((len(fields), max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)), np.float32)
        first = rows.start, columns.start
        y, x = self._pace.positions_m(self._inputs.grid, first, out.shape[1:], time_s)
        places = TurnedPixels.of(y, x, self._turn, self.volume.cell_m)
        start = self._start_m / self.volume.cell_m
        between(
            out, np.ascontiguousarray(fields, np.float32), places.y, places.y_turned, places.x, places.x_turned, start
        )
        return out


@kernel(fastmath={"contract"})
def between(out: Any, fields: Any, y: Any, y_turned: Any, x: Any, x_turned: Any, start: Any) -> None:
    """Write periodic fields (F, rows, columns) between the middles of cells, bilinear, at places (F, Y, X).

    Parameters
    ----------
    y, y_turned, x, x_turned : ndarray of float64
        Where the pixels are: see :class:`hcss_skies.pace.TurnedPixels`.
    start : ndarray of float64 (2,)
        Row and column of the origin.
    """
    rows, columns = fields.shape[1:]
    for i in range(y.size):
        for j in range(x.size):
            at_y, at_x = y[i] - x_turned[j] + start[0], x[j] + y_turned[i] + start[1]
            low_y, low_x = math.floor(at_y), math.floor(at_x)
            fy, fx = np.float32(at_y - low_y), np.float32(at_x - low_x)
            k, m = np.int64(low_y) % rows, np.int64(low_x) % columns
            above, right = (k + 1) % rows, (m + 1) % columns
            for n in range(fields.shape[0]):
                field = fields[n]
                low = field[k, m] + fx * (field[k, right] - field[k, m])
                high = field[above, m] + fx * (field[above, right] - field[above, m])
                out[n, i, j] = low + fy * (high - low)
