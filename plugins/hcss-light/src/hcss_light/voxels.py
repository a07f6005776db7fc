"""Clouds on voxels over a flat surface, at one wavenumber."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.providers import Array, HcssError


class LightError(HcssError):
    """An input of hcss-light that is not allowed."""


@dataclass(frozen=True, eq=False)
class Voxels:
    """Optical properties of a layer of air with clouds, periodic along x and y, above a Lambertian surface.

    Parameters
    ----------
    extinction : array_like (X, Y, Z)
        Of particles, 1/m; Z counts upward.
    edges_m : array_like (Z + 1,)
        Altitudes between the levels, ascending from that of the surface.
    size_m : (float, float)
        Sides of a voxel along x and y.
    albedo : float or array_like (Z,)
        Single-scattering albedo of the particles, of each level.
    gas : array_like (Z,)
        Absorption coefficient of the gas, 1/m.
    source : array_like (Z,)
        Planck radiance of each level; 0 without emission.
    surface_albedo, surface_source : float
        Of the Lambertian surface, and the Planck radiance of its temperature.
    sky_source : float
        Radiance of the sky above, without the sun.
    kind : array_like of int (Z,), optional
        Number of the particles of each level among the phase functions; 0 by default.
    moved_m : array_like (Z, 2), optional
        Displacement of the columns of each level along x and y from those of their number; none by default.
    per : array_like (Z,), optional
        By what the extinction of each level is multiplied; 1 by default. Wavenumbers then share their voxels.
    """

    extinction: Array
    edges_m: Array
    size_m: tuple[float, float]
    albedo: float | Array
    gas: Array
    source: Array
    surface_albedo: float = 0.0
    surface_source: float = 0.0
    sky_source: float = 0.0
    kind: NDArray[np.int64] | None = None
    moved_m: Array | None = None
    per: Array | None = None

    def __post_init__(self) -> None:
        extinction = _array("extinction", self.extinction, 3)
        levels = extinction.shape[2]
        edges = _array("edges_m", self.edges_m, 1, -np.inf)
        if edges.shape != (levels + 1,) or np.any(np.diff(edges) <= 0.0):
            raise LightError(f"edges_m: {edges.size} values; allowed: {levels + 1}, ascending")
        for name in ("gas", "source"):
            value = _array(name, getattr(self, name), 1)
            if value.shape != (levels,):
                raise LightError(f"{name}: {value.size} values; allowed: {levels}, one for each level")
            object.__setattr__(self, name, value)
        for name in ("albedo", "surface_albedo"):
            value = getattr(self, name)
            if not np.all((np.asarray(value) >= 0.0) & (np.asarray(value) <= 1.0)):
                raise LightError(f"{name}: {value}; allowed: 0 to 1; closest is {np.clip(value, 0.0, 1.0)}")
        object.__setattr__(self, "albedo", np.array(np.broadcast_to(self.albedo, levels), dtype=np.float64))
        kind = np.zeros(levels, dtype=np.int64) if self.kind is None else np.asarray(self.kind, dtype=np.int64)
        moved = np.zeros((levels, 2)) if self.moved_m is None else _array("moved_m", self.moved_m, 2, -np.inf)
        per = np.ones(levels) if self.per is None else _array("per", self.per, 1)
        if kind.shape != (levels,) or np.any(kind < 0) or moved.shape != (levels, 2) or per.shape != (levels,):
            shapes = f"{kind.shape}, {moved.shape}, {per.shape}"
            raise LightError(f"kind, moved_m, per: shapes {shapes}; allowed: ({levels},), ({levels}, 2), ({levels},)")
        object.__setattr__(self, "per", per)
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "moved_m", moved)
        for name in ("surface_source", "sky_source"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise LightError(f"{name}: {getattr(self, name)}; allowed: 0 or more")
        if not all(0.0 < side < np.inf for side in self.size_m):
            raise LightError(f"size_m: {self.size_m}; allowed: above 0")
        object.__setattr__(self, "extinction", extinction)
        object.__setattr__(self, "edges_m", edges)


@dataclass(frozen=True, eq=False)
class ScatteringTable:
    """Phase function by scattering angle, and its inverse cumulative distribution to draw angles from.

    The phase function is linear in the cosine between the points given, and angles are drawn from exactly that
    function, so that directions and local estimates agree.

    Parameters
    ----------
    cosine : array_like (N,)
        Of the scattering angle, ascending from -1 to 1.
    phase : array_like (N,)
        Proportional to the phase function; its mean over the sphere becomes 1.
    """

    cosine: Array
    phase: Array

    def __post_init__(self) -> None:
        cosine, phase = _array("cosine", self.cosine, 1, -1.0), _array("phase", self.phase, 1)
        if cosine.shape != phase.shape or cosine.size < 2 or np.any(np.diff(cosine) <= 0.0):
            raise LightError(f"cosine: {cosine.size} values for {phase.size} of phase; allowed: as many, ascending")
        if cosine[0] != -1.0 or cosine[-1] != 1.0:
            raise LightError(f"cosine: {cosine[0]} to {cosine[-1]}; allowed: -1 to 1")
        mean = 0.5 * np.trapezoid(phase, cosine)
        if not mean > 0.0:
            raise LightError("phase: 0 everywhere; allowed: a positive mean")
        object.__setattr__(self, "cosine", cosine)
        object.__setattr__(self, "phase", phase / mean)

    @property
    def cumulative(self) -> Array:
        """Share (N,) of the light scattered at cosines up to each."""
        steps = 0.25 * (self.phase[1:] + self.phase[:-1]) * np.diff(self.cosine)
        shares = np.concatenate(([0.0], np.cumsum(steps)))
        total: Array = shares / shares[-1]
        return total


def henyey_greenstein(asymmetry: float, points: int = 4001) -> ScatteringTable:
    """Return the table of Henyey and Greenstein's function, with points as dense as its peak is sharp."""
    if not -1.0 < asymmetry < 1.0:
        raise LightError(f"asymmetry: {asymmetry}; allowed: above -1 and below 1")
    share = np.linspace(0.0, 1.0, points)
    g = asymmetry
    # Where the function's own cumulative distribution has equal steps; evenly spaced without a peak.
    cosine = 2.0 * share - 1.0
    if abs(g) > 1e-3:
        cosine = (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * share)) ** 2) / (2.0 * g)
    cosine[0], cosine[-1] = -1.0, 1.0
    return ScatteringTable(cosine, (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine) ** 1.5)


def _array(name: str, value: ArrayLike, dimensions: int, least: float = 0.0) -> Array:
    array = np.ascontiguousarray(value, dtype=np.float64)
    if array.ndim != dimensions or array.size == 0:
        raise LightError(f"{name}: {array.ndim} dimensions, shape {array.shape}; allowed: {dimensions}")
    # Not a number compares as false.
    if not (array.min() >= least and array.max() < np.inf):
        raise LightError(f"{name}: {array.min()} to {array.max()}; allowed: finite, from {least:g} on")
    return array
