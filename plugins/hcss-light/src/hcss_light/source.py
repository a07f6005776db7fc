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
from typing import Any

import numpy as np

from hcss_light.slices import Field, Slices, direct_sunlight, march, place
from hcss_twin.core.kernels import inner, kernel
from hcss_twin.providers import Array

AZIMUTHS = 4
DIRECTIONS = 16
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
        if self.moments.size == 2:
            return float(_henyey_greenstein(np.array(cosine), self.asymmetry))
        degrees = 2.0 * np.arange(self.moments.size) + 1.0
        # The last moments of a truncated series would leave ripples that are negative behind narrow peaks.
        return max(float(np.polynomial.legendre.legval(cosine, degrees * self.moments)), 0.0)

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
    """

    emitted: Array
    sky: float
    below: float
    sunlight: Array
    gas_m1: Array


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


def directions() -> Array:
    """Return 16 directions (D, 3) of flight of equal weight, first those that go down: 2 cosines, 4 azimuths each."""
    cosine = 0.5 + np.array([0.5, -0.5]) / math.sqrt(3.0)
    vectors = []
    for sign in (-1.0, 1.0):
        for ring, up in enumerate(cosine):
            for step in range(AZIMUTHS):
                azimuth = 2.0 * math.pi * (step + 0.25 + 0.5 * ring) / AZIMUTHS
                across = math.sqrt(1.0 - up * up)
                vectors.append((across * math.cos(azimuth), across * math.sin(azimuth), sign * up))
    return np.array(vectors)


def _henyey_greenstein(cosine: Array, asymmetry: float) -> Array:
    g = asymmetry
    result: Array = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine) ** 1.5
    return result


def exchange(asymmetry: float) -> Array:
    """Return the shares (D, D) of light scattered between directions; rows and columns sum to 1."""
    flight = directions()
    matrix = _henyey_greenstein(np.clip(np.sum(flight[:, None] * flight[None], axis=-1), -1.0, 1.0), asymmetry)
    for _ in range(200):
        scale = 1.0 / np.sqrt(np.sum(matrix, axis=1))
        matrix = scale[:, None] * matrix * scale
    return matrix


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
    """Return the source function (Z, y, x) toward the view: emission, and light scattered once and more."""
    extinction, albedo, asymmetry = particles.scaled
    flight, matrix = directions(), exchange(asymmetry)
    sunlight = np.zeros((0, *density.shape[1:]), dtype=np.float32)
    of_sun, once = np.zeros(DIRECTIONS), 0.0
    if sun is not None and np.any(around.sunlight > 0.0):
        sunlight = np.empty(density.shape, dtype=np.float32)
        shifts = slices.shifts(sun.zenith_deg, sun.azimuth_deg, slices.base_m)
        direct_sunlight(density, extinction, slices.height_m, sun.vector[2], shifts, False, sunlight)
        sunlight *= around.sunlight.astype(np.float32)[:, None, None]
        of_sun = _henyey_greenstein(flight @ -sun.vector, asymmetry)
        of_sun *= albedo / (4.0 * math.pi) * DIRECTIONS / np.sum(of_sun)
        angle = float(np.clip(-sun.vector @ view.vector, -1.0, 1.0))
        once = particles.albedo * particles.phase(angle) / (4.0 * math.pi)
        once *= particles.extinction_m1 / extinction
    toward = _henyey_greenstein(flight @ view.vector, asymmetry)
    toward *= albedo / np.sum(toward)
    step = slices.height_m / (np.abs(flight[:, 2]) * slices.point_m)
    moves = flight[:, :2] * step[:, None]
    slant = 1.0 / np.abs(flight[:, 2]) - np.sign(flight[:, 2]) / view.vector[2]
    in_gas = np.exp(-around.gas_m1 * slices.height_m * slant[:, None]).astype(np.float32)
    source: Field = _successive_orders(
        density,
        extinction * slices.height_m / np.abs(flight[:, 2]),
        (albedo * matrix).T.astype(np.float32),
        toward,
        ((1.0 - albedo) * around.emitted).astype(np.float64),
        around.emitted,
        of_sun,
        once,
        sunlight,
        moves,
        in_gas,
        around.sky,
        around.below,
        orders_of(albedo) if orders is None else orders,
    )
    return source


@kernel()
def _successive_orders(
    density: Any, depths: Any, exchanged: Any, toward: Any, emission: Any, opaque: Any, of_sun: Any, once: float,
    sunlight: Any, moves: Any, in_gas: Any, sky: float, below: float, orders: int,
) -> Any:  # fmt: skip
    """Sweep the slices along all directions, once for each order; see :func:`scattered_source`."""
    count, rows, columns = density.shape
    half, lit = DIRECTIONS // 2, sunlight.shape[0] > 0
    # Sources are kept for cloudy voxels only, one row of a slice after the other.
    first_of_row, cloudy = np.empty((count, rows), dtype=np.int64), 0
    for s in range(count):
        for y in range(rows):
            first_of_row[s, y] = cloudy
            for x in range(columns):
                if density[s, y, x] > 0.0:
                    cloudy += 1
    old = np.empty((cloudy, DIRECTIONS), dtype=np.float32)
    new = np.empty((cloudy, DIRECTIONS), dtype=np.float32)
    fixed = np.zeros(DIRECTIONS, dtype=np.float32)
    result = np.zeros((count, rows, columns), dtype=np.float32)
    _start(density, opaque, of_sun, sunlight, old)
    entering = np.empty((half, rows, columns), dtype=np.float32)
    leaving = np.empty((half, rows, columns), dtype=np.float32)
    mean = np.empty(half, dtype=np.float32)
    for order in range(orders):
        last = order == orders - 1
        if not last:
            _start(density, emission, of_sun, sunlight, new)
        for upward in range(2):
            first = upward * half
            leaving[:] = below if upward else sky
            for number in range(count):
                s = number if upward else count - 1 - number
                if number > 0:
                    for d in range(half):
                        _advance(leaving[d], moves[first + d, 0], moves[first + d, 1], entering[d])
                    entering, leaving = leaving, entering
                for d in range(half):
                    kept_by_gas, black = in_gas[first + d, s], np.float32(opaque[s])
                    for y in range(rows):
                        for x in range(columns):
                            leaving[d, y, x] = black + (leaving[d, y, x] - black) * kept_by_gas
                for y in range(rows):
                    voxel = first_of_row[s, y]
                    for x in range(columns):
                        own = density[s, y, x]
                        if own <= 0.0:
                            continue
                        for ring in range(2):
                            depth = own * depths[first + ring * AZIMUTHS]
                            kept = np.float32(np.exp(-depth))
                            inside = np.float32(1.0 - 0.5 * depth if depth < 1e-3 else (1.0 - kept) / depth)
                            for d in range(ring * AZIMUTHS, (ring + 1) * AZIMUTHS):
                                source = old[voxel, first + d]
                                excess = leaving[d, y, x] - source
                                leaving[d, y, x] = source + excess * kept
                                mean[d] = source + excess * inside
                        if last:
                            seen = 0.0
                            for d in range(half):
                                seen += toward[first + d] * mean[d]
                            result[s, y, x] += seen
                        else:
                            fixed[:] = 0.0
                            for d in range(half):
                                light = mean[d]
                                for into in range(DIRECTIONS):
                                    fixed[into] += exchanged[first + d, into] * light
                            for into in range(DIRECTIONS):
                                new[voxel, into] += fixed[into]
                        voxel += 1
        old, new = new, old
    for s in range(count):
        for y in range(rows):
            for x in range(columns):
                if density[s, y, x] > 0.0:
                    result[s, y, x] += emission[s] + (once * sunlight[s, y, x] if lit else 0.0)
    return result


@inner()
def _start(density: Any, emission: Any, of_sun: Any, sunlight: Any, sources: Any) -> None:
    """Write emission and sunlight scattered for the first time, of each cloudy voxel and direction."""
    count, rows, columns = density.shape
    voxel, lit = 0, sunlight.shape[0] > 0
    for s in range(count):
        for y in range(rows):
            for x in range(columns):
                if density[s, y, x] > 0.0:
                    for d in range(DIRECTIONS):
                        sources[voxel, d] = emission[s] + (of_sun[d] * sunlight[s, y, x] if lit else 0.0)
                    voxel += 1


@inner()
def _advance(before: Any, row_move: float, column_move: float, after: Any) -> None:
    """Move light by a slice: what is here was upstream before."""
    rows, columns = before.shape
    row, down = place(-row_move, rows)
    column, right = place(-column_move, columns)
    w00, w01 = np.float32((1.0 - down) * (1.0 - right)), np.float32((1.0 - down) * right)
    w10, w11 = np.float32(down * (1.0 - right)), np.float32(down * right)
    for y in range(rows):
        y0 = (y + row) % rows
        y1 = (y0 + 1) % rows
        for x in range(columns):
            x0 = x + column
            if x0 >= columns:
                x0 -= columns
            x1 = x0 + 1 if x0 + 1 < columns else 0
            after[y, x] = (
                w00 * before[y0, x0] + w01 * before[y0, x1] + w10 * before[y1, x0] + w11 * before[y1, x1]
            )  # fmt: skip


def sourced_radiance(
    slices: Slices,
    density: Field,
    particles: Particles,
    around: Surroundings,
    view: Direction,
    sun: Direction | None,
    reference_m: float,
    orders: int | None = None,
) -> tuple[Array, Array]:
    """Return path in cloud times cosine (m), and radiance, each (y, x), of the rays through points at an altitude."""
    source = scattered_source(slices, density, particles, around, view, sun, orders)
    return _marched(slices, density, particles.scaled[0], source, np.zeros(slices.count), around, view, reference_m)


def absorbed_radiance(
    slices: Slices, density: Field, particles: Particles, around: Surroundings, view: Direction, reference_m: float
) -> tuple[Array, Array]:
    """Return the same with emission alone: cloud that absorbs as strongly as it would with its scattering.

    Light that is scattered travels farther in cloud; the effective absorption is that of a thick scattering medium,
    sqrt((1 - albedo) (1 - albedo g)) of the extinction.
    """
    share = math.sqrt((1.0 - particles.albedo) * (1.0 - particles.albedo * particles.asymmetry))
    nothing = np.zeros((0, *density.shape[1:]), dtype=np.float32)
    extinction = particles.extinction_m1 * share
    return _marched(slices, density, extinction, nothing, around.emitted, around, view, reference_m)


def _marched(
    slices: Slices, density: Field, extinction: float, source: Field, of_height: Array, around: Surroundings,
    view: Direction, reference_m: float,
) -> tuple[Array, Array]:  # fmt: skip
    amount, radiance = np.empty(density.shape[1:]), np.empty(density.shape[1:])
    shifts = slices.shifts(view.zenith_deg, view.azimuth_deg, reference_m)
    across = float(view.vector[2])
    march(
        density, source, of_height, extinction, slices.height_m, across, shifts, around.below, amount, radiance
    )  # fmt: skip
    return amount, radiance
