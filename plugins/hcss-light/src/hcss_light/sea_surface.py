"""A rough sea for Monte Carlo: facets that mirror by Fresnel's laws, with slopes that are normal in both directions.

Facets are drawn from the slopes, and weighted by their area toward the photon; Smith's function corrects for those that
others hide. Light that a facet sends down again counts as absorbed, and emission as its complement, so that a closed
isothermal enclosure stays black.

References
----------
C. Cox and W. Munk, J. Opt. Soc. Am. 44, 838 (1954); B. G. Smith, IEEE Trans. Antennas Propag. 15, 668 (1967).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_light.voxels import LightError
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

RULE = 24
"""Slopes along each axis of the rule for means over facets."""


@dataclass(frozen=True)
class RoughSea:
    """A rough sea.

    Parameters
    ----------
    mean_square_slope : float
        Of both directions together, above 0.
    index : float
        Refractive index, above 1.
    strength : float
        Factor of direct sunlight that is reflected.
    """

    mean_square_slope: float
    index: float
    strength: float = 1.0

    def __post_init__(self) -> None:
        if not (self.mean_square_slope > 0.0 and self.index > 1.0 and self.strength >= 0.0):
            raise LightError(f"{self}: allowed: mean_square_slope above 0, index above 1, strength 0 or more")


def index_of(reflectance: Array) -> Array:
    """Return the refractive index of water that reflects a share of light upright to it."""
    root = np.sqrt(np.clip(reflectance, 1e-6, 0.9))
    return np.asarray((1.0 + root) / (1.0 - root))


def facets(sea: RoughSea, cosine: float) -> tuple[Array, Array]:
    """Return cosines (N,) of the zenith angles of mirrored rays, and the shares (N,) of light seen along them.

    What misses to 1 is emitted, or comes from other facets.
    """
    nodes, weights = np.polynomial.hermite_e.hermegauss(RULE)
    sigma = math.sqrt(0.5 * sea.mean_square_slope)
    along, across = (slope.ravel() for slope in np.meshgrid(sigma * nodes, sigma * nodes))
    share = np.outer(weights, weights).ravel()
    upright = 1.0 / np.sqrt(1.0 + along**2 + across**2)
    incidence = np.maximum((cosine - along * math.sqrt(1.0 - cosine**2)) * upright, 0.0)
    share = share * incidence / upright
    share *= np.array([fresnel(float(angle), sea.index) for angle in incidence]) / np.sum(share)
    up = 2.0 * incidence * upright - cosine
    return up[up > 0.0], share[up > 0.0]


@kernel()
def fresnel(cosine: float, index: float) -> float:
    """Return the reflectance for unpolarised light at the cosine of incidence."""
    inside = math.sqrt(1.0 - (1.0 - cosine * cosine) / (index * index))
    across, along = (cosine - index * inside) / (cosine + index * inside), 0.0
    along = (index * cosine - inside) / (index * cosine + inside)
    return 0.5 * (across * across + along * along)


@kernel(inner=True)
def hidden(cosine: float, variance: float) -> float:
    """Return Smith's function of the facets that others hide, for slopes of a variance in each direction."""
    sine = math.sqrt(max(1.0 - cosine * cosine, 1e-12))
    steep = cosine / (sine * math.sqrt(2.0 * variance))
    return 0.5 * (math.exp(-steep * steep) / (steep * math.sqrt(math.pi)) - math.erfc(steep))


@kernel()
def glint(toward: Any, to_sun: Any, variance: float, index: float) -> float:
    """Return the radiance that leaves along a direction for sunlight of irradiance 1 on a surface that faces it."""
    x, y, z = toward[0] + to_sun[0], toward[1] + to_sun[1], toward[2] + to_sun[2]
    norm = math.sqrt(x * x + y * y + z * z)
    upright, incidence = z / norm, (x * toward[0] + y * toward[1] + z * toward[2]) / norm
    slope2 = (x * x + y * y) / (z * z)
    density = math.exp(-0.5 * slope2 / variance) / (2.0 * math.pi * variance)
    seen = 1.0 / (1.0 + hidden(toward[2], variance) + hidden(to_sun[2], variance))
    leaves: float = fresnel(min(incidence, 1.0), index) * density * seen / (4.0 * toward[2] * upright**4)
    return leaves


@kernel(inner=True)
def mirror(along: Any, variance: float, index: float, draw: Any) -> tuple[float, float]:
    """Turn a direction that goes down into that of the ray which a random facet mirrors.

    Returns the weight of the facet, and its reflectance.
    """
    size, turned = math.sqrt(-2.0 * variance * math.log(1.0 - draw.random())), 2.0 * math.pi * draw.random()
    x, y = size * math.cos(turned), size * math.sin(turned)
    upright = 1.0 / math.sqrt(1.0 + x * x + y * y)
    incidence = -(along[0] * x + along[1] * y + along[2]) * upright
    if incidence <= 0.0:
        return 0.0, 0.0
    up = -along[2]
    weight = incidence / (upright * up) / (1.0 + hidden(up, variance))
    along[0] += 2.0 * incidence * x * upright
    along[1] += 2.0 * incidence * y * upright
    along[2] += 2.0 * incidence * upright
    return weight, fresnel(min(incidence, 1.0), index)
