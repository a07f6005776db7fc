"""Smoke whose optical depth varies over the image: an effect of points, and a model for your own."""

import dataclasses

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_examples.smoky_air import SmokyAir
from hcss_twin import Scenario
from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Array, Catalog, ColumnSetting, PointEffect, SectionSpec, hookimpl


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


def effect(scenario: Scenario, catalog: Catalog) -> PointEffect:
    """Return the effect of the section."""
    return scenario.sections["smoke"]


@hookimpl
def hcss_sections() -> list[SectionSpec]:
    """Name the section, and where its effect is made."""
    here = "hcss_examples.smoke:"
    return [SectionSpec("smoke", here + "Smoke", "smoke that absorbs", effect=here + "effect")]
