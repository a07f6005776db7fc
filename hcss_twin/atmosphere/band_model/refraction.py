"""Refracted rays through spherical layers (subroutines RFPATH and LAYER of LOWTRAN7).

W. O. Gallery, F. X. Kneizys and S. A. Clough, *Air Mass Computer Program for Atmospheric Transmittance/Radiance
Calculation: FSCATM*, AFGL-TR-83-0065 (1983): with x = r cos(zenith), the length of a ray is the integral of
1 / (1 - (r / rho) sin^2(zenith)) over x, rho being the radius of curvature of a horizontal ray, and n r sin(zenith)
stays constant along the ray.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.band_model.layers import Layers

Array = NDArray[np.float64]


def slant_factors(layers: Layers, invariant_m: Array) -> Array:
    """Length of rays over the thickness of each cell.

    Parameters
    ----------
    layers : Layers
        M cells.
    invariant_m : ndarray (P,)
        n r sin(zenith) of each ray.

    Returns
    -------
    ndarray (P, M)
    """
    sine = invariant_m[:, None, None] / (layers.index * layers.radius_m)
    along = layers.radius_m * np.sqrt((1.0 - sine) * (1.0 + sine))
    stretch = 1.0 / (1.0 - layers.bending * sine**2)
    # Parabola through three unequally spaced points.
    whole = along[..., 2] - along[..., 0]
    first = along[..., 1] - along[..., 0]
    second = along[..., 2] - along[..., 1]
    length = (whole / 6.0) * (
        (2.0 - second / first) * stretch[..., 0]
        + whole**2 / (first * second) * stretch[..., 1]
        + (2.0 - first / second) * stretch[..., 2]
    )
    result: Array = length / layers.thickness_m
    return result
