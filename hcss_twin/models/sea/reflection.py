"""Reflected light: the part of the sky that it comes from, and the amount after a second reflection.

The integral over slopes is linear in the reflectance, a function of the cosine of incidence, and in the sky radiance, a
function of the zenith cosine. It is computed once for the interpolation nodes of both, so that each wavelength costs
only one matrix product (as in :mod:`hcss_twin.models.sea.facets`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sea.facets import (
    NEGLIGIBLE,
    FacetRays,
    Shadowing,
    escape_share,
    facets_hit_again,
    incidence_nodes,
    seen_facets,
    smith_lambda,
)
from hcss_twin.models.sea.slope_statistics import SlopeStatistics, Tilt

Basis = Literal["linear", "lagrange"]


def checked_nodes(mu_nodes: Array) -> Array:
    """Return the nodes (N,) as float64.

    Raises
    ------
    ValueError
        If they are not one-dimensional, not ascending, or outside (0, 1].
    """
    nodes = np.asarray(mu_nodes, dtype=np.float64)
    inside = nodes.ndim == 1 and nodes.size > 0 and bool(np.all((nodes > 0.0) & (nodes <= 1.0)))
    if not (inside and np.all(np.diff(nodes) > 0.0)):
        raise ValueError(f"mu_nodes {np.array2string(nodes, threshold=9)}: needs (N,), ascending in 0 < mu <= 1")
    return nodes


def basis_values(mu: Array, nodes: Array, basis: Basis) -> Array:
    """Return the weights (P, N) that interpolate a function from the nodes to ``mu`` (P,); rows sum to 1.

    ``linear`` is constant beyond the outermost nodes; ``lagrange`` is the polynomial through all nodes, suitable only
    for the nodes of a Gauss rule.
    """
    if nodes.size == 1:
        return np.ones((mu.size, 1))
    if basis == "linear":
        right, part = _interval(mu, nodes)
        weights = np.zeros((mu.size, nodes.size))
        row = np.arange(mu.size)
        weights[row, right - 1] = 1.0 - part
        weights[row, right] = part
        return weights
    # Times 4, products of the differences stay near 1 for any number of nodes in (0, 1); exact, and the sum cancels it.
    difference = 4.0 * (nodes[:, None] - nodes[None, :]) + np.eye(nodes.size)
    barycentric = 1.0 / np.prod(difference, axis=1)
    distance = mu[:, None] - nodes[None, :]
    # At a node the quotient would be 0 / 0; at this distance the result equals the node's value to rounding.
    distance = np.where(np.abs(distance) < 1e-300, 1e-300, distance)
    weights = barycentric[None, :] / distance
    return np.asarray(weights / weights.sum(axis=1, keepdims=True), dtype=np.float64)


def gathered_linearly(mu: Array, nodes: Array, values: Array) -> Array:
    """Return ``basis_values(mu, nodes, "linear").T @ values`` (N, K) for values (P, K), and two or more nodes."""
    right, part = _interval(mu, nodes)
    order = np.argsort(right, kind="stable")
    right_nodes, begins = np.unique(right[order], return_index=True)
    result = np.zeros((nodes.size, values.shape[1]))
    for node, weights in ((right_nodes - 1, 1.0 - part), (right_nodes, part)):
        result[node] += np.add.reduceat(values[order] * weights[order, None], begins)
    return result


def _interval(mu: Array, nodes: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the index of the node above each ``mu`` (P,) and its weight, 0 to 1; the end node outside the range."""
    right = np.clip(np.searchsorted(nodes, mu), 1, nodes.size - 1)
    part = np.clip((mu - nodes[right - 1]) / (nodes[right] - nodes[right - 1]), 0.0, 1.0)
    return right, part


INCIDENCE_COUNT = 32
_ELEVATION_COUNT = 41
_STEEPEST_SIGMA = 4.5


@dataclass(frozen=True, eq=False)
class FirstHit:
    """Integrated first reflection of a view: ``sky`` (N, K) escapes to the sky, ``sea`` (E, K) hits the sea again.

    ``whole`` (K,) escapes to any part of the sky, independent of the nodes.
    """

    sky: Array
    sea: Array
    whole: Array

    def of_the_whole_sky(self) -> FirstHit:
        """Return this reflection with the whole sky as one node."""
        return FirstHit(self.whole[None], self.sea, self.whole)


class Reflection:
    """Reflection by a sea surface.

    Parameters
    ----------
    slopes : SlopeStatistics
        Density of slopes.
    shadowing : {"none", "separable", "height-correlated"}
        Determines which reflected rays escape.
    re_reflection : bool
        Whether rays that do not escape hit a second facet; otherwise they count as coming from the sky.
    azimuths : int
        Number of wind azimuths in the average if none is given and slopes are not isotropic.
    """

    def __init__(self, slopes: SlopeStatistics, shadowing: Shadowing, re_reflection: bool, azimuths: int = 12) -> None:
        self._slopes = slopes
        # Known reflections by view, wind azimuth and nodes, and by nodes.
        self.folds: dict[tuple[float, float | None, bytes, Basis], FirstHit] = {}
        self.seconds: dict[tuple[bytes, Basis], Array] = {}
        self._shadowing = shadowing
        self._re_reflection = re_reflection
        self._azimuths = (np.arange(azimuths) + 0.5) * np.pi / azimuths
        half = 0.5 * slopes.mean_square_slope
        # The second facet may have any azimuth relative to the wind, so its slopes are azimuth averages.
        self._round = SlopeStatistics(half, half)
        steepest = float(np.arctan(_STEEPEST_SIGMA * np.sqrt(half)))
        self._elevation = np.linspace(-0.5 * np.pi, steepest, _ELEVATION_COUNT)
        degree = INCIDENCE_COUNT - 1
        nodes = incidence_nodes(INCIDENCE_COUNT)
        self._fit = np.linalg.inv(chebyshev.chebvander(2.0 * nodes - 1.0, degree))

    def first(
        self, mu: float, mu_nodes: Array, basis: Basis, wind_azimuth: float | None, tilt: Tilt | None = None
    ) -> FirstHit:
        """Integrate the first reflection for a view, optionally at a wind azimuth.

        Facets of a tilted part have its slope statistics; whether their light escapes depends on the whole sea.
        """
        sky, whole = np.zeros((mu_nodes.size, INCIDENCE_COUNT)), np.zeros(INCIDENCE_COUNT)
        sea = np.zeros((self._elevation.size, INCIDENCE_COUNT))
        if wind_azimuth is not None:
            azimuths = np.array([wind_azimuth])
        else:
            azimuths = np.zeros(1) if self._slopes.isotropic or mu == 1.0 else self._azimuths
        for azimuth in azimuths.tolist():
            # Averaging over azimuths reduces the errors of a coarser rule.
            count = 96 if azimuths.size == 1 else 64
            slopes, mean = self._slopes, (0.0, 0.0)
            if tilt is not None:
                along, across = tilt.turned(azimuth)
                slopes, mean = tilt.rest, (float(along), float(across))
            rays = seen_facets(mu, azimuth, slopes, count, mean)
            incidence = _incidence(rays)
            escapes = self._escaping(mu, azimuth, rays)
            to_sky = rays.share * escapes / azimuths.size
            sky += self._folded(incidence, to_sky, basis_values(np.abs(rays.mu_away), mu_nodes, basis))
            whole += to_sky @ incidence @ self._fit
            if self._re_reflection:
                to_sea = rays.share * (1.0 - escapes) / azimuths.size
                met = to_sea > NEGLIGIBLE  # most rays of a view from above escape
                elevation, weighted = np.arcsin(rays.mu_away[met]), incidence[met] * to_sea[met, None]
                sea += gathered_linearly(elevation, self._elevation, weighted) @ self._fit
        return FirstHit(sky, sea, whole)

    def second(self, mu_nodes: Array, basis: Basis) -> Array:
        """Integrate the second reflection (E, N, K) for rays of each elevation.

        Rays that go down again are treated as coming from the same angle above the horizon.
        """
        if not self._re_reflection:
            return np.zeros((self._elevation.size, mu_nodes.size, INCIDENCE_COUNT))
        return np.stack(
            [
                self._folded(incidence, rays.share, basis_values(np.abs(rays.mu_away), mu_nodes, basis))
                for rays, incidence in self._again
            ]
        )

    @cached_property
    def _again(self) -> list[tuple[FacetRays, Array]]:
        """Return the facets that rays of each elevation hit again, and Chebyshev polynomials of incidence cosine."""
        met = (facets_hit_again(float(sine), self._round) for sine in np.sin(self._elevation))
        return [(rays, _incidence(rays)) for rays in met]

    def _escaping(self, mu: float, wind_azimuth: float, rays: FacetRays) -> Array:
        """Return the fraction of each reflected ray that hits no other facet."""
        if not self._re_reflection:
            return np.ones(rays.share.size)
        up = rays.mu_away > 0.0
        away = np.where(up, rays.mu_away, 1.0)
        variance = self._slopes.variance_along(wind_azimuth + rays.turn)
        outward = smith_lambda(np.array(mu), self._slopes.variance_along(wind_azimuth))
        return np.where(up, escape_share(outward, smith_lambda(away, variance), self._shadowing), 0.0)

    def _folded(self, incidence: Array, share: Array, elsewhere: Array) -> Array:
        return np.asarray((elsewhere * share[:, None]).T @ incidence @ self._fit, dtype=np.float64)


def _incidence(rays: FacetRays) -> Array:
    """Return Chebyshev polynomials (P, K) of the cosine of incidence."""
    return np.asarray(chebyshev.chebvander(2.0 * rays.cos_incidence - 1.0, INCIDENCE_COUNT - 1))


def reflected(first: Sequence[FirstHit], second: Array, reflectance: Array) -> Array:
    """Return the fraction of the light (M, N, V) that comes from the sky at each node.

    Parameters
    ----------
    first : sequence of FirstHit (M,)
        From :meth:`Reflection.first`, of each view.
    second : ndarray (E, N, K)
        From :meth:`Reflection.second`.
    reflectance : ndarray (K, V)
        Fresnel's reflectance at the nodes of incidence.
    """
    once = np.stack([view.sky for view in first]) @ reflectance
    again = np.stack([view.sea for view in first]) @ reflectance
    size = second.shape[1]
    twice = np.einsum("mev,env->mnv", again, second @ reflectance, optimize=False) if size else 0.0
    return np.asarray(once + twice, dtype=np.float64)
