"""Wave facets visible to a viewer, and shadowing by other waves.

The line of sight meets a facet of slope (zx, zy), tilted by theta_n, at the angle of incidence chi. From the zenith
angle theta, the facet fills the fraction P(zx, zy) cos(chi) / (cos(theta) cos(theta_n)) of the view (K. Masuda, T.
Takashima and Y. Takayama, Remote Sens. Environ. 24, 313-329, 1988). With the x axis pointing toward the viewer and zx =
dz/dx, cos(chi) / cos(theta_n) = cos(theta) - zx sin(theta). The same applies to a ray that a first facet reflects
toward a second one (X. Wu and W. L. Smith, Appl. Opt. 36, 2609-2619, 1997); the second slope is assumed independent of
the first.

Shadowing: the fraction 1 / (1 + Lambda) of the facets that face a direction is visible from it, independent of slope
(B. G. Smith, Geometrical shadowing of a random rough surface, IEEE Trans. Antennas Propag. 15, 668-671, 1967). The
factor normalises the view: the projected areas of the facets that face the direction sum to 1 + Lambda times that of
the sea. With correlated heights, 1 / (1 + Lambda_out + Lambda_in) are visible from two directions (V. Ross and D. Dion,
J. Geophys. Res. 112, C09015, 2007, use this form for the sea).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.models.sea.slope_statistics import SlopeStatistics, slope_density
from hcss_twin.physics.quadrature import gauss_legendre

_MAX_SIGMA = 6.0
"""Number of standard deviations of a slope component beyond which 2e-9 of the facets lie."""

NEGLIGIBLE = 1e-13
"""Share of all light below which a ray is left out; together less than what lies beyond that slope."""


def incidence_nodes(count: int) -> Array:
    """Return ``count`` Chebyshev points of the cosine of incidence within (0, 1), shape (K,)."""
    return np.asarray(0.5 * (1.0 + np.polynomial.chebyshev.chebpts1(count)), dtype=np.float64)


def facet_weights(mu: Array, mean_square_slope: float, incidence_count: int = 32, slope_count: int = 64) -> Array:
    """Return weights (M, K) that average a function of the angle of incidence over the visible facets.

    The integral over slopes is linear in the function, so it is computed once for the interpolation nodes of the
    function: ``facet_weights(...) @ g(incidence_nodes(K))`` is the average of g. Reflectance is analytic in the cosine,
    which makes this spectrally accurate, and each wavelength costs only one product.

    Parameters
    ----------
    mu : ndarray (M,)
        Cosines of the view zenith angle, in (0, 1].
    mean_square_slope : float
        Total mean-square slope, above 0.
    incidence_count : int
        Number K of Chebyshev nodes in the cosine of incidence.
    slope_count : int
        Gauss-Legendre nodes along and (by symmetry, half of them) across the view.

    Notes
    -----
    Rows sum to 1; single weights may be negative. With the optical constants of water at 0.25 to 190 um, mu 0.001 to 1
    and winds of 0 to 60 m/s, doubling the nodes changes the emissivity by less than 1e-12, and doubling half the slope
    nodes by 1e-11. The truncation of the slopes leaves 2e-9.
    """
    mu = np.asarray(mu, dtype=np.float64)
    limit = _MAX_SIGMA * np.sqrt(0.5 * mean_square_slope)
    along_nodes, along_weights = gauss_legendre(slope_count)
    across_nodes, across_weights = gauss_legendre(slope_count // 2)
    across = (0.5 * limit * (across_nodes + 1.0))[:, None]
    degree = incidence_count - 1
    at_nodes = np.polynomial.chebyshev.chebvander(2.0 * incidence_nodes(incidence_count) - 1.0, degree)
    fit = np.linalg.inv(at_nodes)
    rows = np.empty((mu.size, incidence_count))
    for row, cos_view in zip(rows, mu, strict=True):
        sin_view = np.sqrt((1.0 - cos_view) * (1.0 + cos_view))
        # The horizon of visible facets is cos_view - slope sin_view = 0; integrating up to it keeps the
        # integrand smooth.
        top = limit if cos_view >= limit * sin_view else cos_view / sin_view
        along = (0.5 * ((top + limit) * along_nodes + top - limit))[None, :]
        slope_squared = along**2 + across**2
        seen = np.maximum(cos_view - along * sin_view, 0.0)
        cos_incidence = seen / np.sqrt(1.0 + slope_squared)
        share = seen * slope_density(slope_squared, mean_square_slope)
        share = share * across_weights[:, None] * along_weights[None, :]
        basis = np.polynomial.chebyshev.chebvander(2.0 * cos_incidence.ravel() - 1.0, degree)
        row[:] = (share.ravel() / share.sum()) @ basis @ fit
    return rows


Shadowing = Literal["none", "separable", "height-correlated"]


def smith_lambda(mu: Array, variance_along: Array | float) -> Array:
    """Return Smith's Lambda for Gaussian slopes.

    Parameters
    ----------
    mu : ndarray
        Cosines of the zenith angle, in (0, 1]; grows like 1 / mu toward the horizon.
    variance_along : float or ndarray
        Variance of the slope in the vertical plane of the direction; broadcasts.

    Returns
    -------
    ndarray
        exp(-v^2) / (2 v sqrt(pi)) - erfc(v) / 2 with v = cot(zenith) / sqrt(2 variance), not negative.
    """
    sine = np.sqrt((1.0 - mu) * (1.0 + mu))
    with np.errstate(divide="ignore"):
        v = np.divide(mu, np.sqrt(2.0 * np.asarray(variance_along)) * sine)
    # Beyond 26 the value is below the smallest double; this also makes v finite at the zenith.
    v = np.minimum(v, 30.0)
    tail = np.exp(-(v**2)) / (np.sqrt(np.pi) * v) - _complementary_error(v.ravel()).reshape(v.shape)
    return np.asarray(0.5 * np.maximum(tail, 0.0), dtype=np.float64)


@kernel()
def _complementary_error(x: Array) -> Array:
    """Return erfc(x); scipy.special takes .2 s to import."""
    result = np.empty_like(x)
    for i in range(x.size):
        result[i] = math.erfc(x[i])
    return result


def both_seen(lambda_out: Array, lambda_in: Array, shadowing: Shadowing) -> Array:
    """Return the fraction of specular facets visible from both directions; symmetric in the two.

    ``none`` gives 1, ``separable`` the product of the two fractions, ``height-correlated`` Smith's bistatic form.
    """
    if shadowing == "none":
        return np.ones(np.broadcast(lambda_out, lambda_in).shape)
    if shadowing == "separable":
        return np.asarray(1.0 / ((1.0 + lambda_out) * (1.0 + lambda_in)))
    return np.asarray(1.0 / (1.0 + (lambda_out + lambda_in)))


def escape_share(lambda_out: Array | float, lambda_in: Array, shadowing: Shadowing) -> Array:
    """Return the fraction of facets visible from one direction that is also visible from an upward direction."""
    if shadowing == "none":
        return np.ones(np.broadcast(lambda_out, lambda_in).shape)
    if shadowing == "separable":
        return np.asarray(1.0 / (1.0 + lambda_in))
    return np.asarray((1.0 + lambda_out) / (1.0 + (lambda_out + lambda_in)))


@dataclass(frozen=True, eq=False)
class FacetRays:
    """Facets that a ray meets.

    Attributes
    ----------
    share : ndarray (P,)
        Fraction of the view; sums to 1.
    cos_incidence : ndarray (P,)
        In (0, 1].
    mu_away : ndarray (P,)
        Sine of the elevation of the reflected ray; negative if it goes down.
    turn : ndarray (P,)
        Azimuth of the reflected ray, relative to that of the viewer (first hit) or of the ray (second hit).
    """

    share: Array
    cos_incidence: Array
    mu_away: Array
    turn: Array


def seen_facets(
    mu: float, wind_azimuth: float, slopes: SlopeStatistics, count: int = 96, mean: tuple[float, float] = (0.0, 0.0)
) -> FacetRays:
    """Return the facets visible to a viewer.

    Parameters
    ----------
    mu : float
        Cosine of the view zenith angle, in (0, 1].
    wind_azimuth : float
        Bearing of the viewer minus the bearing the wind comes from, radians.
    slopes : SlopeStatistics
        Density of slopes.
    count : int
        Gauss-Legendre nodes along the view; three quarters of them across.
    mean : (float, float)
        Slope along and across the view about which ``slopes`` is centred.

    Notes
    -----
    Rays just above the horizon escape and rays just below hit the sea, so the quadrature converges slowly: with
    96 nodes emissivity is within 4e-5, and the light from the sky within 2e-4, of 512 nodes (winds of 0 to 40 m/s,
    views to 89 degrees).
    """
    sine = float(np.sqrt((1.0 - mu) * (1.0 + mu)))
    along, across, weight, density = _nodes(mu, sine, wind_azimuth, slopes, count, mean)
    seen = np.maximum(mu - along * sine, 0.0)
    return _mirrored(seen, along, across, weight * density, mu, -sine)


def facets_hit_again(mu: float, slopes: SlopeStatistics, count: int = 48) -> FacetRays:
    """Return the facets that a ray from the sea with elevation sine ``mu`` (-1 to 1) meets.

    ``slopes`` must be isotropic. An upward ray meets only facets steeper than itself.
    """
    sine = float(np.sqrt((1.0 - mu) * (1.0 + mu)))
    # A ray that travels with elevation sine mu sees what a viewer in the opposite direction would see, whose
    # cosine is -mu; with the axis along the ray the slope changes sign.
    along, across, weight, density = _nodes(-mu, sine, 0.0, slopes, count, (0.0, 0.0))
    seen = np.maximum(-mu - along * sine, 0.0)
    return _mirrored(seen, along, across, weight * density, -mu, -sine)


def _nodes(
    mu: float, sine: float, wind_azimuth: float, slopes: SlopeStatistics, count: int, mean: tuple[float, float]
) -> tuple[Array, Array, Array, Array]:
    """Return slopes along and across the view up to the limit of visible facets, weights and densities."""
    x, w = gauss_legendre(count)
    if slopes.isotropic and mean[1] == 0.0:  # the two sides of the view are alike
        y, v = gauss_legendre(3 * count // 8)
        y = 0.5 * (y + 1.0)
    else:
        y, v = gauss_legendre(3 * count // 4)
    cosine, sine_wind = np.cos(wind_azimuth), np.sin(wind_azimuth)
    variance = float(slopes.variance_along(wind_azimuth))
    covariance = (slopes.variance_crosswind - slopes.variance_upwind) * cosine * sine_wind
    limit = _MAX_SIGMA * float(np.sqrt(variance))
    # Integrating just up to the horizon mu = slope * sine keeps the integrand smooth.
    above = mu - mean[0] * sine
    top = limit if above >= limit * sine else above / sine
    bottom = -limit if top > -limit else top - 2.0 * float(np.sqrt(variance))
    along = (0.5 * ((top - bottom) * x + top + bottom))[:, None]
    spread = float(np.sqrt(slopes.variance_upwind * slopes.variance_crosswind / variance))
    across = along * (covariance / variance) + _MAX_SIGMA * spread * y[None, :]
    density = slopes.density(along * cosine - across * sine_wind, along * sine_wind + across * cosine)
    along = np.broadcast_to(along, across.shape) + mean[0]
    weight = (w[:, None] * v[None, :]).ravel()
    return along.ravel(), across.ravel() + mean[1], weight, density.ravel()


def _mirrored(seen: Array, along: Array, across: Array, weight: Array, mu: float, ahead: float) -> FacetRays:
    share = weight * seen
    kept = share > NEGLIGIBLE * np.sum(share)  # more than half are not: they are steep, or turned away
    seen, along, across, share = seen[kept], along[kept], across[kept], share[kept]
    steep = 1.0 + along**2 + across**2
    # Twice the normal's vertical part times the cosine of incidence, per unit of the normal's components.
    lift = 2.0 * seen / steep
    return FacetRays(
        share=share / share.sum(),
        cos_incidence=np.minimum(seen / np.sqrt(steep), 1.0),
        mu_away=np.clip(lift - mu, -1.0, 1.0),
        turn=np.arctan2(-lift * across, ahead - lift * along),
    )
