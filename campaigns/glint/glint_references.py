"""The sunlight of a column of :mod:`glint_scenes`, by Monte Carlo and by discrete ordinates.

Both share with the product the Legendre moments of the droplets' phase function and the refractive index of water; both
keep all 128 moments, without delta-M scaling. The sea is written here again: facets with the slopes of Cox and Munk (J.
Opt. Soc. Am. 44, 838, 1954) and Fresnel's reflectance, reflecting once, which waves hide from both sides independently.
Without shadows, facets reflect more than they receive at grazing angles.
"""

# ruff: noqa: NPY002 -- compiled loops have only this generator

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from glint_scenes import NODES, GlintScene
from PythonicDISORT.pydisort import pydisort


@dataclass(frozen=True)
class Matter:
    """Single-scattering albedo and moments (K,) of the droplets, and the refractive index of the sea."""

    albedo: float
    moments: np.ndarray
    index: complex


@numba.njit(cache=True)
def fresnel(index: complex, cosine: float) -> float:
    """Reflectance of a facet for unpolarised light."""
    inside = np.sqrt(index * index - (1.0 - cosine * cosine))
    across = (cosine - inside) / (cosine + inside)
    along = (index * index * cosine - inside) / (index * index * cosine + inside)
    return 0.5 * (abs(across) ** 2 + abs(along) ** 2)


@numba.njit(cache=True)
def unhidden(mean_square_slope: float, cosine: float) -> float:
    """Fraction of the facets that waves do not hide (B. G. Smith, IEEE Trans. Antennas Propag. 15, 668, 1967)."""
    v = cosine / math.sqrt(max((1.0 - cosine * cosine) * mean_square_slope, 1e-30))
    return 1.0 / (1.0 + 0.5 * (math.exp(-min(v * v, 700.0)) / (v * math.sqrt(math.pi)) - math.erfc(v)))


@numba.njit(cache=True)
def sea_brdf(index: complex, mean_square_slope: float, up: np.ndarray, down: np.ndarray) -> float:
    """BRDF in sr-1 for light that travels along ``down`` and leaves along ``up``, unit vectors."""
    x, y, z = up[0] - down[0], up[1] - down[1], up[2] - down[2]
    cosine = 0.5 * math.sqrt(x * x + y * y + z * z)
    slope = (x * x + y * y) / (z * z)
    density = math.exp(-slope / mean_square_slope) / (math.pi * mean_square_slope)
    seen = unhidden(mean_square_slope, up[2]) * unhidden(mean_square_slope, -down[2])
    return seen * fresnel(index, cosine) * density * (1.0 + slope) ** 2 / (4.0 * up[2] * -down[2])


@numba.njit(cache=True)
def turned(along: np.ndarray, cosine: float, azimuth: float) -> np.ndarray:
    """Direction at an angle from another one."""
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    a, b = sine * math.cos(azimuth), sine * math.sin(azimuth)
    x, y, z = along
    level = math.sqrt(x * x + y * y)
    if level < 1e-9:
        return np.array((a, b, math.copysign(cosine, z)))
    new = np.array((a * x * z / level - b * y / level, a * y * z / level + b * x / level, -a * level))
    new += cosine * along
    return new / math.sqrt(np.sum(new * new))


@numba.njit(cache=True)
def photons(
    seed: int,
    count: int,
    tau: float,
    albedo: float,
    angle: np.ndarray,
    phase: np.ndarray,
    drawn: np.ndarray,
    index: complex,
    mean_square_slope: float,
    sun: np.ndarray,
    view: np.ndarray,
) -> tuple[float, float]:
    """Sum and sum of squares, over photons, of radiance over the irradiance on a horizontal plane, sr-1.

    ``phase`` (A,) at scattering angles ``angle`` (A,), evenly spaced from 0 to pi, has the mean 1; ``drawn`` are
    cosines at equal steps of probability. At each scattering and reflection the light toward the view is added.
    """
    np.random.seed(seed)
    first, second = 0.0, 0.0
    last = angle.size - 1
    for _ in range(count):
        along, depth, weight, seen = sun.copy(), 0.0, 1.0, 0.0
        while weight > 1e-7:
            depth += math.log(1.0 - np.random.random()) * along[2]
            if depth < 0.0:
                break
            if depth <= tau:
                weight *= albedo
                cosine = min(max(along[0] * view[0] + along[1] * view[1] + along[2] * view[2], -1.0), 1.0)
                place = math.acos(cosine) / math.pi * last
                low = min(int(place), last - 1)
                value = phase[low] + (place - low) * (phase[low + 1] - phase[low])
                seen += weight * value / (4.0 * math.pi) / view[2] * math.exp(-depth / view[2])
                place = np.random.random() * (drawn.size - 1)
                low = int(place)
                cosine = drawn[low] + (place - low) * (drawn[low + 1] - drawn[low])
                along = turned(along, cosine, 2.0 * math.pi * np.random.random())
                continue
            depth = tau
            seen += weight * sea_brdf(index, mean_square_slope, view, along) * math.exp(-tau / view[2])
            size = math.sqrt(-mean_square_slope * math.log(1.0 - np.random.random()))
            turn = 2.0 * math.pi * np.random.random()
            up = 1.0 / math.sqrt(1.0 + size * size)
            normal = np.array((-size * math.cos(turn) * up, -size * math.sin(turn) * up, up))
            cosine = -(along[0] * normal[0] + along[1] * normal[1] + along[2] * normal[2])
            if cosine <= 0.0:
                break
            weight *= fresnel(index, cosine) * cosine / (-along[2] * up)
            weight *= unhidden(mean_square_slope, -along[2])
            along = along + 2.0 * cosine * normal
            if along[2] <= 0.0:
                break
            weight *= unhidden(mean_square_slope, along[2])
            if weight < 0.01:  # Russian roulette
                if np.random.random() > 0.1:
                    break
                weight *= 10.0
        first += seen
        second += seen * seen
    return first, second


ANGLES, DRAWN = 20_001, 200_001


def monte_carlo(scene: GlintScene, matter: Matter, photon_count: int, seed: int) -> tuple[float, float]:
    """Radiance over the irradiance on a horizontal plane at the top, sr-1, and its standard error."""
    angle = np.linspace(0.0, np.pi, ANGLES)
    series = (2 * np.arange(matter.moments.size) + 1) * matter.moments
    phase = np.maximum(np.polynomial.legendre.legval(np.cos(angle), series), 0.0)
    # Between two angles the phase function is a straight line over the cosine.
    step = -np.diff(np.cos(angle)) * 0.5 * (phase[1:] + phase[:-1])
    share = np.concatenate(([0.0], np.cumsum(step)))
    drawn = np.interp(np.linspace(0.0, share[-1], DRAWN), share, np.cos(angle))
    sine, sine_view = math.sqrt(1.0 - scene.mu_sun**2), math.sqrt(1.0 - scene.mu_view**2)
    turn = math.radians(scene.azimuth_deg)
    sun = np.array((-sine, 0.0, -scene.mu_sun))
    view = np.array((sine_view * math.cos(turn), sine_view * math.sin(turn), scene.mu_view))
    first, second = photons(
        seed,
        photon_count,
        scene.optical_thickness,
        matter.albedo,
        angle,
        phase,
        drawn,
        complex(matter.index),
        mean_square_slope(scene.wind_m_s),
        sun,
        view,
    )
    mean = first / photon_count
    return mean, math.sqrt(max(second / photon_count - mean**2, 0.0) / photon_count)


def mean_square_slope(wind_m_s: float) -> float:
    """Cox and Munk, clean surface."""
    return 0.003 + 0.00512 * wind_m_s


def discrete_ordinates(scene: GlintScene, matter: Matter, nodes: int = NODES) -> float:
    """The same by PythonicDISORT with as many moments and azimuth modes as streams; the sea in its modes."""
    modes, slope = 2 * nodes, mean_square_slope(scene.wind_m_s)
    azimuth = (np.arange(4 * nodes) + 0.5) * np.pi / (4 * nodes)
    cosine = np.cos(np.arange(modes)[:, None] * azimuth) * (2.0 / azimuth.size)
    cosine[0] *= 0.5

    def expanded(mu: np.ndarray, mu_in: np.ndarray) -> np.ndarray:
        """Modes (M, P, Q) of pi times the BRDF, over the azimuth between the directions in which light travels."""
        brdf = sea_brdf_at(matter.index, slope, mu[:, None, None], mu_in[None, :, None], np.pi - azimuth)
        return np.einsum("ma,pqa->mpq", cosine, np.pi * brdf)

    known: dict[tuple[int, int], np.ndarray] = {}

    def mode(m: int):
        def of(mu, mu_in):
            mu, mu_in = np.atleast_1d(mu), np.atleast_1d(np.abs(mu_in))
            key = (mu.size, mu_in.size)
            if key not in known:
                known[key] = expanded(mu, mu_in)
            return known[key][m]

        return of

    result = pydisort(
        np.array([scene.optical_thickness]),
        np.array([matter.albedo]),
        2 * nodes,
        matter.moments[None, : 2 * nodes],
        scene.mu_sun,
        1.0,
        0.0,
        NLeg=2 * nodes,
        NFourier=modes,
        BDRF_Fourier_modes=[mode(m) for m in range(modes)],
    )
    mu, field = result[0][:nodes], result[-1]
    row = int(np.argmin(np.abs(mu - scene.mu_view)))
    if abs(mu[row] - scene.mu_view) > 1e-9:
        raise ValueError(f"mu_view {scene.mu_view}: not a node")
    travelled = math.pi - math.radians(scene.azimuth_deg)
    return float(np.ravel(field(0.0, travelled))[row]) / scene.mu_sun


def sea_brdf_at(index: complex, slope: float, up: np.ndarray, into: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """BRDF, sr-1, between cosines at an angle between the bearings of sensor and source; they broadcast."""
    across = np.sqrt((1.0 - up**2) * (1.0 - into**2)) * np.cos(azimuth)
    cosine = np.sqrt(0.5 * (1.0 + up * into + across))
    squared = np.maximum(4.0 * cosine**2 / (up + into) ** 2 - 1.0, 0.0)
    density = np.exp(-squared / slope) / (np.pi * slope)
    inside = np.sqrt(index * index - (1.0 - cosine**2))
    perpendicular = (cosine - inside) / (cosine + inside)
    parallel = (index * index * cosine - inside) / (index * index * cosine + inside)
    reflectance = 0.5 * (np.abs(perpendicular) ** 2 + np.abs(parallel) ** 2)
    seen = np.vectorize(unhidden)(slope, up) * np.vectorize(unhidden)(slope, into)
    return seen * reflectance * density * (1.0 + squared) ** 2 / (4.0 * up * into)
