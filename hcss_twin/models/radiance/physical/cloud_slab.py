"""Cloud layers: optics of their particles, computed once for the solvers of all suns and views, and their operators.

Emission, reflection and transmission of a layer sum to one in every direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.providers import Microphysics, Optics, SingleScattering

MOST_SPECTRA = 2
"""Spectra in memory, of some MB each: those of the solved wavenumbers and of the grid."""

MOST_CURVES = 16
"""Curves in memory, of some kB each."""

LEAST_SHARE = 1e-6
"""Shares below this count as equal: their logarithms would not be."""


class LayerOptics:
    """Optics of one provider.

    Parameters
    ----------
    optics : Optics
    """

    def __init__(self, optics: Optics) -> None:
        self._optics = optics
        self._spectra = cached_method(self._new_spectrum, MOST_SPECTRA)
        self._curves = cached_method(self._new_curves, MOST_CURVES)

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties at wavenumbers (V,)."""
        return self._spectra(cloud, wavenumber_cm1.tobytes())

    def curves(self, cloud: Microphysics, wavenumber_cm1: Array) -> Array:
        """Return what operators of a layer are smooth functions of, (4, V).

        These are the logarithms of extinction, albedo and 1 - s, and the similarity parameter s: with it, reflection of
        thick clouds falls from 1 to 0.
        """
        return self._curves(cloud, wavenumber_cm1.tobytes())

    def _new_spectrum(self, cloud: Microphysics, wavenumber_cm1: bytes) -> SingleScattering:
        return self._optics.single_scattering(cloud, np.frombuffer(wavenumber_cm1, dtype=np.float64))

    def _new_curves(self, cloud: Microphysics, wavenumber_cm1: bytes) -> Array:
        spectrum = self._new_spectrum(cloud, wavenumber_cm1)
        similarity = np.sqrt((1.0 - spectrum.albedo) / (1.0 - spectrum.albedo * spectrum.moments[1]))
        shares = np.stack((spectrum.extinction_m1, spectrum.albedo, 1.0 - similarity))
        result: Array = np.concatenate((np.log(np.maximum(shares, LEAST_SHARE)), similarity[None]))
        return result


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
    coupled_beams : ndarray (M', 2, 2, N, S)
        Modes of reflection and transmission of view and sun toward the streams, as in :class:`CoupledLayers`; none
        without a sun or other layers.
    between_streams : ndarray (M', 2, P, S)
        The same between the P pairs of streams of ``np.triu_indices``, float32.
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
    coupled_beams: Array
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
    emissivity, far, direct = (share / whole for share in (emissivity, far, direct))
    reflection, transmission = (kernel / whole[:, None] for kernel in (reflection, transmission))
    return emissivity, far, direct, reflection, transmission
