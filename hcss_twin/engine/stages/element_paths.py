"""Air and clouds between an element and the sensor, on all wavenumbers of the dense grid.

Direct transmission of clouds follows Bouguer's law, as for shadows (:mod:`hcss_twin.engine.tables.shadows`). It is
multiplied by the transmittance of the air, that of the whole path, at each wavenumber before the integration over the
band.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.physics.paths import Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun

__all__ = ["ElementPaths"]

_ALTITUDES = 64
"""Altitudes and colours in memory."""


_SKY_ZENITH_DEG = 53.0
"""Zenith angle at which the air's emission stands for its mean over the sky, weighted with the cosine: 1 / 1.66 (W. M.
Elsasser, Heat transfer by infrared radiation in the atmosphere, Harvard Meteorological Studies 6, 1942)."""


class ElementPaths:
    """Paths of one scene from any altitude to the sensor."""

    def __init__(self, plan: Plan) -> None:
        self._plan, self._setting = plan, plan.assembly.setting()
        self._wavenumber, self._weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1
        self.air = cached_method(self._new_air, _ALTITUDES)
        self.air_emission = cached_method(self._new_air_emission, _ALTITUDES)
        self._shares = cached_method(self._new_shares, _ALTITUDES)
        self._white = cached_method(self._new_white, _ALTITUDES)

    def band_mean(self, spectrum: Array, temperature_K: float | None = None) -> Array:
        """Return the mean (B,) of a spectrum (V,) over the bands, for light of a black body or, without, of no colour.

        The sum does not use BLAS, whose last bits may depend on the number of threads.
        """
        means: Array = np.sum(self._shares(temperature_K) * spectrum, axis=1)
        return means

    def heights_above(
        self,
        thickness_m: Sequence[NDArray[np.float32]],
        altitude_m: float,
        tops_m: Sequence[NDArray[np.float32] | None] = (),
    ) -> Array:
        """Return the vertical extent (L, P) of each layer's cloud above an altitude, from the thickness at P points.

        ``tops_m`` are the tops of layers whose tops vary, and None for others; by default none do.
        """
        heights = np.zeros((len(thickness_m), thickness_m[0].size if thickness_m else 0))
        tops = tops_m or [None] * len(thickness_m)
        layers = zip(heights, self._plan.layers, thickness_m, tops, strict=True)
        for height, layer, layer_thickness, varying in layers:
            thickness = layer_thickness.ravel().astype(np.float64)
            top = layer.cloud_top_m(thickness) if varying is None else varying.ravel().astype(np.float64)
            height[:] = np.clip(top - altitude_m, 0.0, thickness)
        return heights

    def through_cloud(self, heights_m: Array, zenith_deg: float) -> Array:
        """Return the direct transmission (V,) of clouds, mean over P points, from the extents (L, P) above them."""
        if not np.any(heights_m):
            return np.ones_like(self._wavenumber)
        depth = np.zeros((heights_m.shape[1], self._wavenumber.size))
        for height_m, extinction in zip(heights_m, self._extinction_m1, strict=True):
            depth += height_m[:, None] * extinction
        mean: Array = np.mean(np.exp(-depth / math.cos(math.radians(zenith_deg))), axis=0)
        return mean

    def reflected(self, altitude_m: float, zenith_deg: float, sun: Sun | None, heights_m: Array) -> Array:
        """Return the radiance (B,) that a white horizontal diffuser sends to the sensor: direct sun and thermal sky.

        Both pass the clouds (L, P) above it directly, sunlight twice; light that clouds scatter or emit toward it is
        left out. It would pass the same clouds on its way to the sensor.
        """
        sky, sunlight = self._white(altitude_m, zenith_deg, sun)
        light = sky
        if sun is not None:
            light = light + sunlight * self.through_cloud(heights_m, sun.zenith_deg)
        radiance: Array = np.sum(self._weights * (light * self.through_cloud(heights_m, zenith_deg)), axis=1)
        return radiance

    def _new_white(self, altitude_m: float, zenith_deg: float, sun: Sun | None) -> tuple[Array, Array]:
        """Thermal sky and sunlight (V,) from a white horizontal diffuser, behind the air on all of their way."""
        setting, none = self._setting, np.zeros_like(self._wavenumber)
        toward, profile = to_space(altitude_m, zenith_deg), setting.profile
        sky = none
        if altitude_m < profile.altitude_m[-1]:
            levels = np.concatenate(([altitude_m], profile.altitude_m[profile.altitude_m > altitude_m]))
            paths = [toward + Path((Leg(altitude_m, float(level), _SKY_ZENITH_DEG),)) for level in levels]
            arriving = setting.transmittance.transmittance(self._wavenumber, paths)
            kelvin = profile.temperature_at(levels)
            source = planck(self._wavenumber[None, :], 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
            sky = np.sum(source * (arriving[:-1] - arriving[1:]), axis=0)
        if sun is None:
            return sky, none
        both = toward + to_space(altitude_m, sun.zenith_deg)
        through = setting.transmittance.transmittance(self._wavenumber, [both])[0] if sky is not none else 1.0
        power = self._plan.assembly.solar_irradiance(self._wavenumber) / sun.distance_au**2
        return sky, power * math.cos(math.radians(sun.zenith_deg)) / math.pi * through

    @cached_property
    def _extinction_m1(self) -> list[Array]:
        optics = self._plan.assembly.optics
        return [
            optics.single_scattering(layer.microphysics, self._wavenumber).extinction_m1 for layer in self._plan.layers
        ]

    def _new_air(self, altitude_m: float, zenith_deg: float) -> Array:
        """Transmittance (V,) of the air above an altitude; above the profile there is none."""
        if altitude_m >= self._setting.profile.altitude_m[-1]:
            return np.ones_like(self._wavenumber)
        setting, wavenumber, path = self._setting, self._wavenumber, to_space(altitude_m, zenith_deg)

        def compute() -> tuple[Array]:
            return (setting.transmittance.transmittance(wavenumber, [path])[0],)

        if setting.air_memory is None:
            return compute()[0]
        key = b"above", np.array([altitude_m, zenith_deg]).tobytes(), wavenumber.tobytes()
        return setting.air_memory.get_or_compute(key, compute)[0]

    def _new_air_emission(self, altitude_m: float, zenith_deg: float) -> Array:
        """Thermal radiance (B,) of the air above an altitude."""
        setting = self._setting
        if altitude_m >= setting.profile.altitude_m[-1]:
            return np.zeros(len(self._weights))
        (spectrum,) = path_radiance(setting.transmittance, setting.profile, self._wavenumber, [altitude_m], zenith_deg)
        radiance: Array = np.sum(self._weights * spectrum, axis=1)
        return radiance

    def _new_shares(self, temperature_K: float | None) -> Array:
        """Weights (B, V) of a mean over each band."""
        colour = np.ones_like(self._wavenumber) if temperature_K is None else planck(self._wavenumber, temperature_K)
        weights = self._weights * colour
        total = np.sum(weights, axis=1, keepdims=True)
        # A body too cold for any radiance in a band has no colour there.
        dark = self._weights / np.sum(self._weights, axis=1, keepdims=True)
        shares: Array = np.divide(weights, total, out=dark, where=total > 0.0)
        return shares
