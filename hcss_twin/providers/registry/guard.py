"""Checks at the door: what a provider returns is looked at before the engine computes with it.

Every wrapper has the methods of its Protocol. A result of another shape, of a type that is no real
number, not finite or out of range, and any exception that is not deliberate (``HcssError``), becomes
a ProviderError that names provider, distribution and method. Values are converted to the contract's
dtype and never altered. All other attributes are those of the provider.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hcss_twin.core.errors import HcssError, ProviderError
from hcss_twin.core.plugins import FAILURES, OWN_DISTRIBUTION, describe
from hcss_twin.physics.paths import Path
from hcss_twin.providers import (
    Array,
    CloudInputs,
    CloudLayer,
    Declares,
    Grid,
    Measured,
    Microphysics,
    Motion,
    SensorInputs,
    SingleScattering,
    Sun,
)
from hcss_twin.providers.common import attributed
from hcss_twin.providers.registry.declared import LAYER_OPTIONS
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.specs import Kind

FRACTION_TOLERANCE = 1e-9
"""How far emissivity, transmittance and albedo may leave [0, 1] by rounding."""

THICKNESS_TOLERANCE = 1e-6
"""How far, relatively, a float32 thickness may exceed the layer's greatest."""

_INFINITY = float("inf")
_Result = TypeVar("_Result")


class _Guard:
    """What the wrappers share: the provider, its label, guarded calls and array checks."""

    def __init__(self, provider: Any, label: str) -> None:
        self._provider = provider
        self._label = label
        self._speaker = ""

    def named(self, speaker: str) -> Self:
        """Let notes and errors that the provider tells of itself begin with who says so."""
        self._speaker = speaker
        return self

    @property
    def declares(self) -> Declares:
        """What the provider says about itself."""
        declares: Declares = self._provider.declares
        return attributed(declares, self._speaker) if self._speaker else declares

    def __getattr__(self, name: str) -> Any:
        # copies and unpickled objects are asked for attributes before they have a provider
        if name.startswith("__") or name in ("_provider", "_label", "_speaker"):
            raise AttributeError(name)
        return getattr(self._provider, name)

    def _call(self, method: str, function: Callable[..., _Result], *arguments: Any) -> _Result:
        try:
            return function(*arguments)
        except HcssError:
            raise
        except FAILURES as error:
            raise ProviderError(f"{self._label}: {method}() raised {describe(error)}") from error

    def _refuse(self, what: str, expected: str, got: str) -> ProviderError:
        return ProviderError(f"{self._label}: {what} broke its contract: expected {expected}, got {got}")

    def _array(
        self,
        what: str,
        value: Any,
        shape: tuple[int, ...],
        low: float = -_INFINITY,
        high: float = _INFINITY,
        dtype: DTypeLike = np.float64,
    ) -> NDArray[Any]:
        """Return ``value`` as an array of ``dtype`` after checking shape, type, finiteness and range."""
        if isinstance(value, np.ma.MaskedArray):
            raise self._refuse(what, f"a plain array of shape {shape}", "a masked array")
        try:
            array = np.asarray(value)
        except FAILURES as error:
            raise self._refuse(what, f"an array of shape {shape}", describe(error)) from error
        if array.dtype.kind not in "fiu":
            raise self._refuse(what, f"real numbers of shape {shape}", f"{type(value).__name__} of {array.dtype}")
        if array.shape != shape:
            raise self._refuse(what, f"shape {shape}", f"shape {array.shape}")
        if array.size:
            # minimum and maximum carry NaN and infinity along: two passes and no temporary
            least, most = float(array.min()), float(array.max())
            if not (np.isfinite(least) and np.isfinite(most)):
                bad = int(np.count_nonzero(~np.isfinite(array)))
                raise self._refuse(what, "finite values", f"{bad} of {array.size} not finite")
            if least < low or most > high:
                raise self._refuse(what, f"values in [{low:g}, {high:g}]", f"{least:.9g} to {most:.9g}")
        return array.astype(dtype, copy=False)

    def _fraction(self, what: str, value: Any, shape: tuple[int, ...]) -> Array:
        return self._array(what, value, shape, -FRACTION_TOLERANCE, 1.0 + FRACTION_TOLERANCE)

    def _check_wavenumbers(self, method: str, wavenumber_cm1: Array) -> None:
        """Refuse to ask outside the declared range: nobody clamps, nobody extrapolates."""
        valid = self._provider.declares.valid.get("wavenumber_cm1")
        if valid is None or wavenumber_cm1.size == 0:
            return
        asked = float(wavenumber_cm1.min()), float(wavenumber_cm1.max())
        if asked[0] < valid[0] or asked[1] > valid[1]:
            raise ProviderError(
                f"{self._label}: {method}() was asked for {asked[0]:.6g} to {asked[1]:.6g} cm-1; "
                f"valid are {valid[0]:.6g} to {valid[1]:.6g} cm-1"
            )


class GuardedClouds(_Guard):
    """A cloud generator whose fields are checked, once per window."""

    def __init__(self, provider: Any, label: str, layer: CloudLayer, grid: Grid) -> None:
        super().__init__(provider, label)
        self._layer = layer
        self._grid = grid

    @property
    def declares(self) -> Declares:
        """What the provider says about itself, and which keys of the layer it may not look at."""
        declares = super().declares
        if not self._speaker:
            return declares
        honoured = getattr(self._provider, "honours", ())
        usual = {field.name: field.default for field in fields(CloudLayer)}
        silent = tuple(
            f"{self._speaker}: does not say that it honours {name} = {getattr(self._layer, name)!r}, which may have no "
            "influence"
            for name in LAYER_OPTIONS
            if name not in honoured and getattr(self._layer, name) != usual[name]
        )
        return replace(declares, notes=(*declares.notes, *silent))

    def __getattr__(self, name: str) -> Any:
        # looked up here, not defined on the class, so that hasattr() tells whether the provider has it
        checked = {
            "frame_summary": "_frame_summary",
            "thickness_in_frame_m": "_thickness_in_frame_m",
            "thickness_around_m": "_thickness_around_m",
        }
        found = super().__getattr__(name)
        return object.__getattribute__(self, checked[name]) if name in checked else found

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x), within [0, the layer's greatest]."""
        return self._thickness("thickness_m", time_s, rows, columns)

    def _frame_summary(self, time_s: float) -> Any:
        """Return what windows need to know of a frame."""
        return self._call("frame_summary", self._provider.frame_summary, time_s)

    def _thickness_in_frame_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return geometric thickness (y, x), checked likewise."""
        return self._thickness("thickness_in_frame_m", time_s, rows, columns, summary)

    def _thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in and around the image, checked likewise."""
        return self._thickness("thickness_around_m", time_s, rows, columns, summary)

    def _thickness(self, method: str, time_s: float, rows: slice, columns: slice, *summary: Any) -> NDArray[np.float32]:
        if method == "thickness_around_m":
            shape = rows.stop - rows.start, columns.stop - columns.start
        else:
            shape = (len(range(*rows.indices(self._grid.rows))), len(range(*columns.indices(self._grid.columns))))
        value = self._call(method, getattr(self._provider, method), time_s, rows, columns, *summary)
        most = self._layer.thickness_max_m * (1.0 + THICKNESS_TOLERANCE)
        return self._array(f"{method}()", value, shape, 0.0, most, np.float32)


class GuardedWaves(_Guard):
    """Waves whose slopes are checked, once per window."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x)."""
        shape = (2, rows.stop - rows.start, columns.stop - columns.start)
        value = self._call("wave_field().slopes", self._provider.slopes, time_s, rows, columns)
        return self._array("wave_field().slopes()", value, shape, dtype=np.float32)


class GuardedSea(_Guard):
    """A sea model whose emissivity and BRDF, and reflection weights and waves if it has them, are checked."""

    def __getattr__(self, name: str) -> Any:
        # looked up here, not defined on the class, so that hasattr() tells whether the provider has it
        checked = {
            "reflection_weights": "_reflection_weights",
            "wave_slope_rms": "_wave_slope_rms",
            "wave_field": "_wave_field",
            "tilted": "_tilted",
        }
        found = super().__getattr__(name)
        return object.__getattribute__(self, checked[name]) if name in checked else found

    def _wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        """Return deviations of slope (upwind, crosswind), not negative."""
        value = self._call("wave_slope_rms", self._provider.wave_slope_rms, pixel_size_m)
        upwind, crosswind = self._array("wave_slope_rms()", value, (2,), 0.0)
        return float(upwind), float(crosswind)

    def _wave_field(self, grid: Grid, motion: Motion, seed: int) -> GuardedWaves:
        """Return waves whose slopes are checked."""
        field = self._call("wave_field", self._provider.wave_field, grid, motion, seed)
        return GuardedWaves(field, self._label)

    def _tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> GuardedSea:
        """Return a tilted part of the sea, checked like the sea."""
        tilted = self._call("tilted", self._provider.tilted, upwind, crosswind, pixel_size_m)
        return GuardedSea(tilted, self._label)

    def _reflection_weights(
        self, wavenumber_cm1: Array, mu: Array, mu_nodes: Array, *arguments: Any, **keywords: Any
    ) -> Array:
        """Return the share of light (M, N, V) from the sky at each node."""
        self._check_wavenumbers("reflection_weights", wavenumber_cm1)
        function = functools.partial(self._provider.reflection_weights, **keywords)
        value = self._call("reflection_weights", function, wavenumber_cm1, mu, mu_nodes, *arguments)
        return self._array("reflection_weights()", value, (mu.size, mu_nodes.size, wavenumber_cm1.size))

    def emissivity(self, wavenumber_cm1: Array, mu: Array, wind_azimuth: Array | None = None) -> Array:
        """Return directional emissivity (M, V) in [0, 1]."""
        self._check_wavenumbers("emissivity", wavenumber_cm1)
        wind = () if wind_azimuth is None else (wind_azimuth,)
        value = self._call("emissivity", self._provider.emissivity, wavenumber_cm1, mu, *wind)
        return self._fraction("emissivity()", value, (mu.size, wavenumber_cm1.size))

    def brdf(
        self,
        wavenumber_cm1: Array,
        mu_out: Array,
        mu_in: Array,
        relative_azimuth: Array,
        wind_azimuth: Array | None = None,
    ) -> Array:
        """Return BRDF (M, V) in sr-1, not negative."""
        self._check_wavenumbers("brdf", wavenumber_cm1)
        wind = () if wind_azimuth is None else (wind_azimuth,)
        arguments = (wavenumber_cm1, mu_out, mu_in, relative_azimuth, *wind)
        value = self._call("brdf", self._provider.brdf, *arguments)
        return self._array("brdf()", value, (mu_out.size, wavenumber_cm1.size), 0.0)


class GuardedOptics(_Guard):
    """An optics provider whose bulk properties are checked."""

    def single_scattering(self, cloud: Microphysics, wavenumber_cm1: Array) -> SingleScattering:
        """Return bulk properties: extinction not negative, albedo in [0, 1], moments in [-1, 1] from 1."""
        self._check_wavenumbers("single_scattering", wavenumber_cm1)
        value = self._call("single_scattering", self._provider.single_scattering, cloud, wavenumber_cm1)
        what = "single_scattering()"
        if not isinstance(value, SingleScattering):
            raise self._refuse(what, "SingleScattering", type(value).__name__)
        size = wavenumber_cm1.size
        moments = np.shape(value.moments)
        if len(moments) != 2 or moments[0] < 2:
            raise self._refuse(f"{what}.moments", f"shape (K, {size}) with K of at least 2", f"shape {moments}")
        within = 1.0 + FRACTION_TOLERANCE
        checked = SingleScattering(
            extinction_m1=self._array(f"{what}.extinction_m1", value.extinction_m1, (size,), 0.0),
            albedo=self._fraction(f"{what}.albedo", value.albedo, (size,)),
            moments=self._array(f"{what}.moments", value.moments, (moments[0], size), -within, within),
        )
        if size and np.abs(checked.moments[0] - 1.0).max() > FRACTION_TOLERANCE:
            raise self._refuse(f"{what}.moments[0]", "1 everywhere", f"{checked.moments[0].min():.9g} and others")
        return checked


class GuardedTransmittance(_Guard):
    """A transmittance provider whose transmittances, and path radiances if it has them, are checked."""

    def __getattr__(self, name: str) -> Any:
        # looked up here, not defined on the class, so that hasattr() tells whether the provider has it
        if name == "path_radiance":
            getattr(self._provider, name)
            return self._path_radiance
        if name == "transmittance_of_amounts":
            getattr(self._provider, name)
            return self._transmittance_of_amounts
        if name == "solar_path_radiance":
            getattr(self._provider, name)
            return self._solar_path_radiance
        return super().__getattr__(name)

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) in [0, 1] of each composite path."""
        self._check_wavenumbers("transmittance", wavenumber_cm1)
        value = self._call("transmittance", self._provider.transmittance, wavenumber_cm1, paths)
        return self._fraction("transmittance()", value, (len(paths), wavenumber_cm1.size))

    def _transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        """Return transmittance (P, V) in [0, 1] behind amounts of absorbers (P, K)."""
        self._check_wavenumbers("transmittance_of_amounts", wavenumber_cm1)
        value = self._call("transmittance_of_amounts", self._provider.transmittance_of_amounts, wavenumber_cm1, amounts)
        return self._fraction("transmittance_of_amounts()", value, (len(amounts), wavenumber_cm1.size))

    def _path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) of single upward legs, W m-2 sr-1 (cm-1)-1, not negative."""
        self._check_wavenumbers("path_radiance", wavenumber_cm1)
        value = self._call("path_radiance", self._provider.path_radiance, wavenumber_cm1, paths)
        return self._array("path_radiance()", value, (len(paths), wavenumber_cm1.size), 0.0)

    def _solar_path_radiance(
        self, wavenumber_cm1: Array, paths: Sequence[Path], *arguments: Any, **keywords: Any
    ) -> Array:
        """Return scattered sunlight (P, V) over the sun's irradiance, sr-1, not negative."""
        self._check_wavenumbers("solar_path_radiance", wavenumber_cm1)
        function = functools.partial(self._provider.solar_path_radiance, **keywords)
        value = self._call("solar_path_radiance", function, wavenumber_cm1, paths, *arguments)
        return self._array("solar_path_radiance()", value, (len(paths), wavenumber_cm1.size), 0.0)


class GuardedRadiance(_Guard):
    """A radiance model whose terms are checked: names, shapes, finiteness; no sun, no solar term."""

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (V,) of a cloud-free column."""
        value = self._call("clear", self._provider.clear, wavenumber_cm1, sun)
        return self._terms("clear()", value, (wavenumber_cm1.size,), sun)

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (N, V) of cloudy columns."""
        value = self._call("cloudy", self._provider.cloudy, wavenumber_cm1, thickness_m, sun)
        return self._terms("cloudy()", value, (thickness_m.shape[0], wavenumber_cm1.size), sun)

    def _terms(self, what: str, value: Any, shape: tuple[int, ...], sun: Sun | None) -> dict[str, Array]:
        names = tuple(self._provider.terms)
        if not isinstance(value, Mapping):
            raise self._refuse(what, f"a mapping of {', '.join(names)}", type(value).__name__)
        if set(value) != set(names):
            raise self._refuse(what, f"the terms {', '.join(names)}", ", ".join(map(str, value)) or "none")
        checked: dict[str, Array] = {
            name: self._array(f"term '{name}' of {what}", value[name], shape) for name in names
        }
        for name in self._provider.solar_terms if sun is None else ():
            if np.any(checked[name]):
                raise self._refuse(f"solar term '{name}' of {what}", "exactly 0 without a sun", "other values")
        return checked


class GuardedSensor(_Guard):
    """A sensor whose measurements are checked: shapes, finiteness, and that it gives what it says it gives."""

    def __init__(self, provider: Any, label: str, inputs: SensorInputs) -> None:
        super().__init__(provider, label)
        self._shape = len(inputs.bands), inputs.grid.rows, inputs.grid.columns

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return radiance (B, y, x) and what else the sensor gives."""
        value = self._call("measure", self._provider.measure, radiance, frame, time_s)
        what, shape = "measure()", self._shape
        if not isinstance(value, Measured):
            raise self._refuse(what, "Measured", type(value).__name__)
        found = {name: getattr(value, name) for name in _MEASURED if getattr(value, name) is not None}
        if set(found) != set(self._provider.variables):
            raise self._refuse(
                what,
                f"radiance and {', '.join(self._provider.variables) or 'nothing else'}",
                ", ".join(found) or "none",
            )
        for name in ("digital_number", "saturated"):
            if name in found and np.asarray(found[name]).dtype.kind not in "iu":
                raise self._refuse(f"{what}.{name}", "whole numbers", f"{np.asarray(found[name]).dtype}")
        return Measured(
            radiance=self._array(f"{what}.radiance", value.radiance, shape),
            **{
                name: self._array(f"{what}.{name}", each, shape, low, high, dtype)
                for name, each in found.items()
                for low, high, dtype in (_MEASURED[name],)
            },
        )


_MEASURED: Mapping[str, tuple[float, float, DTypeLike]] = {
    "photon_rate": (-_INFINITY, _INFINITY, np.float64),
    "digital_number": (0.0, 2.0**31 - 1.0, np.int32),
    "saturated": (0.0, 2.0, np.uint8),
}
"""Lowest and highest value and type of what a sensor may give beside radiance."""


def guard(entry: Entry, provider: Any, inputs: Any) -> Any:
    """Wrap a provider made by ``Registry.create`` from ``entry`` and ``inputs``.

    Returns
    -------
    GuardedClouds, GuardedSea, GuardedOptics, GuardedTransmittance, GuardedRadiance or GuardedSensor
    """
    guarded = _guarded(entry, provider, inputs)
    # our own begin their notes with their names
    return guarded if entry.distribution == OWN_DISTRIBUTION else guarded.named(f"{entry.kind.human} {entry.name}")


def _guarded(entry: Entry, provider: Any, inputs: Any) -> _Guard:
    match entry.kind:
        case Kind.CLOUDS:
            clouds: CloudInputs = inputs
            return GuardedClouds(provider, entry.label, clouds.layer, clouds.grid)
        case Kind.SEA:
            return GuardedSea(provider, entry.label)
        case Kind.OPTICS:
            return GuardedOptics(provider, entry.label)
        case Kind.ATMOSPHERE:
            return GuardedTransmittance(provider, entry.label)
        case Kind.RADIANCE:
            return GuardedRadiance(provider, entry.label)
        case Kind.SENSORS:
            return GuardedSensor(provider, entry.label, inputs)
