"""Cloud shadows on the clear sea: tables of the direct sunlight that clouds transmit, and their use in each frame.

The direct transmission of a band is the mean of exp(-k s) over it (Bouguer's law), with the extinction k of the
optics provider and the length s of the sun's path in the cloud, thickness / mu0, weighted by the spectrum of the
clear column's solar terms. Tables contain its negative logarithm, the effective optical thickness as a function of s:
a straight line for grey clouds, otherwise a curve between the lines of the largest and smallest k.

In each frame the layer is divided into slices of equal height, in each of which the sun's path moves by at most one
point along either axis. The cloud in a slice is sampled at the nearest point to the path at the middle height of the
slice; there it extends from the layer's flat side by the thickness. For a uniform layer the slices add up to its
thickness.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.cube.variables import SHADOW_MASK
from hcss_twin.engine.tables.radiance_tables import TOTAL, Quantities, RadianceTables, ShadowTables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import displacement_m, sea_sun_terms
from hcss_twin.plan.windows import Window, points_of
from hcss_twin.providers import CloudGenerator, CloudLayer, Sun

FIRST_INTERVALS = 16


def compile_shadows(
    plan: Plan, quantities: Quantities, time_s: Sequence[float], clear: Callable[[Sun | None], Array]
) -> ShadowTables | None:
    """Compute the shadow tables at the time nodes of the radiance tables; None if there are no shadows.

    Parameters
    ----------
    clear : callable
        Terms (K, B) of the clear column as in the radiance tables.
    """
    if not (plan.assembly.slant.shadows and plan.layers and plan.sun_matters):
        return None
    names = sea_sun_terms(plan.assembly.model)
    suns = [plan.sun_at(time) for time in time_s]
    loss = np.stack([_loss(clear(sun), quantities, names) for sun in suns])
    wavenumber, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1
    spectra = [
        weights * np.sum([np.asarray(terms[name]) for name in names], axis=0)
        for terms in (plan.assembly.model.clear(wavenumber, sun) for sun in suns)
    ]
    # Without sunlight there are no weights, and no loss.
    spectra = [np.where(np.sum(each, axis=1, keepdims=True) > 0.0, each, np.abs(weights)) for each in spectra]
    extinction = [
        plan.assembly.optics.single_scattering(layer.microphysics, wavenumber).extinction_m1 for layer in plan.layers
    ]
    mu0 = math.cos(math.radians(float(np.max(plan.assembly.slant.sun_zenith_deg))))
    longest = np.array([layer.thickness_max_m / mu0 for layer in plan.layers])

    def depth(part: Array) -> Array:
        """Effective optical thickness (T, L, N, B) at parts (N,) of the longest paths."""
        return np.array(
            [
                [
                    np.stack([_depth(k, each, part * length) for each in spectrum], axis=1)
                    for k, length in zip(extinction, longest, strict=True)
                ]
                for spectrum in spectra
            ]
        )

    return ShadowTables(tuple(time_s), longest, loss, _tabulated(depth, plan.budget.shadows))


def _loss(terms: Array, quantities: Quantities, names: Sequence[str]) -> Array:
    """Sea-reflected direct sunlight in each quantity of the clear column (Q, B), from its terms (K, B)."""
    places = {name: quantities.terms.index(name) for name in names}
    nothing = np.zeros(terms.shape[1])
    return np.stack(
        [
            np.sum([terms[place] for place in places.values()], axis=0)
            if name == TOTAL
            else terms[places[name]]
            if name in places
            else nothing
            for name in quantities.names
        ]
    )


def _depth(extinction_m1: Array, weights: Array, path_m: Array) -> Array:
    """Negative logarithm (N,) of the weighted mean of exp(-k s) over the wavenumbers (V,)."""
    from scipy.special import logsumexp  # takes 0.1 s to import

    seen = weights > 0.0
    k, w = extinction_m1[seen], weights[seen]
    least = float(np.min(k))
    # Relative to the smallest extinction, to avoid underflow behind the thickest cloud.
    excess = logsumexp(-(k - least) * path_m[:, None], b=w / np.sum(w), axis=1)
    result: Array = least * path_m - excess
    return result


def _tabulated(depth: Callable[[Array], Array], tolerance: float) -> Array:
    """Halve the intervals of a table over [0, 1], uniform in the root, until its transmission is linear enough."""
    intervals = FIRST_INTERVALS
    table = depth(np.linspace(0.0, 1.0, intervals + 1) ** 2)
    while True:
        finer = depth(np.linspace(0.0, 1.0, 2 * intervals + 1) ** 2)
        # The middle of an interval in the root is not the middle in the square.
        low, high = np.arange(intervals) ** 2.0, np.arange(1, intervals + 1) ** 2.0
        share = (((np.arange(intervals) + 0.5) ** 2 - low) / (high - low))[:, None]
        guess = (1.0 - share) * table[..., :-1, :] + share * table[..., 1:, :]
        error = np.max(np.abs(np.exp(-guess) - np.exp(-finer[..., 1::2, :])))
        table, intervals = finer, 2 * intervals
        if not error > tolerance:
            return table


Thickness = NDArray[np.float32]


@dataclass(frozen=True)
class SunPaths:
    """Slices of one layer along the sun's paths at one instant.

    Attributes
    ----------
    shifts : ndarray of int64 (S, 2)
        Displacement in points (rows, columns) from the sea point to its path in each slice.
    from_flat_m : ndarray (S,)
        Distance from the layer's flat side to the near face of the slice.
    slice_m : float
        Height of each slice.
    """

    shifts: NDArray[np.int64]
    from_flat_m: NDArray[np.float64]
    slice_m: float

    def stay_at(self, shift: tuple[int, int]) -> bool:
        """Whether all slices have the same displacement."""
        return bool(np.all(self.shifts == np.array(shift)))

    def heights_m(self, generator: CloudGenerator, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the vertical path length (y, x) in cloud of the sun's paths to the points of a window.

        Dividing by the cosine of the sun's zenith angle gives the path length.

        Parameters
        ----------
        generator : CloudGenerator
            With the method ``displaced_m`` of :class:`hcss_twin.plan.clouds.DisplacedClouds`.
        """
        first, last = self.shifts.min(axis=0), self.shifts.max(axis=0)
        wide = (
            slice(window.start, window.stop + int(high - low))
            for window, low, high in zip((rows, columns), first, last, strict=True)
        )
        start = int(first[0]), int(first[1])
        thickness = generator.displaced_m(time_s, *wide, start)  # type: ignore[attr-defined]
        heights = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        _add_slices(heights, np.ascontiguousarray(thickness), self.shifts - first, self.from_flat_m, self.slice_m)
        return heights


def sun_paths(layer: CloudLayer, sun: Sun, point_m: float) -> SunPaths:
    """Divide a layer into slices for the sun at one instant."""
    moved = displacement_m(layer.thickness_max_m, sun.zenith_deg, sun.azimuth_deg)
    count = max(1, math.ceil(float(np.max(np.abs(moved))) / point_m))
    middle = layer.base_m + layer.thickness_max_m * (np.arange(count) + 0.5) / count
    away = np.stack([displacement_m(height, sun.zenith_deg, sun.azimuth_deg) for height in middle])
    from_base = layer.thickness_max_m * np.arange(count) / count
    from_flat = from_base if layer.anchor == "base" else from_base[::-1]
    shifts = np.rint(away / point_m).astype(np.int64)
    return SunPaths(shifts, from_flat, layer.thickness_max_m / count)


@kernel()
def _add_slices(heights, thickness, shifts, from_flat, slice_m):  # type: ignore[no-untyped-def]
    """Add the cloud of each slice to ``heights``, in single precision like the thickness."""
    full, nothing = np.float32(slice_m), np.float32(0.0)
    for s in range(shifts.shape[0]):
        down, right, near = shifts[s, 0], shifts[s, 1], np.float32(from_flat[s])
        for y in range(heights.shape[0]):
            for x in range(heights.shape[1]):
                inside = thickness[y + down, x + right] - near
                heights[y, x] += min(max(inside, nothing), full)


class Shadows:
    """Shadows of a scene by instant.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance; the mask does not need tables.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._tables = None if tables is None else tables.shadows
        self._point_m = plan.grid.pixel_size_m / plan.samples_per_pixel

    def at(self, time_s: float) -> InstantShadows | None:
        """Return the shadows at one instant; None if there are none."""
        plan = self._plan
        if not (plan.assembly.slant.shadows and plan.layers and plan.sun_matters):
            return None
        sun = plan.sun_track.at(time_s)
        if not sun.is_up:
            return None
        paths: list[SunPaths | None] = []
        for layer in plan.layers:
            met = sun_paths(layer, sun, self._point_m)
            # If line of sight and sun path intersect the layer at the same point, it is clear or cloudy for both.
            paths.append(None if met.stay_at(plan.assembly.slant.of_view(layer, self._point_m)) else met)
        return InstantShadows(plan, self._tables, time_s, sun, paths) if any(paths) else None


class InstantShadows:
    """Shadows at one instant.

    Parameters
    ----------
    paths : sequence of SunPaths or None
        Paths through each layer; None if the layer cannot shade points that it leaves clear.
    """

    def __init__(
        self, plan: Plan, tables: ShadowTables | None, time_s: float, sun: Sun, paths: Sequence[SunPaths | None]
    ) -> None:
        self._plan = plan
        self._time_s = time_s
        self._paths = paths
        layers = len(plan.layers)
        if tables is None:
            self._loss, self._depth = np.zeros((0, 0)), np.zeros((layers, 2, 0))
            self._part = np.zeros(layers)
        else:
            self._loss, self._depth = tables.at(time_s)
            self._part = 1.0 / (math.cos(math.radians(sun.zenith_deg)) * tables.longest_m)

    def cast(
        self,
        window: Window,
        thickness_m: Sequence[Thickness],
        radiance: NDArray[np.float32],
        truth: dict[str, NDArray[Any]],
        place: Window | None = None,
    ) -> NDArray[np.bool_]:
        """Subtract the sunlight that clouds block from the clear points of a window.

        Parameters
        ----------
        window : (slice, slice)
            Rows and columns, in pixels of the image.
        thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
            Thickness of each layer as seen from the points.
        radiance : ndarray of float32 (C, y, x)
            Radiance of a part of the image; C may be 0.
        truth : dict of str to ndarray
            Truth variables of the same part, possibly including the shadow mask.
        place : (slice, slice), optional
            Position of the window in the part; by default the part is the whole image.

        Returns
        -------
        ndarray of bool (window rows, window columns)
            Pixels partly or fully in shadow.
        """
        place = window if place is None else place
        mask = truth.get(SHADOW_MASK)
        if mask is None:
            mask = np.zeros(radiance.shape[1:], dtype=np.uint8)
        _cast(
            radiance,
            mask,
            place[0].start,
            place[1].start,
            self._plan.samples_per_pixel,
            ~np.any([each > 0 for each in thickness_m], axis=0),
            self._in_cloud(window),
            self._part,
            self._depth,
            self._loss,
        )
        shaded: NDArray[np.bool_] = mask[place] > 0
        return shaded

    def _in_cloud(self, window: Window) -> Thickness:
        """Vertical path length in each layer's cloud of the sun's paths to the points of a window (L, y, x)."""
        plan = self._plan
        rows, columns = (points_of(pixels, plan.samples_per_pixel) for pixels in window)
        heights = np.zeros((len(plan.layers), rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        for layer, generator, paths in zip(heights, plan.assembly.generators, self._paths, strict=True):
            if paths is not None:
                layer[:] = paths.heights_m(generator, self._time_s, rows, columns)
        return heights


@kernel()
def _cast(  # type: ignore[no-untyped-def]
    radiance, mask, row, column, samples, clear, in_cloud, part, depth, loss
):
    """Shade clear points; ``part`` (L,): fraction of the longest path per metre of height in cloud."""
    layers, intervals, bands = depth.shape[0], depth.shape[1] - 1, depth.shape[2]
    share = 1.0 / (samples * samples)
    kept_back, path = np.empty(bands), np.empty(bands)
    for y in range(clear.shape[0] // samples):
        for x in range(clear.shape[1] // samples):
            shaded = False
            kept_back[:] = 0.0
            for i in range(y * samples, (y + 1) * samples):
                for j in range(x * samples, (x + 1) * samples):
                    if not clear[i, j]:
                        continue
                    met = False
                    for n in range(layers):
                        height = np.float64(in_cloud[n, i, j])
                        if height <= 0.0:
                            continue
                        if not met:
                            met = True
                            path[:] = 0.0
                        # Nodes are uniform in the square root; paths slightly beyond the last node by rounding
                        # extrapolate the last line.
                        root = math.sqrt(height * part[n]) * intervals
                        k = min(int(root), intervals - 1)
                        inside = (root * root - k * k) / (2.0 * k + 1.0)
                        for b in range(bands):
                            low = depth[n, k, b]
                            path[b] += low + inside * (depth[n, k + 1, b] - low)
                    if met:
                        shaded = True
                        for b in range(bands):
                            kept_back[b] -= math.expm1(-path[b])
            if not shaded:
                continue
            mask[row + y, column + x] = 1
            for q in range(loss.shape[0]):
                for b in range(bands):
                    if loss[q, b] != 0.0:
                        left = np.float64(radiance[q * bands + b, row + y, column + x])
                        left -= loss[q, b] * kept_back[b] * share
                        # Rounding to single precision can make a zero remainder negative.
                        radiance[q * bands + b, row + y, column + x] = np.float32(max(left, 0.0))
