"""Frames: thickness from the generator, radiance by look-up, one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.providers import CloudLayer
from hcss_twin.scene.brightness import BrightnessTemperature
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables import TOTAL, RadianceTables, look_up

Frame = dict[str, NDArray[Any]]


def stream(plan: Plan, tables: RadianceTables | None) -> Iterator[Frame]:
    """Yield each frame's requested variables; memory does not depend on the number of frames.

    Parameters
    ----------
    tables : RadianceTables or None
        None where no requested variable needs radiance.
    """
    maker = _FrameMaker(plan, tables)
    for time_s in plan.frame_times_s:
        yield maker.frame(float(time_s))


class _FrameMaker:
    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._tables = tables
        self._names = {spec.name for spec in plan.variables}
        self._temperature = (
            BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])
            if "brightness_temperature" in self._names
            else None
        )
        self._extinction = _band_extinction(plan) if "cloud_optical_thickness" in self._names else None

    def frame(self, time_s: float) -> Frame:
        thickness = self._thickness(time_s)
        made: Frame = self._truth(thickness)
        if self._tables is not None:
            for name, values in look_up(self._tables.at(time_s), thickness).items():
                made[TOTAL if name == TOTAL else TERM_PREFIX + name] = values
            if self._temperature is not None:
                made["brightness_temperature"] = self._temperature(made[TOTAL])
        return {name: values for name, values in made.items() if name in self._names}

    def _thickness(self, time_s: float) -> NDArray[np.float32]:
        grid = self._plan.grid
        if self._plan.generator is None:
            return np.zeros((grid.rows, grid.columns), dtype=np.float32)
        return self._plan.generator.thickness_m(time_s, slice(0, grid.rows), slice(0, grid.columns))

    def _truth(self, thickness: NDArray[np.float32]) -> Frame:
        names, layer = self._names, self._plan.layer
        made: Frame = {}
        if "cloud_mask" in names:
            made["cloud_mask"] = (thickness > 0).astype(np.uint8)
        if "cloud_thickness" in names:
            made["cloud_thickness"] = thickness
        if self._extinction is not None:
            made["cloud_optical_thickness"] = self._extinction[:, None, None] * thickness
        if "cloud_top_altitude" in names or "cloud_top_temperature" in names:
            top = _cloud_top(layer, thickness)
            made["cloud_top_altitude"] = top.astype(np.float32)
            made["cloud_top_temperature"] = self._top_temperature(layer, top)
        return made

    def _top_temperature(self, layer: CloudLayer | None, top: NDArray[np.float64]) -> NDArray[np.float32]:
        temperature = np.full(top.shape, np.nan, dtype=np.float32)
        cloudy = np.isfinite(top)
        if layer is not None and np.any(cloudy):
            if layer.temperature_K is not None:
                temperature[cloudy] = layer.temperature_K
            else:
                temperature[cloudy] = self._plan.profile.temperature_at(top[cloudy])
        return temperature


def _cloud_top(layer: CloudLayer | None, thickness: NDArray[np.float32]) -> NDArray[np.float64]:
    """Altitude of the cloud top, NaN where clear."""
    top = np.full(thickness.shape, np.nan)
    if layer is not None:
        cloudy = thickness > 0
        top[cloudy] = layer.cloud_top_m(thickness[cloudy].astype(np.float64))
    return top


def _band_extinction(plan: Plan) -> NDArray[np.float32]:
    """Extinction at each band's central wavelength, (B,), m-1; 0 without cloud."""
    centres = np.array([1e4 / band.central_um for band in plan.bands])
    if plan.layer is None:
        return np.zeros(centres.size, dtype=np.float32)
    ascending, position = np.unique(centres, return_inverse=True)
    properties = plan.optics.single_scattering(plan.layer.microphysics, ascending)
    return properties.extinction_m1[position].astype(np.float32)
