"""Emission, reflection and transmission operators of a cloud layer, which sum to one in every direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights


@dataclass(frozen=True)
class CloudSlab:
    """One layer of C columns; D directions (view and streams), N streams, V wavenumbers, S = C x V.

    Attributes
    ----------
    base_m, top_m : tuple of float (C,)
        Altitudes.
    top_temperature_K, base_temperature_K : tuple of float (C,)
    emissivity, far_share, direct : ndarray (D, S)
        As in :class:`LayerOperators`.
    reflection, transmission : ndarray (D, N, S)
        Contribution of each stream's radiance to the radiance toward a direction.
    sun_reflection, sun_transmission : ndarray (D, S)
        sr-1; toward the view at its azimuth, toward streams as azimuth mean; 0 without a sun.
    sun_direct : ndarray (S,)
        Direct transmittance for the sun; 0 without one.
    to_lower_air : ndarray (S,)
        Transmittance for sunlight that air below scatters into the view: both ways, light scattered in the forward peak
        included; 0 without a sun.
    beam_transmission : ndarray (M, 2, N, S)
        sr-1, azimuth modes from 1 on, of view and sun toward the streams; 0 where sunlight is negligible.
    beam_reflection : ndarray (1 + M, 2, N, S)
        The same of reflection, from mode 0 on as in :class:`CoveredLayers`; none without a sun.
    between_streams : ndarray (1 + M, 2, P, S)
        The same of reflection and transmission between the P pairs of streams of ``np.triu_indices``, float32.
    optical_thickness, albedo : ndarray (S,)
        Of the layer, and of single scattering.
    moments : ndarray (K, S)
        Of the phase function, the first ones.
    """

    base_m: Heights
    top_m: Heights
    top_temperature_K: tuple[float, ...]
    base_temperature_K: tuple[float, ...]
    emissivity: Array
    far_share: Array
    direct: Array
    reflection: Array
    transmission: Array
    sun_reflection: Array
    sun_transmission: Array
    sun_direct: Array
    to_lower_air: Array
    beam_transmission: Array
    beam_reflection: Array
    between_streams: Array
    optical_thickness: Array
    albedo: Array
    moments: Array


def side_by_side(slabs: Sequence[CloudSlab]) -> CloudSlab:
    """Join the columns of several slabs into one."""
    first, *others = slabs
    if not others:
        return first
    together: dict[str, Any] = {}
    for field in fields(CloudSlab):
        values = [getattr(slab, field.name) for slab in slabs]
        of_columns = isinstance(values[0], tuple)
        together[field.name] = sum(values, ()) if of_columns else np.concatenate(values, axis=-1)
    return CloudSlab(**together)


def closed(
    emissivity: Array, far: Array, direct: Array, reflection: Array, transmission: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Normalise row sums to one; clipping negative interpolated values changes them by about 1e-7."""
    whole = emissivity + direct + np.sum(reflection, axis=1) + np.sum(transmission, axis=1)
    emissivity, far, direct = (each / whole for each in (emissivity, far, direct))
    reflection, transmission = (each / whole[:, None] for each in (reflection, transmission))
    return emissivity, far, direct, reflection, transmission
