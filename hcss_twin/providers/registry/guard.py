"""Checks of provider results before the engine uses them.

Without them an error in a plugin would cause wrong radiance, or an exception far from its cause. Each wrapper has the
methods of its Protocol. A result of another shape, of a type that is no real number, not finite or out of range, and
any exception that is not deliberate (``HcssError``), becomes a ProviderDefect that names provider, distribution, method
and arguments; deliberate errors of plugins get these names, too. Values are converted to the contract's dtype; rounding
errors at the limits of optical properties are removed. All other attributes are delegated to the provider.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hcss_twin import providers as api
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, HcssError, ProviderDefect, ProviderError
from hcss_twin.core.plugins import FAILURES, OWN_DISTRIBUTION, describe
from hcss_twin.physics.paths import Path
from hcss_twin.providers.common import (
    FRACTION_TOLERANCE,
    KELVIN_TOLERANCE,
    LAYER_OPTIONS,
    MEASURED_LIMITS,
    THICKNESS_TOLERANCE,
)
from hcss_twin.providers.declarations import attributed
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.specs import Kind

_ANY = (-float("inf"), float("inf"))
_POSITIVE = (0.0, float("inf"))
_ABOVE_ZERO = (float(np.nextafter(0.0, 1.0)), float("inf"))
_FRACTION = (-FRACTION_TOLERANCE, 1.0 + FRACTION_TOLERANCE)


def _shown(value: Any) -> str:
    """Describe an argument: shapes of arrays, types of objects, numbers as they are."""
    if isinstance(value, np.ndarray):
        return f"of shape {value.shape}"
    if value is None or isinstance(value, int | float | str | slice):
        return f"= {value!r}"
    if isinstance(value, Mapping):
        return f"with {', '.join(f'{name} {_shown(each)}' for name, each in value.items())}"
    if isinstance(value, Sequence):
        return f"of length {len(value)}"
    return f"a {type(value).__name__}"


def _telling(method: Callable[..., Any]) -> Callable[..., Any]:
    """Add the provider, its member and the arguments to errors of a guarded method."""
    signature, member = inspect.signature(method), method.__name__.removeprefix("_checked_")

    @functools.wraps(method)
    def told(self: _Guard, *arguments: Any, **keywords: Any) -> Any:
        try:
            return method(self, *arguments, **keywords)
        except HcssError as error:
            if error.provider:  # of this provider, or of another one that it uses
                raise
            if type(error) not in (ProviderDefect, ProviderError, CatalogError) or (
                self._own and not isinstance(error, ProviderDefect)
            ):
                error.provider = self._label
                raise
            values = list(signature.bind(self, *arguments, **keywords).arguments.items())[1:]
            given = ", ".join(f"{name} {_shown(value)}" for name, value in values) or "none"
            text = str(error) if isinstance(error, ProviderDefect) else f"{self._label}: {member}(): {error}"
            named = type(error)(f"{text}; arguments: {given}")
            named.provider = self._label
            raise named from (error.__cause__ or error)

    return told


class _Guard:
    """Guarded calls and array checks common to the wrappers of all kinds.

    A method ``_checked_NAME`` replaces the optional method ``NAME`` of the provider. Errors begin with ``label``, and
    notes of the declaration with ``speaker``, unless that is empty.
    """

    def __init__(self, provider: Any, label: str, speaker: str = "") -> None:
        self._provider, self._label, self._speaker = provider, label, speaker
        self._called: set[str] = set()

    def __init_subclass__(cls) -> None:
        for name, member in list(vars(cls).items()):
            if inspect.isfunction(member) and (not name.startswith("_") or name.startswith("_checked_")):
                setattr(cls, name, _telling(member))

    @property
    def _own(self) -> bool:
        """Whether the provider is of this package: its messages already say whose they are."""
        return not self._speaker

    @property
    def declares(self) -> Any:
        declares: api.Declaration = self._read("declares")
        return attributed(declares, self._speaker) if self._speaker else declares

    def _checked_model_errors(self) -> tuple[api.ModelError, ...]:
        errors = tuple(self._call("model_errors"))
        for each in errors:
            if not isinstance(each, api.ModelError):
                raise self._refuse("model_errors()", "a sequence of ModelError", f"a {type(each).__name__} in it")
        return errors

    def __getattr__(self, name: str) -> Any:
        # copying and unpickling look up attributes before there is a provider
        if name.startswith("__") or name in ("_provider", "_label", "_speaker", "_called"):
            raise AttributeError(name)
        # first, so that hasattr() reflects whether the provider has an optional method
        provided = self._read(name)
        checked = f"_checked_{name}"
        return object.__getattribute__(self, checked) if hasattr(type(self), checked) else provided

    def _read(self, name: str) -> Any:
        try:
            return getattr(self._provider, name)
        except (AttributeError, HcssError):
            raise
        except FAILURES as error:
            raise ProviderDefect(f"{self._label}: reading {name} raised {describe(error)}") from error

    def _call(self, name: str, *arguments: Any, **keywords: Any) -> Any:
        self._called.add(name)
        try:
            return getattr(self._provider, name)(*arguments, **keywords)
        except HcssError:
            raise
        except FAILURES as error:
            raise ProviderDefect(f"{self._label}: {name}() raised {describe(error)}") from error

    def _refuse(self, what: str, expected: str, got: str) -> ProviderDefect:
        return ProviderDefect(f"{self._label}: {what} broke its contract: expected {expected}, got {got}")

    def _array(
        self,
        what: str,
        value: Any,
        shape: tuple[int, ...],
        limits: tuple[float, float] = _ANY,
        dtype: DTypeLike = np.float64,
        kinds: str = "fiu",
    ) -> NDArray[Any]:
        """Return ``value`` as an array of ``dtype`` after checking shape, type, finiteness and range."""
        if isinstance(value, np.ma.MaskedArray):
            raise self._refuse(what, f"a plain array of shape {shape}", "a masked array")
        try:
            array = np.asarray(value)
        except FAILURES as error:
            raise self._refuse(what, f"an array of shape {shape}", describe(error)) from error
        if array.dtype.kind not in kinds:
            numbers = "real" if "f" in kinds else "whole"
            raise self._refuse(what, f"{numbers} numbers of shape {shape}", f"{type(value).__name__} of {array.dtype}")
        if array.shape != shape:
            raise self._refuse(what, f"shape {shape}", f"shape {array.shape}")
        if array.size:
            # minimum and maximum propagate NaN and infinity: two passes and no temporary array
            least, most = float(array.min()), float(array.max())
            if not (np.isfinite(least) and np.isfinite(most)):
                bad = int(np.count_nonzero(~np.isfinite(array)))
                raise self._refuse(what, "finite values", f"{bad} of {array.size} not finite")
            if least < limits[0] or most > limits[1]:
                raise self._refuse(what, f"values in [{limits[0]:g}, {limits[1]:g}]", f"{least:.9g} to {most:.9g}")
        return array.astype(dtype, copy=False)

    def _spectral(
        self,
        name: str,
        shape: tuple[int, ...],
        limits: tuple[float, float],
        wavenumber_cm1: Array,
        *arguments: Any,
        **keywords: Any,
    ) -> Array:
        """Call a method inside its declared spectral range and check its result (*shape, V)."""
        self._check_wavenumbers(name, wavenumber_cm1)
        value = self._call(name, wavenumber_cm1, *arguments, **keywords)
        return self._array(f"{name}()", value, (*shape, wavenumber_cm1.size), limits)

    def _check_wavenumbers(self, name: str, wavenumber_cm1: Array) -> None:
        """Reject wavenumbers outside the declared range: results are never extrapolated."""
        valid = self._provider.declares.valid.get("wavenumber_cm1")
        if valid is None or wavenumber_cm1.size == 0:
            return
        lowest, highest = float(wavenumber_cm1.min()), float(wavenumber_cm1.max())
        if lowest < valid[0] or highest > valid[1]:
            raise ProviderError(
                f"{self._label}: {name}() was asked for {lowest:.6g} to {highest:.6g} cm-1; "
                f"valid are {valid[0]:.6g} to {valid[1]:.6g} cm-1"
            )


class _Clouds(_Guard):
    """A cloud generator whose fields are checked, once per window."""

    def __init__(self, provider: Any, label: str, speaker: str, layer: api.CloudLayer, grid: api.Grid) -> None:
        super().__init__(provider, label, speaker)
        self._layer, self._grid = layer, grid

    @property
    def declares(self) -> api.CloudDeclaration:
        """The declaration, with a note for each key of the layer that the generator may ignore."""
        declares: api.CloudDeclaration = super().declares
        if not self._speaker:
            return declares
        honoured = getattr(self._provider, "honours", ())
        values = {name: getattr(self._layer, name) for name in LAYER_OPTIONS if name not in honoured}
        ignored = tuple(
            f"{self._speaker}: does not say that it honours {name} = {value!r}, which may have no influence"
            for name, value in values.items()
            if value != getattr(api.CloudLayer, name)  # the default
        )
        return replace(declares, notes=(*declares.notes, *ignored))

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        return self._thickness("thickness_m", self._inside(rows, columns), time_s, rows, columns)

    def _checked_frame_summary(self, time_s: float) -> Any:
        return self._call("frame_summary", time_s)

    def _checked_thickness_in_frame_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> Any:
        return self._thickness("thickness_in_frame_m", self._inside(rows, columns), time_s, rows, columns, summary)

    def _checked_thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: Any) -> Any:
        shape = rows.stop - rows.start, columns.stop - columns.start
        return self._thickness("thickness_around_m", shape, time_s, rows, columns, summary)

    def _inside(self, rows: slice, columns: slice) -> tuple[int, int]:
        return len(range(*rows.indices(self._grid.rows))), len(range(*columns.indices(self._grid.columns)))

    def _thickness(self, name: str, shape: tuple[int, int], *arguments: Any) -> NDArray[np.float32]:
        value = self._call(name, *arguments)
        most = self._layer.thickness_max_m * (1.0 + THICKNESS_TOLERANCE)
        return self._array(f"{name}()", value, shape, (0.0, most), np.float32)


class _Waves(_Guard):
    """Waves whose slopes are checked, once per window."""

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        shape = (2, rows.stop - rows.start, columns.stop - columns.start)
        return self._array(
            "wave_field().slopes()", self._call("slopes", time_s, rows, columns), shape, dtype=np.float32
        )


class _Sea(_Guard):
    """A sea model whose emissivity and BRDF, and reflection weights and waves if it has them, are checked."""

    def emissivity(self, wavenumber_cm1: Array, mu: Array, wind_azimuth: Array | None = None) -> Array:
        wind = () if wind_azimuth is None else (wind_azimuth,)
        return self._spectral("emissivity", mu.shape, _FRACTION, wavenumber_cm1, mu, *wind)

    def brdf(
        self,
        wavenumber_cm1: Array,
        mu_out: Array,
        mu_in: Array,
        relative_azimuth: Array,
        wind_azimuth: Array | None = None,
    ) -> Array:
        directions = (mu_out, mu_in, relative_azimuth, *(() if wind_azimuth is None else (wind_azimuth,)))
        return self._spectral("brdf", mu_out.shape, _POSITIVE, wavenumber_cm1, *directions)

    def _checked_reflection_weights(
        self, wavenumber_cm1: Array, mu: Array, mu_nodes: Array, *arguments: Any, **keywords: Any
    ) -> Array:
        shape = mu.size, mu_nodes.size
        return self._spectral("reflection_weights", shape, _ANY, wavenumber_cm1, mu, mu_nodes, *arguments, **keywords)

    def _checked_wave_slope_rms(self, pixel_size_m: float) -> tuple[float, float]:
        rms = self._array("wave_slope_rms()", self._call("wave_slope_rms", pixel_size_m), (2,), _POSITIVE)
        return float(rms[0]), float(rms[1])

    def _checked_wave_field(self, grid: api.Grid, motion: api.Motion, seed: int) -> _Waves:
        return _Waves(self._call("wave_field", grid, motion, seed), self._label, self._speaker)

    def _checked_tilted(self, upwind: float, crosswind: float, pixel_size_m: float) -> _Sea:
        return _Sea(self._call("tilted", upwind, crosswind, pixel_size_m), self._label, self._speaker)


class _Optics(_Guard):
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
        extinction = self._array(f"{what}.extinction_m1", value.extinction_m1, (size,), _POSITIVE)
        albedo = np.clip(self._array(f"{what}.albedo", value.albedo, (size,), _FRACTION), 0.0, 1.0)
        moments = self._array(f"{what}.moments", value.moments, (shape[0], size))
        wrong = (np.abs(moments[0] - 1.0) > FRACTION_TOLERANCE) | np.any(np.abs(moments[1:]) >= 1.0, axis=0)
        if np.any(wrong):
            got = ", ".join(f"{moment:.9g}" for moment in moments[:3, np.argmax(wrong)])
            raise self._refuse(f"{what}.moments", "moments[0] = 1 and the others above -1 and below 1", f"{got}, ...")
        if np.any(moments[0] != 1.0):
            moments = np.concatenate((np.ones((1, size)), moments[1:]))
        return api.SingleScattering(extinction, albedo, moments)


class _Transmittance(_Guard):
    """A transmittance provider whose transmittances, and path radiances if it has them, are checked."""

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        return self._spectral("transmittance", (len(paths),), _FRACTION, wavenumber_cm1, paths)

    def _checked_absorber_amounts(self, paths: Sequence[Path]) -> Array:
        value = self._call("absorber_amounts", paths)
        shape = np.shape(value)
        return self._array("absorber_amounts()", value, (len(paths), *shape[1:2]))

    def _checked_transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        return self._spectral("transmittance_of_amounts", (len(amounts),), _FRACTION, wavenumber_cm1, amounts)

    def _checked_path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        return self._spectral("path_radiance", (len(paths),), _POSITIVE, wavenumber_cm1, paths)

    def _checked_solar_path_radiance(
        self, wavenumber_cm1: Array, paths: Sequence[Path], *arguments: Any, **keywords: Any
    ) -> Array:
        shape = (len(paths),)
        return self._spectral("solar_path_radiance", shape, _POSITIVE, wavenumber_cm1, paths, *arguments, **keywords)


class _Radiance(_Guard):
    """A radiance model whose terms are checked: names, shapes, finiteness; no sun, no solar term."""

    def clear(self, wavenumber_cm1: Array, sun: api.Sun | None) -> Mapping[str, Array]:
        value = self._call("clear", wavenumber_cm1, sun)
        return self._terms("clear()", value, (wavenumber_cm1.size,), sun)

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: api.Sun | None) -> Mapping[str, Array]:
        value = self._call("cloudy", wavenumber_cm1, thickness_m, sun)
        return self._terms("cloudy()", value, (thickness_m.shape[0], wavenumber_cm1.size), sun)

    def _terms(self, what: str, value: Any, shape: tuple[int, ...], sun: api.Sun | None) -> dict[str, Array]:
        names = tuple(self._read("terms"))
        if not isinstance(value, Mapping) or set(value) != set(names):
            got = (", ".join(map(str, value)) or "none") if isinstance(value, Mapping) else type(value).__name__
            raise self._refuse(what, f"a mapping with the terms {', '.join(names)}", got)
        terms: dict[str, Array] = {name: self._array(f"term '{name}' of {what}", value[name], shape) for name in names}
        for name in self._read("solar_terms") if sun is None else ():
            if np.any(terms[name]):
                raise self._refuse(f"solar term '{name}' of {what}", "exactly 0 without a sun", "other values")
        return terms


_MEASURED: Mapping[str, tuple[DTypeLike, str]] = {
    "photon_rate": (np.float64, "fiu"),
    "digital_number": (np.int32, "iu"),
    "saturated": (np.uint8, "iu"),
}
"""Target type and accepted type kinds of a sensor's further variables."""


class _Sensor(_Guard):
    """A sensor whose measurements are checked: shapes, finiteness, and the declared variables."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.SensorInputs) -> None:
        super().__init__(provider, label, speaker)
        self._shape = len(inputs.bands), inputs.grid.rows, inputs.grid.columns

    def measure(self, radiance: Array, frame: int, time_s: float) -> api.Measured:
        value = self._call("measure", radiance, frame, time_s)
        what, declared = "measure()", self._read("variables")
        if not isinstance(value, api.Measured):
            raise self._refuse(what, "Measured", type(value).__name__)
        given = {name: getattr(value, name) for name in _MEASURED if getattr(value, name) is not None}
        if set(given) != set(declared):
            raise self._refuse(
                what, f"radiance and {', '.join(declared) or 'nothing else'}", ", ".join(given) or "none"
            )
        return api.Measured(
            self._array(f"{what}.radiance", value.radiance, self._shape),
            **{
                name: self._array(f"{what}.{name}", each, self._shape, MEASURED_LIMITS[name], *_MEASURED[name])
                for name, each in given.items()
            },
        )


class _Elements(_Guard):
    """An element provider whose pixels are checked, once per window."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.ElementInputs) -> None:
        super().__init__(provider, label, speaker)
        self._bands = len(inputs.bands)

    def pixels(
        self, time_s: float, rows: slice, columns: slice, scene: api.ElementScene
    ) -> tuple[api.ElementPixels, ...]:
        value = self._call("pixels", time_s, rows, columns, scene)
        if not isinstance(value, Sequence) or not all(isinstance(each, api.ElementPixels) for each in value):
            raise self._refuse("pixels()", "a sequence of ElementPixels", type(value).__name__)
        return tuple(self._checked(each, rows, columns) for each in value)

    def _checked(self, given: api.ElementPixels, rows: slice, columns: slice) -> api.ElementPixels:
        what, count = "pixels()", (np.size(given.rows),)
        y, x = (
            self._array(f"{what}.{name}", values, count, (window.start, window.stop - 1), np.intp, "iu")
            for name, values, window in (("rows", given.rows, rows), ("columns", given.columns, columns))
        )
        if len(set(zip(y.tolist(), x.tolist(), strict=True))) < y.size:
            raise self._refuse(what, "distinct pixels", "a pixel twice")
        if (given.radiance is None) == (given.intensity is None):
            raise self._refuse(what, "either radiance or intensity", "both or neither")
        if set(given.truth) != set(self._provider.variables):
            raise self._refuse(
                f"{what}.truth", ", ".join(self._provider.variables) or "nothing", ", ".join(given.truth)
            )
        radiance = given.radiance
        if radiance is not None:
            shape = (*count, self._bands) if np.ndim(radiance) == 2 else (self._bands,)
            radiance = self._array(f"{what}.radiance", radiance, shape, _POSITIVE)
        intensity = given.intensity
        if intensity is not None:
            intensity = self._array(f"{what}.intensity", intensity, (self._bands,), _POSITIVE)
        kelvin = given.temperature_K
        if kelvin is not None:
            kelvin = float(self._array(f"{what}.temperature_K", kelvin, (), _ABOVE_ZERO))
        return api.ElementPixels(
            y,
            x,
            self._array(f"{what}.share", given.share, count, (_ABOVE_ZERO[0], 1.0 + FRACTION_TOLERANCE)),
            float(self._array(f"{what}.altitude_m", given.altitude_m, (), _POSITIVE)),
            radiance,
            intensity,
            kelvin,
            {name: self._array(f"{what}.truth['{name}']", each, count) for name, each in given.truth.items()},
        )


class _Variables(_Guard):
    """A variable provider whose values are checked, once per part: names, shapes, types, limits."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.VariableInputs) -> None:
        super().__init__(provider, label, speaker)
        self._bands = len(inputs.bands)

    def values(self, fields: Mapping[str, NDArray[Any]], time_s: float) -> dict[str, NDArray[Any]]:
        value = self._call("values", fields, time_s)
        declared: Mapping[str, api.OutputVariable] = self._read("variables")
        if not isinstance(value, Mapping) or set(value) != set(declared):
            got = ", ".join(map(str, value)) or "none" if isinstance(value, Mapping) else type(value).__name__
            raise self._refuse("values()", f"a mapping with the variables {', '.join(declared)}", got)
        shape = next(iter(fields.values())).shape[-2:]
        return {name: self._checked(name, value[name], about, shape) for name, about in declared.items()}

    def _checked(self, name: str, value: Any, about: api.OutputVariable, shape: tuple[int, ...]) -> NDArray[Any]:
        what, shape = f"'{name}' of values()", (self._bands, *shape) if about.per_band else shape
        kinds = "fiu" if about.dtype.startswith("float") else "iub"
        missing = None
        if about.may_be_missing and type(value) is np.ndarray and value.dtype.kind == "f":
            missing = np.isnan(value)
            value = np.where(missing, about.limits[0], value)
        array = self._array(what, value, shape, about.limits, about.dtype, kinds)
        return array if missing is None else np.where(missing, array.dtype.type(np.nan), array)


class _Surfaces(_Guard):
    """A surface provider whose maps are checked, once per window."""

    @functools.cached_property
    def classes(self) -> tuple[api.SurfaceClass, ...]:
        return tuple(
            each
            if each.boundary is None
            else replace(each, boundary=_Sea(each.boundary, f"{self._label}, class '{each.name}'", self._speaker))
            for each in self._read("classes")
        )

    def surface(self, time_s: float, rows: slice, columns: slice) -> api.SurfaceMap:
        value = self._call("surface", time_s, rows, columns)
        what, shape = "surface()", (rows.stop - rows.start, columns.stop - columns.start)
        if not isinstance(value, api.SurfaceMap):
            raise self._refuse(what, "SurfaceMap", type(value).__name__)
        classes = self.classes
        number = self._array(f"{what}.number", value.number, shape, (0, len(classes) - 1), np.uint8, "iu")
        fields = {n: each for n, each in enumerate(classes) if isinstance(each.temperature_K, tuple)}
        if not fields:
            return api.SurfaceMap(number)
        kelvin = np.asarray(value.temperature_K)
        if kelvin.shape != shape or kelvin.dtype.kind != "f":
            raise self._refuse(f"{what}.temperature_K", f"real numbers of shape {shape}", f"shape {kelvin.shape}")
        for n, each in fields.items():
            here = kelvin[number == n]
            low, high = each.temperature_K  # type: ignore[misc]
            limits = low - KELVIN_TOLERANCE, high + KELVIN_TOLERANCE
            self._array(f"{what}.temperature_K of class '{each.name}'", here, here.shape, limits)
            kelvin = np.where(number == n, np.clip(kelvin, low, high), kelvin)
        return api.SurfaceMap(number, kelvin.astype(np.float64, copy=False))


def was_called(guarded: Any, name: str) -> bool:
    """Whether a checked member of a provider made by :func:`guard` has been called."""
    return name in guarded._called


def guard(entry: Entry, provider: Any, inputs: Any) -> Any:
    """Wrap a provider made by ``Registry.create`` from ``entry`` and ``inputs`` in the wrapper of its kind."""
    # notes of this package's providers already begin with their names
    speaker = "" if entry.distribution == OWN_DISTRIBUTION else f"{entry.kind.human} {entry.name}"
    if entry.kind is Kind.CLOUDS:
        return _Clouds(provider, entry.label, speaker, inputs.layer, inputs.grid)
    if entry.kind is Kind.SENSORS:
        return _Sensor(provider, entry.label, speaker, inputs)
    if entry.kind is Kind.ELEMENTS:
        return _Elements(provider, entry.label, speaker, inputs)
    if entry.kind is Kind.VARIABLES:
        return _Variables(provider, entry.label, speaker, inputs)
    others = {
        Kind.SEA: _Sea,
        Kind.OPTICS: _Optics,
        Kind.ATMOSPHERE: _Transmittance,
        Kind.RADIANCE: _Radiance,
        Kind.SURFACES: _Surfaces,
    }
    return others[entry.kind](provider, entry.label, speaker)
