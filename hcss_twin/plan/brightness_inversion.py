"""Thickness of a cloud layer from its brightness temperature in a window of the infrared, in the scene itself.

Images show brightness temperature. With the radiance model of the scene, each value is the thickness of a cloud that
looks like it from where the scene is seen: thin cloud stays thin, and no threshold decides what is cloud.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.kernels import kernel
from hcss_twin.physics.planck import planck
from hcss_twin.providers import ColumnSetting, RadianceModel, cloudy_columns

LIMITS_UM = (10.3, 11.3)
"""Limits of the band, AVHRR channel 4, with equal response in wavenumber."""

WAVENUMBERS, STEP_CM1 = 16, 5.4
"""Least number, and width, of the intervals of a band: at 10.8 um within .01 K of the fine grid."""

LEVEL = 2
"""Numerical level, whatever the accuracy: clouds must not depend on it."""

COLDER_K = 0.1
"""Least difference between clear and cloudy sky."""

_THICKNESSES = 49

_HANGING = 25
"""Thicknesses at each altitude of the top, of which there are many."""

_TEMPERATURES = 4096


class LayerBrightness:
    """Brightness temperature in a band against the thickness of one layer, the others clear, and its inverse.

    Parameters
    ----------
    model_at : callable
        Returns the scene's radiance model at a numerical level, with sunlight some levels finer; called at first use.
    setting : ColumnSetting
        Of the scene, at night.
    index : int
        Of the layer.
    limits_um : (float, float)
        Of the band.
    """

    def __init__(
        self, model_at: Callable[[int, int], RadianceModel], setting: ColumnSetting, index: int,
        limits_um: tuple[float, float] = LIMITS_UM,
    ) -> None:  # fmt: skip
        self._model_at, self._setting, self._index = model_at, setting, index
        self._profile, self._layers = setting.profile, setting.layers
        self._limits_um = limits_um

    def in_band(self, limits_um: tuple[float, float]) -> LayerBrightness:
        """Return the inversion in another band, as :class:`hcss_twin.providers.BrightnessInversion` describes."""
        return LayerBrightness(self._model_at, self._setting, self._index, limits_um)

    @property
    def clear_K(self) -> float:
        """Brightness temperature of the clear sky."""
        return float(self._curve[1][0])

    @property
    def coldest_K(self) -> float:
        """Lowest brightness temperature that the layer can have."""
        return float(self._curve[1][-1])

    def air_temperature_K(self, altitude_m: Array) -> Array:
        """Return the temperature of the air at any altitudes, beyond the profile that of its ends."""
        inside = np.clip(altitude_m, self._profile.altitude_m[0], self._profile.altitude_m[-1])
        return self._profile.temperature_at(inside)

    def thickness_m(self, brightness_temperature_K: Array) -> NDArray[np.float32]:
        """Return the thickness, as :class:`hcss_twin.providers.BrightnessInversion` describes.

        Raises
        ------
        ProviderError
            If clouds of the layer are not colder than the clear sky.
        """
        given = np.asarray(brightness_temperature_K, dtype=np.float64)
        result = np.empty(given.shape, np.float32)
        table, warmest = self._inverse
        layer, step = self._layers[self._index], (self.clear_K - self.coldest_K) / (table.size - 1)
        _look_up(
            np.ascontiguousarray(given).reshape(-1),
            self.clear_K,
            1.0 / step,
            warmest,
            np.float32(layer.thickness_min_m),
            table,
            result.reshape(-1),
        )
        return result

    def hanging_K(self, top_m: float) -> tuple[Array, Array]:
        """Return thicknesses and brightness temperatures of clouds that hang from an altitude."""
        layers = tuple(
            layer.hanging_from(top_m) if index == self._index else layer for index, layer in enumerate(self._layers)
        )
        return self._curve_of(self._model_at(0, 0), replace(self._setting, layers=layers), _HANGING)

    @cached_property
    def _curve(self) -> tuple[Array, Array]:
        """Thickness from 0 on, and brightness temperature, which never rises with it."""
        layer = self._layers[self._index]
        model = self._model_at(min(LEVEL, self._model_at(0, 0).declares.numerical_levels - 1), 0)
        thickness, temperature = self._curve_of(model, self._setting, _THICKNESSES)
        if not temperature[1:].min() < temperature[0] - COLDER_K:
            low, high = self._limits_um
            raise ProviderError(
                f"clouds of '{layer.name}' are not colder than clear sky at {low:g} to {high:g} um "
                f"({temperature[1:].min():.5g} K and {temperature[0]:.5g} K), so that brightness temperature does not "
                "tell their thickness; allowed: a higher layer, a thicker one, or a method that needs no temperature"
            )
        return thickness, np.minimum.accumulate(temperature)

    def _curve_of(self, model: RadianceModel, setting: ColumnSetting, count: int) -> tuple[Array, Array]:
        layer = setting.layers[self._index]
        edges = 1e4 / np.array(self._limits_um)[::-1]
        intervals = max(WAVENUMBERS, round((edges[1] - edges[0]) / STEP_CM1))
        step = (edges[1] - edges[0]) / intervals
        wavenumber = edges[0] + step * (np.arange(intervals) + 0.5)
        thinnest = max(layer.thickness_min_m, 1e-4 * layer.thickness_max_m)
        thickness = np.geomspace(thinnest, layer.thickness_max_m, count)
        thickness[-1] = layer.thickness_max_m
        columns = np.zeros((1 + thickness.size, len(setting.layers)))
        columns[1:, self._index] = thickness
        total: Array = np.sum(list(cloudy_columns(model, setting, wavenumber, columns).values()), axis=0)
        radiance: Array = np.mean(total, axis=1)
        kelvin = np.linspace(100.0, 400.0, 3001)
        black_body = np.mean(planck(wavenumber, kelvin[:, None]), axis=1)
        temperature: Array = np.interp(np.log(radiance), np.log(black_body), kelvin)
        return np.concatenate(([0.0], thickness)), temperature

    @cached_property
    def _inverse(self) -> tuple[NDArray[np.float32], float]:
        """Thickness at even temperatures from clear sky down, and the temperature below which there is cloud."""
        from scipy.interpolate import PchipInterpolator  # not for scenes that need no inversion

        thickness, temperature = self._curve
        falls = np.concatenate(([True], np.diff(temperature) < 0.0))
        even = np.linspace(temperature[0], temperature[-1], _TEMPERATURES)
        curve = PchipInterpolator(-temperature[falls], thickness[falls])
        layer = self._layers[self._index]
        table = np.clip(curve(-even), 0.0, layer.thickness_max_m).astype(np.float32)
        table = np.where(table > layer.thickness_max_m, np.nextafter(table, np.float32(0.0)), table)
        return table, float(0.5 * (temperature[0] + np.interp(layer.thickness_min_m, thickness, temperature)))


@kernel()
def _look_up(
    kelvin: Any, clear: float, per_kelvin: float, warmest: float, thinnest: Any, table: Any, result: Any
) -> None:
    last = table.size - 1
    for i in range(kelvin.size):
        if not kelvin[i] < warmest:
            result[i] = np.float32(0.0)
            continue
        position = min((clear - kelvin[i]) * per_kelvin, float(last))
        low = min(int(position), last - 1)
        share = np.float32(position - low)
        metres = table[low] + (table[low + 1] - table[low]) * share
        result[i] = max(metres, thinnest)
