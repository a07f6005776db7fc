"""Haze that thickens toward the east: air that differs from place to place."""

import dataclasses
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from hcss_twin import Scenario
from hcss_twin.providers import Array, Catalog, ColumnSetting, Path, PointEffect
from pydantic import BaseModel, ConfigDict, Field


class Settings(BaseModel):
    """Keys of the section, and the effect: optical depth, 0 in the west and greatest in the east."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    optical_depth: float = Field(default=0.3, gt=0, le=5, description="Of the haze far in the east, vertical.")
    width: float = Field(default=5000.0, gt=0, le=1e6, description="Width of the transition, m.")
    scale_height: float = Field(default=1500.0, gt=0, le=1e4, description="Height over which haze falls to 1/e, m.")

    @property
    def low(self) -> float:
        """Least optical depth."""
        return 0.0

    @property
    def high(self) -> float:
        """Greatest optical depth."""
        return self.optical_depth

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radiance is smooth in the optical depth."""
        return ()

    def values(self, x_m: Array, y_m: Array, time_s: float) -> Array:
        """Return the optical depth at places east and north of the centre."""
        return np.asarray(self.optical_depth * 0.5 * (1.0 + np.tanh(x_m / self.width)))

    def apply(self, setting: ColumnSetting, value: float) -> ColumnSetting:
        """Return the setting with haze of an optical depth in its air."""
        return dataclasses.replace(setting, transmittance=Haze(setting, self.scale_height, value))


class Haze:
    """The air of a setting with a grey absorber."""

    def __init__(self, setting: ColumnSetting, scale_height_m: float, optical_depth: float) -> None:
        self._air: Any = setting.transmittance
        self._profile, self.declares = setting.profile, setting.transmittance.declares
        above = np.exp(-setting.profile.altitude_m / scale_height_m)
        self._depth = optical_depth * -np.diff(above) / (above[0] - above[-1])
        for name in ("solar_path_radiance", "thread_safe"):  # what the air may also have
            if hasattr(self._air, name):
                setattr(self, name, getattr(self._air, name))

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return the transmittance (P, V) of paths."""
        depth = np.array([self._profile.airmass(path) @ self._depth for path in paths])
        return np.asarray(self._air.transmittance(wavenumber_cm1, paths) * np.exp(-depth)[:, None])


def make_effect(scenario: Scenario, catalog: Catalog) -> PointEffect:
    """Return the effect of a scenario with the section."""
    name = next(name for name, settings in scenario.sections.items() if isinstance(settings, Settings))
    return cast(Settings, scenario.sections[name])
