"""Fresnel's reflectance at many angles of incidence: a Chebyshev series in its cosine, where that is as good."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.sea.visible_facets import incidence_nodes

Array = NDArray[np.float64]

TERMS = 32

LARGEST_TAIL = 1e-12
"""Of the last terms of a series, relative to its largest; those of water are below 1e-13."""


def reflectance_at(index: NDArray[np.complex128], cos_incidence: Array) -> Array:
    """Return the reflectance for unpolarised light at M angles and V wavenumbers, (M, V).

    Reflectance is analytic in the cosine, so that a polynomial through Chebyshev points has all its digits after some
    thirty terms, and costs a matrix product. Where few angles are asked for, or the last terms are not small (metals),
    every angle is computed by itself.

    Parameters
    ----------
    index : ndarray (V,)
        Refractive index n + i k.
    cos_incidence : ndarray (M,)
        In (0, 1].

    Raises
    ------
    ValueError
        If a cosine is outside (0, 1].
    """
    few = cos_incidence.size <= 2 * TERMS
    if few or not (
        np.min(cos_incidence) > 0.0 and np.max(cos_incidence) <= 1.0
    ):  # NaN, too, is refused there
        return unpolarised_reflectance(index, cos_incidence[:, None])
    nodes = incidence_nodes(TERMS)
    at_nodes = unpolarised_reflectance(index, nodes[:, None])
    # Chebyshev polynomials are orthogonal over their points.
    terms = (2.0 / TERMS) * chebyshev.chebvander(2.0 * nodes - 1.0, TERMS - 1).T @ at_nodes
    terms[0] *= 0.5
    if np.any(np.max(np.abs(terms[-2:]), axis=0) > LARGEST_TAIL * np.max(np.abs(terms), axis=0)):
        return unpolarised_reflectance(index, cos_incidence[:, None])
    return np.asarray(chebyshev.chebvander(2.0 * cos_incidence - 1.0, TERMS - 1) @ terms)
