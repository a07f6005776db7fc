"""The sunlight of a column of :mod:`glint_scenes` by discrete ordinates.

They share with the product the Legendre moments of the droplets' phase function and the refractive index of water, and
keep all 128 moments, without delta-M scaling. Gas whose transmittances do not multiply is a mean over absorption
coefficients, each with discrete ordinates of its own. The sea is written here again: facets with the slopes of Cox and
Munk (J. Opt. Soc. Am. 44, 838, 1954) and Fresnel's reflectance, reflecting once, which waves hide from both sides
independently. Without shadows, facets reflect more than they receive at grazing angles.
"""

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
def unhidden(mean_square_slope: float, cosine: float) -> float:
    """Fraction of the facets that waves do not hide (B. G. Smith, IEEE Trans. Antennas Propag. 15, 668, 1967)."""
    v = cosine / math.sqrt(max((1.0 - cosine * cosine) * mean_square_slope, 1e-30))
    return 1.0 / (1.0 + 0.5 * (math.exp(-min(v * v, 700.0)) / (v * math.sqrt(math.pi)) - math.erfc(v)))


def mean_square_slope(wind_m_s: float) -> float:
    """Cox and Munk, clean surface."""
    return 0.003 + 0.00512 * wind_m_s


COEFFICIENTS = (0.1, 0.5, 2.0, 6.0)
"""Optical thicknesses of a gas below the cloud, with equal weights."""

ABOVE = 0.5
"""Optical thickness of the same gas above the cloud over that below."""


def under_gas(scene: GlintScene, matter: Matter) -> float:
    """Return the sunlight of the column in the gas of :data:`COEFFICIENTS`."""
    slant = ABOVE * (1.0 / scene.mu_view + 1.0 / scene.mu_sun)
    seen = [math.exp(-each * slant) * discrete_ordinates(scene, matter, gas=each) for each in COEFFICIENTS]
    return sum(seen) / len(seen)


def discrete_ordinates(scene: GlintScene, matter: Matter, nodes: int = NODES, gas: float = 0.0) -> float:
    """The same by PythonicDISORT with as many moments and azimuth modes as streams; the sea in its modes.

    ``gas``: optical thickness of an absorber below the cloud.
    """
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

    layers = slice(0, 2 if gas else 1)
    isotropic = np.zeros(2 * nodes)
    isotropic[0] = 1.0
    result = pydisort(
        np.array([scene.optical_thickness, scene.optical_thickness + gas])[layers],
        np.array([matter.albedo, 0.0])[layers],
        2 * nodes,
        np.stack((matter.moments[: 2 * nodes], isotropic))[layers],
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
