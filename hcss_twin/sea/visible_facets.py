"""Averages over the wave facets that a viewer sees.

A facet of slope (zx, zy), tilted by theta_n, is met by the line of sight under the angle chi. Seen from
the zenith angle theta it takes the share P(zx, zy) cos(chi) / (cos(theta) cos(theta_n)) of the view
(K. Masuda, T. Takashima and Y. Takayama, Emissivity of pure and sea waters for the model sea surface in
the infrared window regions, Remote Sens. Environ. 24, 313-329, 1988). Facets with cos(chi) <= 0 are not
seen; facets do not hide one another. With the x axis pointing toward the viewer and zx = dz/dx,
cos(chi) / cos(theta_n) = cos(theta) - zx sin(theta).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.gauss_legendre import gauss_legendre
from hcss_twin.sea.slopes import slope_density

# Slopes beyond this many standard deviations of a component hold 2e-9 of the facets.
_SLOPE_LIMIT_SIGMA = 6.0


def incidence_nodes(count: int) -> NDArray[np.float64]:
    """Return ``count`` Chebyshev points of the cosine of incidence within (0, 1), shape (K,)."""
    return np.asarray(0.5 * (1.0 + np.polynomial.chebyshev.chebpts1(count)), dtype=np.float64)


def facet_weights(
    mu: NDArray[np.float64],
    mean_square_slope: float,
    incidence_count: int = 32,
    slope_count: int = 64,
) -> NDArray[np.float64]:
    """Return weights that average a function of the angle of incidence over the visible facets.

    The integral over slopes is linear in the function, so it is folded once onto the function's
    interpolation nodes: ``facet_weights(...) @ g(incidence_nodes(K))`` is the average of g. Reflectance is
    analytic in the cosine, which makes that spectrally accurate, and the wavelengths cost nothing more.

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

    Returns
    -------
    ndarray (M, K)
        Rows sum to 1. Single weights may be negative, as those of any interpolation.

    Notes
    -----
    Measured with the optical constants of water at 0.25 to 190 um, mu 0.001 to 1 and winds of 0 to 60 m/s:
    doubling the nodes changes the emissivity by less than 1e-12, and half the slope nodes by 1e-11. The
    truncation of the slopes leaves 2e-9.
    """
    mu = np.asarray(mu, dtype=np.float64)
    limit = _SLOPE_LIMIT_SIGMA * np.sqrt(0.5 * mean_square_slope)
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
