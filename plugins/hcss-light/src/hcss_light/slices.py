"""Clouds cut into horizontal slices, and their direct light along one direction.

View and sun are constant directions, so a slanted ray is a shift of each slice: no ray is traced. Slices are so thin
that a ray moves by at most one point within each. All fields are periodic; callers add margins where they are not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_light.voxels import LightError
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

Field = NDArray[np.float32]
Shape = Literal["uniform", "adiabatic"]

LEAST_SLICES, MOST_SLICES = 16, 512
HIGHEST_SLICE_OPTICAL_THICKNESS = 1.0
"""Vertical optical thickness of the thickest slice: the source is constant within it."""

OPAQUE = 1e-12
"""Least transmittance of cloud that is told from 0: smaller numbers would be slow."""

VIEW_RAYS = 5
"""Rays of each line of sight."""

RAYS = 4
"""Rays of sunlight through each column, on a turned lattice: each has a row and a column of its own."""

DENSEST = 5.0 / 3.0
"""Extinction at the top of an adiabatic column over its mean."""

NOWHERE_M = 1e12
"""Distance between columns of which none is meant to see another."""


@dataclass(frozen=True)
class Slices:
    """Horizontal slices of one cloud layer.

    Parameters
    ----------
    base_m, top_m : float
        Altitudes of the layer.
    count : int
        Number of slices, of equal height.
    anchor : {"base", "top"}
        Which end of all columns is flat.
    point_m : float
        Distance between columns.
    """

    base_m: float
    top_m: float
    count: int
    anchor: Literal["base", "top"]
    point_m: float

    @property
    def height_m(self) -> float:
        """Height of a slice."""
        return (self.top_m - self.base_m) / self.count

    @property
    def edges_m(self) -> Array:
        """Altitudes (Z + 1,) between them."""
        edges: Array = np.linspace(self.base_m, self.top_m, self.count + 1)
        return edges

    @property
    def middle_m(self) -> Array:
        """Altitudes (Z,) of their middles, upward."""
        middle: Array = np.linspace(self.base_m, self.top_m, 2 * self.count + 1)[1::2]
        return middle

    def apart(self) -> Slices:
        """Return the same slices with columns so far apart that none sees another: each is a uniform cloud."""
        return replace(self, point_m=NOWHERE_M)

    @property
    def are_apart(self) -> bool:
        """Whether no column sees another."""
        return self.point_m >= NOWHERE_M

    def shifts(self, zenith_deg: float, azimuth_deg: float, reference_m: float) -> Array:
        """Return by how many rows and columns (Z, 2) a ray is displaced at each slice from its place at an altitude.

        The ray goes up toward a direction whose azimuth counts clockwise from north (rows) to east (columns).
        """
        away = (self.middle_m - reference_m) * math.tan(math.radians(zenith_deg)) / self.point_m
        azimuth = math.radians(azimuth_deg)
        return np.stack((away * math.cos(azimuth), away * math.sin(azimuth)), axis=1)

    def density(self, thickness_m: Field, shape: Shape = "uniform", shares: Field | None = None) -> Field:
        """Return the extinction (Z, y, x) of each slice over the mean extinction of cloud, from the thickness (y, x).

        Parameters
        ----------
        shape : {"uniform", "adiabatic"}
            The extinction grows as the power 2/3 of the height above the column's base if droplets that condense in
            rising air keep their number; columns keep their optical thickness.
        shares : ndarray (Z, y, x), optional
            Of each column in each slice, instead of a shape.
        """
        if shares is not None:
            spread: Field = shares * (thickness_m / np.float32(self.height_m))
            return spread
        result = np.empty((self.count, *thickness_m.shape), dtype=np.float32)
        power = 5.0 / 3.0 if shape == "adiabatic" else 1.0
        hanging = self.anchor == "top"
        _densities(np.ascontiguousarray(thickness_m, dtype=np.float32), self.height_m, hanging, power, result)
        return result


def slices_of(
    base_m: float, top_m: float, anchor: Literal["base", "top"], point_m: float, steepest_deg: float, optical: float
) -> Slices:
    """Return slices for rays up to a zenith angle through a layer of a vertical optical thickness.

    Raises
    ------
    LightError
        If the rays are so slanted that too many slices are needed.
    """
    height = top_m - base_m
    count = max(
        LEAST_SLICES,
        math.ceil(height * math.tan(math.radians(steepest_deg)) / point_m - 1e-9),
        math.ceil(optical / HIGHEST_SLICE_OPTICAL_THICKNESS),
    )
    if count > MOST_SLICES:
        raise LightError(
            f"a layer of {height:g} m seen or lit at {steepest_deg:.4g} deg needs {count} slices at {point_m:g} m; "
            f"allowed: {MOST_SLICES}; larger pixels or a higher sun or sensor need fewer"
        )
    return Slices(base_m, top_m, count, anchor, point_m)


@kernel()
def _densities(thickness: Any, slice_m: float, hanging: bool, power: float, result: Any) -> None:
    count, rows, columns = result.shape
    for s in range(count):
        for y in range(rows):
            for x in range(columns):
                cloud_m = float(thickness[y, x])
                if cloud_m <= 0.0:
                    result[s, y, x] = 0.0
                    continue
                base = count * slice_m - cloud_m if hanging else 0.0
                low = min(max((s * slice_m - base) / cloud_m, 0.0), 1.0)
                high = min(max(((s + 1) * slice_m - base) / cloud_m, 0.0), 1.0)
                share = high - low if power == 1.0 else high**power - low**power
                result[s, y, x] = share * cloud_m / slice_m


@kernel()
def paths(density: Any, slice_m: float, shifts: Any, amount: Any) -> None:
    """Write the path in cloud times cosine (y, x), m, of the mean line of sight of each point."""
    count, rows, columns = density.shape
    amount[:] = 0.0
    part = np.float32(slice_m / VIEW_RAYS)
    for s in range(count):
        for ray in range(VIEW_RAYS):
            row, back = crossed(shifts, s, ray, rows, columns)
            for y in range(rows):
                amount_row, cloud = amount[y], density[s, (y + row) % rows]
                add(amount_row[: columns - back], cloud[back:], part)
                add(amount_row[columns - back :], cloud[:back], part)


@kernel(inner=True)
def add(total: Any, values: Any, part: Any) -> None:
    """Add a part of values to a total."""
    for x in range(total.size):
        total[x] += part * values[x]


@kernel(inner=True)
def pass_on(seen: Any, total: Any, kept: Any, light: Any) -> None:
    """Add the light of voxels as far as it is seen, and keep what is seen of those behind."""
    opaque = np.float32(OPAQUE)
    for x in range(seen.size):
        total[x] += seen[x] * light[x]
        seen[x] = max(seen[x] * kept[x], opaque)


@kernel(inner=True)
def crossed(shifts: Any, s: int, ray: int, rows: int, columns: int) -> Any:
    """Return by how many rows and columns a ray is displaced that crosses points in a part of their area."""
    down, right = shifts[s, 0] + (ray + 0.5) / VIEW_RAYS, shifts[s, 1] + ((2 * ray) % VIEW_RAYS + 0.5) / VIEW_RAYS
    return int(np.floor(down)) % rows, int(np.floor(right)) % columns


@kernel(inner=True)
def absorbed(density: Any, per: Any, share: Any) -> Any:
    """Write 1 - exp(-per density) within 1e-6, and return whether there is cloud.

    From the series of a 32nd part and 1 - (1 - q)^2 = q (2 - q), without branches: eight values at once.
    """
    most, least = np.float32(20.0 / 32.0), np.float32(0.0)
    part = per / np.float32(32.0)
    c2, c3, c4, c5 = np.float32(1.0 / 2.0), np.float32(1.0 / 6.0), np.float32(1.0 / 24.0), np.float32(1.0 / 120.0)
    two, one = np.float32(2.0), np.float32(1.0)
    for x in range(density.size):
        d = min(part * density[x], most)
        q = d * (one - d * (c2 - d * (c3 - d * (c4 - d * c5))))
        q *= two - q
        q *= two - q
        q *= two - q
        q *= two - q
        q *= two - q
        share[x] = q
    cloudy = 0
    for x in range(density.size):
        cloudy += density[x] > least
    return cloudy > 0


@kernel(inner=True)
def emit(share: Any, light: Any, source: Any, black: Any) -> None:
    """Write the light of voxels that absorb a share, and replace this by what they let through."""
    one = np.float32(1.0)
    if source.size:
        for x in range(share.size):
            light[x] = share[x] * (black + source[x])
    else:
        for x in range(share.size):
            light[x] = share[x] * black
    for x in range(share.size):
        share[x] = one - share[x]


@kernel()
def march(
    density: Any, source: Any, of_height: Any, extinction: float, slice_m: float, cosine: float, shifts: Any,
    below: float, radiance: Any,
) -> None:  # fmt: skip
    """Add up emission and scattering toward the view, from the top slice down to the surface.

    Each point is seen by :data:`VIEW_RAYS` rays, spread evenly over its area. They cross whole voxels: a mixture of
    cloud and clear sky beside it would be opaque, although the sky is seen through a part of the point.

    Parameters
    ----------
    density : ndarray (Z, y, x)
    source : ndarray (Z, y, x)
        Source function of each voxel, in addition to that of its height; empty: none.
    of_height : ndarray (Z,)
        Source function of each slice.
    extinction : float
        1/m where the density is 1.
    shifts : ndarray (Z, 2)
    below : float
        Radiance that comes from below the clouds.
    radiance : ndarray of float32 (y, x), written
    """
    count, rows, columns = density.shape
    open_sky = np.ones((VIEW_RAYS, rows, columns), dtype=np.float32)
    through, glow = np.empty((rows, columns), dtype=np.float32), np.empty((rows, columns), dtype=np.float32)
    cloudy, none = np.empty(rows, dtype=np.bool_), np.empty(0, dtype=np.float32)
    per, black = np.float32(extinction * slice_m / cosine), of_height.astype(np.float32)
    radiance[:] = 0.0
    for s in range(count - 1, -1, -1):
        for y in range(rows):
            cloudy[y] = absorbed(density[s, y], per, through[y])
            emit(through[y], glow[y], source[s, y] if source.shape[0] > 0 else none, black[s])
        for ray in range(VIEW_RAYS):
            row, back = crossed(shifts, s, ray, rows, columns)
            for y in range(rows):
                if not cloudy[(y + row) % rows]:
                    continue
                seen, radiance_row = open_sky[ray, y], radiance[y]
                kept, light = through[(y + row) % rows], glow[(y + row) % rows]
                pass_on(seen[: columns - back], radiance_row[: columns - back], kept[back:], light[back:])
                pass_on(seen[columns - back :], radiance_row[columns - back :], kept[:back], light[:back])
    for ray in range(VIEW_RAYS):
        for y in range(rows):
            cloudy[y] = False
            for x in range(columns):
                radiance[y, x] += open_sky[ray, y, x] * below
    for y in range(rows):
        for x in range(columns):
            radiance[y, x] /= VIEW_RAYS


@kernel()
def direct_sunlight(
    density: Any, extinction: float, slice_m: float, cosine: float, shifts: Any, as_depth: bool, sunlight: Any
) -> None:
    """Write the mean direct transmission (Z, y, x) of sunlight in each voxel, or its negative logarithm.

    Rays fall evenly on each column of the lowest slice. Each crosses whole voxels: mixtures of neighbours would let
    light through between them that neither of them lets through.
    """
    count, rows, columns = density.shape
    passed = np.ones((RAYS, rows, columns))
    per = extinction * slice_m / cosine
    for s in range(count - 1, -1, -1):
        for y in range(rows):
            for x in range(columns):
                if density[s, y, x] <= 0.0:
                    sunlight[s, y, x] = 0.0 if as_depth else 1.0
                    continue
                depth = per * density[s, y, x]
                kept, entering = np.exp(-depth), 0.0
                for ray in range(RAYS):
                    down, right = aside(shifts[s, 0], shifts[s, 1], ray)
                    row, column = (y - down) % rows, (x - right) % columns
                    entering += passed[ray, row, column]
                    passed[ray, row, column] *= kept
                mean = entering / RAYS * (1.0 - 0.5 * depth if depth < 1e-4 else -np.expm1(-depth) / depth)
                sunlight[s, y, x] = -np.log(max(mean, 1e-300)) if as_depth else mean


@kernel(inner=True)
def aside(down: float, right: float, ray: int) -> tuple[int, int]:
    """Return by how many rows and columns a ray is displaced that crosses the lowest slice in a part of its column."""
    return int(np.floor(down + (ray + 0.5) / RAYS)), int(np.floor(right + ((2 * ray + 1) % (RAYS + 1) + 0.5) / RAYS))
