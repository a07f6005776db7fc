"""Thermal radiation that particles scatter into the view of the sky.

Aerosol emits what it absorbs. What it scatters into the path of an observer who looks up is mostly light of the cold
sky, sent forward, and a little of the warm sea, sent back.

Each hemisphere is one stream at the diffusivity angle (W. M. Elsasser, *Heat Transfer by Infrared Radiation in the
Atmosphere*, Harvard Meteorol. Stud. 6, 1942); the share that is scattered from one hemisphere into a direction of the
other is that of the Henyey-Greenstein function (W. J. Wiscombe and G. W. Grams, *The Backscattered Fraction in
Two-Stream Approximations*, J. Atmos. Sci. 33, 2440, 1976).
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hcss_twin.core.arrays import Array

DIFFUSE_DEG: Final = math.degrees(math.acos(1.0 / 1.66))
"""Zenith angle of the stream that stands for a hemisphere."""

_HEMISPHERE: Final = {1: 1 / 2, 3: -1 / 8, 5: 1 / 16, 7: -5 / 128, 9: 7 / 256, 11: -21 / 1024}
"""Integrals of the odd Legendre polynomials from 0 to 1."""

_LEAST: Final = 1e-300


def streams(
    black: Array, transmittance: Array, scattering: Array, asymmetry: Array, ends: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Return the radiance downward and upward in the middle of layers, (N, V) each.

    Light scattered forward stays in its stream. That scattered back counts as emission of the layer: below, it is
    replaced by light of the sea, which has nearly its temperature.

    Parameters
    ----------
    black : ndarray (N, V)
        Planck radiance of the layers, the lowest first.
    transmittance, scattering : ndarray (N, V)
        Of each layer alone at ``DIFFUSE_DEG``; optical depth of the scattering.
    asymmetry : ndarray (N, V)
        Mean cosine of the scattering angle.
    ends : (ndarray (V,), ndarray (V,))
        Radiance of the sea, upward, and of space, downward.
    """
    forward = 1.0 - 0.5 * (1.0 - 0.875 * asymmetry)
    open_ = np.minimum(transmittance * np.exp(forward * scattering), 1.0)
    emitted = (1.0 - open_) * black
    sea, space = ends
    return _middle(space, open_[::-1], emitted[::-1])[::-1], _middle(sea, open_, emitted)


def _middle(entering: Array, open_: Array, emitted: Array) -> Array:
    result = np.empty_like(emitted)
    for row, (through, source) in enumerate(zip(open_, emitted, strict=True)):
        leaving = entering * through + source
        result[row] = 0.5 * (entering + leaving)
        entering = leaving
    return result


def backscattered(cosine: Array, asymmetry: Array) -> Array:
    """Return the share of light from a hemisphere that a Henyey-Greenstein function sends into the other, 0 to 1.

    Parameters
    ----------
    cosine : ndarray
        Of the angle between the direction in the other hemisphere and the normal; broadcasts with ``asymmetry``.
    asymmetry : ndarray
        0 to about 0.9.
    """
    total = np.zeros(np.broadcast_shapes(np.shape(cosine), np.shape(asymmetry)))
    for order, integral in _HEMISPHERE.items():
        polynomial = np.polynomial.legendre.legval(cosine, np.eye(order + 1)[order])
        total += (2 * order + 1) * integral * polynomial * asymmetry**order
    result: Array = np.clip(0.5 * (1.0 - total), 0.0, 1.0)
    return result


def scattered_share(seen: Array, scattering: Array) -> Array:
    """Return the share of scattering (P, N, V) in what layers take out of rays, 0 to 1.

    Parameters
    ----------
    seen : ndarray (P, N + 1, V)
        Transmittance from the observer to the near end of each layer, and to the far end of the last.
    scattering : ndarray (P, N, V)
        Optical depth of the scattering in each layer along the rays.
    """
    lost = np.log(np.maximum(seen[:, :-1], _LEAST) / np.maximum(seen[:, 1:], _LEAST))
    result: Array = np.clip(scattering / np.maximum(lost, _LEAST), 0.0, 1.0)
    return result
