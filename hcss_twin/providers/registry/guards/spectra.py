"""Checks of spectral properties and radiance: sea, surfaces, optics, transmittance, radiance models."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin import providers as api
from hcss_twin.core.arrays import Array
from hcss_twin.physics.paths import Path
from hcss_twin.providers.common import FRACTION_TOLERANCE, KELVIN_TOLERANCE
from hcss_twin.providers.registry.guards.base import ANY, FRACTION, POSITIVE, Guard


class GuardedWaves(Guard):
    """Waves whose slopes are checked, once per window."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        shape = (2, rows.stop - rows.start, columns.stop - columns.start)
        return self._array(
            "wave_field().slopes()", self._call("slopes", time_s, rows, columns), shape, dtype=np.float32
        )


class GuardedSea(Guard):
    """A sea model whose emissivity and BRDF, and reflection weights and waves if it has them, are checked."""

    def emissivity(self, wavenumber_cm1: Array, mu: Array, wind_azimuth: Array | None = None) -> Array:
        wind = () if wind_azimuth is None else (wind_azimuth,)
        return self._spectral("emissivity", mu.shape, FRACTION, wavenumber_cm1, mu, *wind)

    def brdf(
        self,
        wavenumber_cm1: Array,
        mu_out: Array,
        mu_in: Array,
        relative_azimuth: Array,
        wind_azimuth: Array | None = None,
    ) -> Array:
        directions = (mu_out, mu_in, relative_azimuth, *(() if wind_azimuth is None else (wind_azimuth,)))
        return self._spectral("brdf", mu_out.shape, POSITIVE, wavenumber_cm1, *directions)

    def _checked_reflection_weights(
        self, wavenumber_cm1: Array, mu: Array, mu_nodes: Array, *arguments: Any, **keywords: Any
    ) -> Array:
        shape = mu.size, mu_nodes.size
        return self._spectral("reflection_weights", shape, ANY, wavenumber_cm1, mu, mu_nodes, *arguments, **keywords)

    def _checked_wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        rms = self._array("wave_slope_rms()", self._call("wave_slope_rms", pixel_size_m), (2,), POSITIVE)
        return float(rms[0]), float(rms[1])

    def _checked_wave_field(self, grid: api.Grid, motion: api.Motion, seed: int) -> GuardedWaves:
        return GuardedWaves(self._call("wave_field", grid, motion, seed), self._label, self._speaker)

    def _checked_tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> GuardedSea:
        return GuardedSea(self._call("tilted", upwind, crosswind, pixel_size_m), self._label, self._speaker)


class GuardedOptics(Guard):
    """An optics provider whose bulk properties are checked."""

    def single_scattering(self, cloud: api.Microphysics, wavenumber_cm1: Array) -> api.SingleScattering:
        """Return bulk properties: extinction not negative, albedo in [0, 1], moment 0 = 1, others in (-1, 1).

        The solvers allow no rounding error in albedo and moment 0: within the tolerance they become their limits.
        """
        self._check_wavenumbers("single_scattering", wavenumber_cm1)
        value = self._call("single_scattering", cloud, wavenumber_cm1)
        what, size = "single_scattering()", wavenumber_cm1.size
        if not isinstance(value, api.SingleScattering):
            raise self._refuse(what, "SingleScattering", type(value).__name__)
        shape = np.shape(value.moments)
        if len(shape) != 2 or shape[0] < 2:
            raise self._refuse(f"{what}.moments", f"shape (K, {size}) with K of at least 2", f"shape {shape}")
        extinction = self._array(f"{what}.extinction_m1", value.extinction_m1, (size,), POSITIVE)
        albedo = np.clip(self._array(f"{what}.albedo", value.albedo, (size,), FRACTION), 0.0, 1.0)
        moments = self._array(f"{what}.moments", value.moments, (shape[0], size))
        wrong = (np.abs(moments[0] - 1.0) > FRACTION_TOLERANCE) | np.any(np.abs(moments[1:]) >= 1.0, axis=0)
        if np.any(wrong):
            got = ", ".join(f"{moment:.9g}" for moment in moments[:3, np.argmax(wrong)])
            raise self._refuse(f"{what}.moments", "moments[0] = 1 and the others above -1 and below 1", f"{got}, ...")
        if np.any(moments[0] != 1.0):
            moments = np.concatenate((np.ones((1, size)), moments[1:]))
        return api.SingleScattering(extinction, albedo, moments)


class GuardedTransmittance(Guard):
    """A transmittance provider whose transmittances, and path radiances if it has them, are checked."""

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        return self._spectral("transmittance", (len(paths),), FRACTION, wavenumber_cm1, paths)

    def _checked_absorber_amounts(self, paths: Sequence[Path]) -> Array:
        value = self._call("absorber_amounts", paths)
        shape = np.shape(value)
        return self._array("absorber_amounts()", value, (len(paths), *shape[1:2]))

    def _checked_transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        return self._spectral("transmittance_of_amounts", (len(amounts),), FRACTION, wavenumber_cm1, amounts)

    def _checked_scattering_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        shape = (2, len(amounts))
        return self._spectral("scattering_of_amounts", shape, POSITIVE, wavenumber_cm1, amounts)

    def _checked_vapour_kinks(self, low: float, high: float) -> tuple[float, ...]:
        value = self._call("vapour_kinks", low, high)
        kinks = self._array("vapour_kinks()", value, np.shape(value)[:1])
        if np.any(np.diff(kinks, prepend=low, append=high) <= 0.0):
            raise self._refuse("vapour_kinks()", f"ascending factors in ({low:g}, {high:g})", str(kinks.tolist()))
        return tuple(kinks.tolist())

    def _checked_path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        return self._spectral("path_radiance", (len(paths),), POSITIVE, wavenumber_cm1, paths)

    def _checked_solar_path_radiance(
        self, wavenumber_cm1: Array, paths: Sequence[Path], *arguments: Any, **keywords: Any
    ) -> Array:
        shape = (len(paths),)
        return self._spectral("solar_path_radiance", shape, POSITIVE, wavenumber_cm1, paths, *arguments, **keywords)


class GuardedRadiance(Guard):
    """A radiance model whose terms are checked: names, shapes, finiteness; no sun, no solar term."""

    def columns(self, states: api.ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        value = self._call("columns", states, wavenumber_cm1)
        dark = np.array([setting.sun is None for setting in states.settings], dtype=np.bool_)[states.setting_of]
        return self._terms("columns()", value, (len(states), wavenumber_cm1.size), dark)

    def _terms(self, what: str, value: Any, shape: tuple[int, ...], dark: NDArray[np.bool_]) -> dict[str, Array]:
        names = tuple(self._read("terms"))
        if not isinstance(value, Mapping) or set(value) != set(names):
            got = (", ".join(map(str, value)) or "none") if isinstance(value, Mapping) else type(value).__name__
            raise self._refuse(what, f"a mapping with the terms {', '.join(names)}", got)
        terms: dict[str, Array] = {name: self._array(f"term '{name}' of {what}", value[name], shape) for name in names}
        for name in self._read("solar_terms"):
            if np.any(terms[name][dark]):
                raise self._refuse(f"solar term '{name}' of {what}", "exactly 0 without a sun", "other values")
        return terms


class GuardedSurfaces(Guard):
    """A surface provider whose maps are checked, once per window."""

    @functools.cached_property
    def classes(self) -> tuple[api.SurfaceClass, ...]:
        return tuple(
            class_
            if class_.boundary is None
            else replace(
                class_, boundary=GuardedSea(class_.boundary, f"{self._label}, class '{class_.name}'", self._speaker)
            )
            for class_ in self._read("classes")
        )

    def surface(self, time_s: float, rows: slice, columns: slice) -> api.SurfaceMap:
        value = self._call("surface", time_s, rows, columns)
        what, shape = "surface()", (rows.stop - rows.start, columns.stop - columns.start)
        if not isinstance(value, api.SurfaceMap):
            raise self._refuse(what, "SurfaceMap", type(value).__name__)
        classes = self.classes
        number = self._array(f"{what}.number", value.number, shape, (0, len(classes) - 1), np.uint8, "iu")
        fields = {n: class_ for n, class_ in enumerate(classes) if isinstance(class_.temperature_K, tuple)}
        if not fields:
            return api.SurfaceMap(number)
        kelvin = np.asarray(value.temperature_K)
        if kelvin.shape != shape or kelvin.dtype.kind != "f":
            raise self._refuse(f"{what}.temperature_K", f"real numbers of shape {shape}", f"shape {kelvin.shape}")
        for n, class_ in fields.items():
            class_kelvin = kelvin[number == n]
            low, high = class_.temperature_K  # type: ignore[misc]
            limits = low - KELVIN_TOLERANCE, high + KELVIN_TOLERANCE
            self._array(f"{what}.temperature_K of class '{class_.name}'", class_kelvin, class_kelvin.shape, limits)
            kelvin = np.where(number == n, np.clip(kelvin, low, high), kelvin)
        return api.SurfaceMap(number, kelvin.astype(np.float64, copy=False))
