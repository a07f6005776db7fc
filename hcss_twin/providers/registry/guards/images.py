"""Checks of images and their pixels: clouds, elements, derived variables, sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hcss_twin import providers as api
from hcss_twin.core.arrays import Array
from hcss_twin.providers.common import FRACTION_TOLERANCE, LAYER_OPTIONS, MEASURED, MEASURED_LIMITS, THICKNESS_TOLERANCE
from hcss_twin.providers.registry.guards.base import ABOVE_ZERO, ANY, POSITIVE, Guard


class GuardedClouds(Guard):
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

    def _checked_height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: Any, edges_m: Any
    ) -> NDArray[np.float32]:
        value = self._call("height_shares", time_s, rows, columns, thickness_m, edges_m)
        shape = len(edges_m) - 1, *np.shape(thickness_m)
        return self._array("height_shares()", value, shape, (0.0, 1.0 + FRACTION_TOLERANCE), np.float32)

    def _checked_cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        ends = getattr(self._provider, "cloud_top_range_m", None) or (self._layer.base_m, self._layer.top_m)
        low, high = np.asarray(ends, np.float32).tolist()
        value = self._call("cloud_top_m", time_s, rows, columns)
        return self._array("cloud_top_m()", value, self._beyond(rows, columns), (low, high), np.float32)

    def _checked_cloud_depth_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        value, most = self._call("cloud_depth_m", time_s, rows, columns), self._layer.thickness_max_m
        limits = float(np.finfo(np.float32).tiny), most * (1.0 + THICKNESS_TOLERANCE)
        return self._array("cloud_depth_m()", value, self._beyond(rows, columns), limits, np.float32)

    def _beyond(self, rows: slice, columns: slice) -> tuple[int, int]:
        """Return the shape of a window, which may leave the image if the generator's sky does."""
        if hasattr(self._provider, "thickness_around_m"):
            return rows.stop - rows.start, columns.stop - columns.start
        return self._inside(rows, columns)

    def _inside(self, rows: slice, columns: slice) -> tuple[int, int]:
        return len(range(*rows.indices(self._grid.rows))), len(range(*columns.indices(self._grid.columns)))

    def _thickness(self, name: str, shape: tuple[int, int], *arguments: Any) -> NDArray[np.float32]:
        value = self._call(name, *arguments)
        most = self._layer.thickness_max_m * (1.0 + THICKNESS_TOLERANCE)
        return self._array(f"{name}()", value, shape, (0.0, most), np.float32)


_COUNTED: Mapping[str, tuple[DTypeLike, str]] = {"digital_number": (np.int32, "iu"), "saturated": (np.uint8, "iu")}
"""Target type and accepted type kinds of what a sensor counts."""


class GuardedSensor(Guard):
    """A sensor whose measurements are checked: shapes, finiteness, and the declared variables."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.SensorInputs) -> None:
        super().__init__(provider, label, speaker)
        self._shape = len(inputs.bands), inputs.grid.rows, inputs.grid.columns
        self._dtype: type[np.floating[Any]] = np.float32 if getattr(provider, "single_precision", False) else np.float64

    def measure(self, radiance: Array, frame: int, time_s: float) -> api.Measured:
        return self._measured("measure", radiance, frame, time_s)

    def _checked_measure_with(self, radiance: Array, points: api.Points, frame: int, time_s: float) -> api.Measured:
        return self._measured("measure_with", radiance, points, frame, time_s)

    def _checked_points_after(self, points: api.Points) -> api.Points:
        value = self._call("points_after", points)
        if not isinstance(value, api.Points):
            raise self._refuse("points_after()", "Points", type(value).__name__)
        count = np.shape(value.row)
        positions = {
            name: self._array(f"points_after().{name}", getattr(value, name), count)
            for name in ("row", "column", "row_rate", "column_rate")
        }
        light = self._array("points_after().radiance", value.radiance, (self._shape[0], *count))
        return api.Points(**positions, radiance=light)

    def _measured(self, name: str, *arguments: Any) -> api.Measured:
        value = self._call(name, *arguments)
        what, declared = f"{name}()", self._read("variables")
        if not isinstance(value, api.Measured):
            raise self._refuse(what, "Measured", type(value).__name__)
        given = {name: getattr(value, name) for name in MEASURED if getattr(value, name) is not None}
        if set(given) != set(declared):
            raise self._refuse(
                what, f"radiance and {', '.join(declared) or 'nothing else'}", ", ".join(given) or "none"
            )
        most = float(np.finfo(self._dtype).max)
        real = (-most, most), self._dtype, "fiu"
        checks = {name: real if name == "photon_rate" else (MEASURED_LIMITS[name], *_COUNTED[name]) for name in given}
        return api.Measured(
            self._array(f"{what}.radiance", value.radiance, self._shape, *real),
            **{
                name: self._array(f"{what}.{name}", values, self._shape, *checks[name])
                for name, values in given.items()
            },
        )


class GuardedElements(Guard):
    """An element provider whose pixels are checked, once per window."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.ElementInputs) -> None:
        super().__init__(provider, label, speaker)
        self._bands = len(inputs.bands)

    def pixels(
        self, time_s: float, rows: slice, columns: slice, scene: api.ElementScene
    ) -> tuple[api.ElementPixels | api.ElementPoint, ...]:
        value, kinds = self._call("pixels", time_s, rows, columns, scene), (api.ElementPixels, api.ElementPoint)
        if not isinstance(value, Sequence) or not all(isinstance(element, kinds) for element in value):
            raise self._refuse("pixels()", "a sequence of ElementPixels and ElementPoint", type(value).__name__)
        return tuple(
            self._checked_point(element)
            if isinstance(element, api.ElementPoint)
            else self._checked(element, rows, columns)
            for element in value
        )

    def _checked_point(self, given: api.ElementPoint) -> api.ElementPoint:
        self._check_kind(given)
        if (given.radiance is None) != (given.area_m2 is None):
            raise self._refuse("pixels()", "area_m2 with radiance", "one of them")
        limits = {
            "x_m": ANY,
            "y_m": ANY,
            "altitude_m": POSITIVE,
            "area_m2": ABOVE_ZERO,
            "reflectance": (0.0, 1.0),
            "side_m": POSITIVE,
            "temperature_K": ABOVE_ZERO,
        }
        checked: dict[str, Any] = {
            name: float(self._array(f"pixels().{name}", value, (), limit))
            for name, limit in limits.items()
            if (value := getattr(given, name)) is not None
        }
        checked["velocity_m_s"] = tuple(self._array("pixels().velocity_m_s", given.velocity_m_s, (3,)).tolist())
        truth = {
            name: float(self._array(f"pixels().truth['{name}']", values, ())) for name, values in given.truth.items()
        }
        return replace(given, **checked | self._strength(given, (self._bands,)), truth=truth)

    def _check_kind(self, given: api.ElementPixels | api.ElementPoint) -> None:
        if (given.radiance is None) == (given.intensity is None):
            raise self._refuse("pixels()", "either radiance or intensity", "both or neither")
        if set(given.truth) != set(self._provider.variables):
            raise self._refuse(
                "pixels().truth", ", ".join(self._provider.variables) or "nothing", ", ".join(given.truth)
            )

    def _strength(self, given: api.ElementPixels | api.ElementPoint, shape: tuple[int, ...]) -> dict[str, Array]:
        """Return the checked radiance, of this shape, or intensity."""
        if given.radiance is not None:
            return {"radiance": self._array("pixels().radiance", given.radiance, shape, POSITIVE)}
        return {"intensity": self._array("pixels().intensity", given.intensity, (self._bands,), POSITIVE)}

    def _checked(self, given: api.ElementPixels, rows: slice, columns: slice) -> api.ElementPixels:
        what, count = "pixels()", (np.size(given.rows),)
        y, x = (
            self._array(f"{what}.{name}", values, count, (window.start, window.stop - 1), np.intp, "iu")
            for name, values, window in (("rows", given.rows, rows), ("columns", given.columns, columns))
        )
        if len(set(zip(y.tolist(), x.tolist(), strict=True))) < y.size:
            raise self._refuse(what, "distinct pixels", "a pixel twice")
        self._check_kind(given)
        shape = (*count, self._bands) if given.radiance is not None and np.ndim(given.radiance) == 2 else (self._bands,)
        kelvin = given.temperature_K
        if kelvin is not None:
            kelvin = float(self._array(f"{what}.temperature_K", kelvin, (), ABOVE_ZERO))
        return api.ElementPixels(
            y,
            x,
            self._array(f"{what}.share", given.share, count, (ABOVE_ZERO[0], 1.0 + FRACTION_TOLERANCE)),
            float(self._array(f"{what}.altitude_m", given.altitude_m, (), POSITIVE)),
            **self._strength(given, shape),
            temperature_K=kelvin,
            truth={name: self._array(f"{what}.truth['{name}']", values, count) for name, values in given.truth.items()},
        )


class GuardedVariables(Guard):
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
