"""Smoke whose optical depth varies over the image: an effect of points, and a model for your own."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin import Scenario
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import (
    Array,
    Catalog,
    ColumnSetting,
    Path,
    PointEffect,
    SectionSpec,
    hookimpl,
    planck,
    to_space,
)


class Smoke(BaseModel):
    """Section ``[smoke]``, and its effect: a ridge through the centre of the scene, which does not move."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    optical_depth: float = Field(0.5, gt=0, le=5, description="Absorption optical depth of the thickest column, 1 um.")
    width: Quantity.Length = Field(
        2000.0, gt=0, le=1e6, description="Distance from the axis at which it has fallen to 1/e, m."
    )
    bearing: Quantity.Angle = Field(45.0, ge=0, lt=360, description="Direction of the axis, degrees from north.")
    scale_height: Quantity.Length = Field(
        1500.0, gt=0, le=1e4, description="Height over which its density falls to 1/e, m."
    )

    @property
    def low(self) -> float:
        """Optical depth far from the axis."""
        return 0.0

    @property
    def high(self) -> float:
        """Optical depth on the axis."""
        return self.optical_depth

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radiance is smooth in it."""
        return ()

    def values(self, x_m: Array, y_m: Array, time_s: float) -> Array:
        """Return the optical depth at places."""
        bearing = np.radians(self.bearing)
        distance = (x_m * np.cos(bearing) - y_m * np.sin(bearing)) / self.width
        return np.asarray(self.optical_depth * np.exp(-(distance**2)))

    def apply(self, setting: ColumnSetting, value: float) -> ColumnSetting:
        """Return the setting with smoky air."""
        return dataclasses.replace(setting, transmittance=SmokyAir(setting, self.scale_height, value))


class SmokyAir:
    """The air of a setting with an absorber whose optical depth falls as the inverse of the wavelength."""

    def __init__(self, setting: ColumnSetting, scale_height_m: float, optical_depth: float) -> None:
        self._air: Any = setting.transmittance
        self._profile, self.declares = setting.profile, setting.transmittance.declares
        above = np.exp(-setting.profile.altitude_m / scale_height_m)
        self._depth = optical_depth * -np.diff(above) / (above[0] - above[-1])
        for name in ("solar_path_radiance", "thread_safe"):  # what the air may also have
            if hasattr(self._air, name):
                setattr(self, name, getattr(self._air, name))
        self._highest_m = self.declares.valid.get("target_altitude_m", (0.0, np.inf))[1]
        if self._highest_m < self._profile.altitude_m[-1] and hasattr(self._air, "path_radiance"):
            self.path_radiance = self._added_to_the_air

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return the transmittance (P, V) of paths."""
        smoke = np.array([self._profile.airmass(path) @ self._depth for path in paths])
        through = self._air.transmittance(wavenumber_cm1, paths)
        return np.asarray(through * np.exp(-smoke[:, None] * wavenumber_cm1 / 1e4))

    def _added_to_the_air(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return the emission of air that knows its own, and no paths from high levels, where there is no smoke.

        Its sum over the levels below changes by the smoke.
        """
        radiance = np.array(self._air.path_radiance(wavenumber_cm1, paths))
        for row, leg in enumerate(path.legs[0] for path in paths):
            above = self._profile.altitude_m
            levels = np.append(leg.lower_m, above[(above > leg.lower_m) & (above <= self._highest_m)])
            ways = [to_space(level, leg.zenith_deg) for level in levels.tolist()]
            kelvin = self._profile.temperature_at(levels)
            source = planck(wavenumber_cm1[None, :], 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
            smoky, clear = (air.transmittance(wavenumber_cm1, ways) for air in (self, self._air))
            radiance[row] += np.sum(source * np.diff(smoky - clear, axis=0), axis=0)
        return radiance


def effect(scenario: Scenario, catalog: Catalog) -> PointEffect:
    """Return the effect of the section."""
    return scenario.sections["smoke"]


@hookimpl
def hcss_sections() -> list[SectionSpec]:
    """Name the section, and where its effect is made."""
    here = "hcss_examples.smoke:"
    return [SectionSpec("smoke", here + "Smoke", "smoke that absorbs", effect=here + "effect")]
