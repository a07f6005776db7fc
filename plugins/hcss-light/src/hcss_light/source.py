"""Light scattered many times in sliced clouds: successive orders along 16 directions.

The phase function is scaled: the share f = g^2 of its forward peak counts as not scattered, the rest follows Henyey and
Greenstein with g / (1 + g). Radiance is counted at the sensor, N = T I + E with transmittance T and emission E of the
gas above; along a direction with cosine mu gas of absorption k then gives

    dN/dz = k (N_black - N) (1/mu - 1/mu_view) upward,    -dN/dz = k (N_black - N) (1/mu + 1/mu_view) downward.

Thermal emission starts from the source function of opaque cloud, from which few orders are
left. Sunlight scattered once toward the view has the whole phase function (method TMS of Nakajima and Tanaka).

References
----------
W. J. Wiscombe, J. Atmos. Sci. 34, 1408 (1977); T. Nakajima and M. Tanaka, J. Quant. Spectrosc. Radiat. Transfer 40,
51 (1988).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_light.orders import (
    DIRECTIONS,
    block_means,
    coupling,
    directions,
    displacements,
    exchange,
    henyey_greenstein_at,
    successive_orders,
)
from hcss_light.slices import Field, Slices, direct_sunlight, march, paths
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

BLOCK_OPTICAL_THICKNESS = 4.0
"""Vertical optical thickness of the thickest block of two slices."""

LOW_ALBEDO, FINE_ORDERS = 0.3, 3
"""Scaled albedo below which blocks are enough, and orders on voxels where they are not."""

LEFT, LEAST_ORDERS, MOST_ORDERS = 0.01, 4, 24
"""Orders are added until less than this share of the light would be left, were none to escape."""


@dataclass(frozen=True)
class Particles:
    """Optical properties of cloud at one wavenumber, or means over some.

    Attributes
    ----------
    extinction_m1, albedo : float
    moments : ndarray (K,)
        Legendre moments of the phase function, K >= 2; ``moments[1]`` is the asymmetry. K = 2: Henyey-Greenstein.
    """

    extinction_m1: float
    albedo: float
    moments: Array

    @property
    def asymmetry(self) -> float:
        """Mean cosine of the scattering angle."""
        return float(self.moments[1])

    def phase(self, cosine: float) -> float:
        """Return the phase function, whose mean over the sphere is 1, at the cosine of a scattering angle."""
        return float(self.phases(np.array(cosine)))

    def phases(self, cosine: Array) -> Array:
        """Return the phase function at cosines of any shape."""
        if self.moments.size == 2:
            return henyey_greenstein_at(cosine, self.asymmetry)
        degrees = 2.0 * np.arange(self.moments.size) + 1.0
        # The last moments of a truncated series would leave ripples that are negative behind narrow peaks.
        return np.maximum(np.polynomial.legendre.legval(cosine, degrees * self.moments), 0.0)

    @property
    def absorbing_m1(self) -> float:
        """Extinction of cloud that absorbs as strongly as it would with its scattering.

        Light that is scattered travels farther in cloud; the effective absorption is that of a thick scattering
        medium, sqrt((1 - albedo) (1 - albedo g)) of the extinction.
        """
        return self.extinction_m1 * math.sqrt((1.0 - self.albedo) * (1.0 - self.albedo * self.asymmetry))

    @cached_property
    def exchanged(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Light that is scattered between directions without the forward peak; see :func:`coupling`."""
        _, albedo, asymmetry = self.scaled
        return coupling(albedo * exchange(asymmetry))

    @property
    def scaled(self) -> tuple[float, float, float]:
        """Extinction, albedo and asymmetry without the forward peak."""
        peak = self.asymmetry**2
        share = 1.0 - self.albedo * peak
        return (
            self.extinction_m1 * share,
            self.albedo * (1.0 - peak) / share,
            self.asymmetry / (1.0 + abs(self.asymmetry)),
        )


@dataclass(frozen=True)
class Surroundings:
    """Light that clouds emit and receive, as it reaches the sensor.

    Attributes
    ----------
    emitted : ndarray (Z,)
        Planck radiance at each slice.
    sky, below : float
        Radiance from above and from below.
    sunlight : ndarray (Z,)
        Irradiance of the sun at each slice without cloud, on a surface that faces it; 0 at night.
    gas_m1 : ndarray (Z,)
        Absorption of the gas.
    glint : float
        What of ``below`` is direct sunlight that the sea reflects.
    mirrored : ndarray (Z,), optional
        What is added if the sea mirrors an opaque cloud at each slice instead of the sky.
    """

    emitted: Array
    sky: float
    below: float
    sunlight: Array
    gas_m1: Array
    glint: float = 0.0
    mirrored: Array | None = None


@dataclass(frozen=True)
class Direction:
    """A direction above the horizon: zenith and azimuth, clockwise from north (rows) to east (columns)."""

    zenith_deg: float
    azimuth_deg: float

    @property
    def vector(self) -> Array:
        """North, east and up (3,)."""
        zenith, azimuth = math.radians(self.zenith_deg), math.radians(self.azimuth_deg)
        across = math.sin(zenith)
        return np.array([across * math.cos(azimuth), across * math.sin(azimuth), math.cos(zenith)])


def orders_of(albedo: float) -> int:
    """Return how many orders of scattering a scaled single-scattering albedo needs."""
    needed = LEAST_ORDERS if albedo <= 0.0 else math.ceil(math.log(LEFT) / math.log(min(albedo, 1.0 - 1e-9)))
    return min(max(needed, LEAST_ORDERS), MOST_ORDERS)


def scattered_source(
    slices: Slices,
    density: Field,
    particles: Particles,
    around: Surroundings,
    view: Direction,
    sun: Direction | None,
    orders: int | None = None,
) -> Field:
    """Return the source function (Z, y, x) toward the view: emission, and light scattered once and more.

    Light that is scattered more than once is computed on blocks first; few orders on the voxels themselves then restore
    its detail. Where little is scattered blocks are enough.

    Parameters
    ----------
    orders : int, optional
        Of scattering, all on voxels; by default as many as needed.
    """
    extinction, albedo, asymmetry = particles.scaled
    flight = directions()
    sunlight = np.zeros((0, *density.shape[1:]), dtype=np.float32)
    of_sun, once, up = np.zeros(DIRECTIONS), 0.0, 1.0
    if sun is not None and np.any(around.sunlight > 0.0):
        sunlight, up = np.empty(density.shape, dtype=np.float32), float(sun.vector[2])
        shifts = slices.shifts(sun.zenith_deg, sun.azimuth_deg, slices.base_m)
        direct_sunlight(density, extinction, slices.height_m, up, shifts, False, sunlight)
        sunlight *= around.sunlight.astype(np.float32)[:, None, None]
        of_sun = henyey_greenstein_at(flight @ -sun.vector, asymmetry)
        of_sun *= albedo / (4.0 * math.pi) * DIRECTIONS / np.sum(of_sun)
        angle = float(np.clip(-sun.vector @ view.vector, -1.0, 1.0))
        once = particles.albedo * particles.phase(angle) / (4.0 * math.pi)
        once *= particles.extinction_m1 / extinction
    toward = henyey_greenstein_at(flight @ view.vector, asymmetry)
    toward *= albedo / np.sum(toward)
    slant = 1.0 / np.abs(flight[:, 2]) - np.sign(flight[:, 2]) / view.vector[2]
    result, start = np.zeros((0, 1, 1), dtype=np.float32), np.zeros((DIRECTIONS, 0), dtype=np.float32)
    number, before = np.zeros((1, 1, 1), dtype=np.int32), (1, 1)
    sizes = [(1, 1, orders)] if orders is not None else _sizes(slices, extinction, albedo)
    for high, wide, count in sizes:
        coarse, lit = (density, sunlight) if (high, wide) == (1, 1) else block_means(density, sunlight, high, wide)
        height_m = high * slices.height_m
        opaque, gas_m1 = (means(profile, high) for profile in (around.emitted, around.gas_m1))
        step = height_m / (np.abs(flight[:, 2]) * slices.point_m * wide)
        coupled, turn = particles.exchanged
        result, start, number = successive_orders(
            coarse,
            np.zeros(coarse.shape[0], dtype=np.int64),
            extinction * height_m / np.abs(flight[:, 2]),
            coupled[None],
            turn,
            toward[None],
            (1.0 - albedo) * opaque,
            opaque,
            of_sun[None],
            lit,
            displacements(flight[:, :2] * step[:, None], coarse.shape, count),
            np.exp(-gas_m1 * height_m * slant[:, None]).astype(np.float32),
            around.sky,
            around.below - around.glint,
            start,
            number,
            *before,
        )
        before = high, wide
    source, depth = np.empty_like(density), extinction * slices.height_m
    fine_source(
        density, sunlight, result, *before, (1.0 - albedo) * around.emitted, once, depth / view.vector[2],
        depth / up, source,
    )  # fmt: skip
    return source


def _sizes(slices: Slices, extinction: float, albedo: float) -> list[tuple[int, int, int]]:
    """Return slices and points along the sides of the blocks on which light is computed in turn, and the orders."""
    high = 2 if 2.0 * extinction * slices.height_m <= BLOCK_OPTICAL_THICKNESS else 1
    blocks = high, 1 if slices.are_apart else 2, orders_of(albedo)
    return [blocks] if albedo < LOW_ALBEDO else [blocks, (1, 1, FINE_ORDERS)]


def means(values: Array, high: int) -> Array:
    """Return means over so many slices each."""
    starts = np.arange(0, values.size, high)
    result: Array = np.add.reduceat(values, starts) / np.minimum(high, values.size - starts)
    return result


@kernel()
def fine_source(
    density: Any, sunlight: Any, scattered: Any, high: int, wide: int, emission: Any, once: float, to_view: float,
    to_sun: float, source: Any,
) -> None:  # fmt: skip
    """Write the source function (Z, y, x): emission, light scattered in blocks, sunlight scattered for the first time.

    Both paths to a point in a voxel go through its top: sunlight and view are weakened together. The mean of sunlight
    alone would be too low where slices are thick.
    """
    count, rows, columns = density.shape
    for s in range(count):
        for y in range(rows):
            for x in range(columns):
                voxel_density = density[s, y, x]
                if voxel_density <= 0.0:
                    source[s, y, x] = 0.0
                    continue
                total = emission[s] + scattered[s // high, y // wide, x // wide]
                if once > 0.0:
                    seen, lit, together = to_view * voxel_density, to_sun * voxel_density, 1.0
                    if seen + lit > 1e-3:
                        together = seen * lit / (seen + lit) * np.expm1(-seen - lit)
                        together /= -np.expm1(-seen) * np.expm1(-lit)
                    total += once * together * sunlight[s, y, x]
                source[s, y, x] = total


def sourced_radiance(
    slices: Slices,
    density: Field,
    particles: Particles,
    around: Surroundings,
    view: Direction,
    sun: Direction | None,
    reference_m: float,
    source: Field | None = None,
) -> tuple[Array, Array]:
    """Return path in cloud times cosine (m), and radiance, each (y, x), of the rays through points at an altitude."""
    if source is None:
        source = scattered_source(slices, density, particles, around, view, sun)
    return _marched(slices, density, particles.scaled[0], source, np.zeros(slices.count), around, view, reference_m)


def absorbed_radiance(
    slices: Slices, density: Field, particles: Particles, around: Surroundings, view: Direction, reference_m: float
) -> tuple[Array, Array]:
    """Return the same with emission alone, by the effective absorption."""
    nothing = np.zeros((0, *density.shape[1:]), dtype=np.float32)
    return _marched(slices, density, particles.absorbing_m1, nothing, around.emitted, around, view, reference_m)


def _marched(
    slices: Slices, density: Field, extinction: float, source: Field, of_height: Array, around: Surroundings,
    view: Direction, reference_m: float,
) -> tuple[Array, Array]:  # fmt: skip
    amount, radiance = np.empty((2, *density.shape[1:]), dtype=np.float32)
    shifts = slices.shifts(view.zenith_deg, view.azimuth_deg, reference_m)
    paths(density, slices.height_m, shifts, amount)
    across = float(view.vector[2])
    march(density, source, of_height, extinction, slices.height_m, across, shifts, around.below, radiance)
    return amount.astype(np.float64), radiance.astype(np.float64)
