"""Sea, cloud and air that absorb and emit; nothing scatters, and the sea reflects nothing."""

from collections.abc import Mapping

import numpy as np
from hcss_twin.providers import (
    Array,
    ColumnSetting,
    ColumnStates,
    RadianceDeclaration,
    RadianceInputs,
    planck,
    to_space,
)
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    air_emits: bool = Field(default=True, description="Whether the air emits.")


class Provider:
    """Each cloud absorbs what comes from below, and emits at the temperature of its top."""

    declares = RadianceDeclaration(
        depends_on=frozenset({"view_zenith", "thickness"}), notes=("nothing scatters or reflects",)
    )
    terms: Mapping[str, str] = {"sea": "emitted by the sea", "clouds": "by the clouds", "air": "by the air"}
    solar_terms: frozenset[str] = frozenset()

    def __init__(self, inputs: RadianceInputs, parameters: Parameters) -> None:
        self._inputs = inputs
        self._air_emits = parameters.air_emits

    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> dict[str, Array]:
        """Return each term (N, V) of N columns."""
        terms = states.empty(self.terms, wavenumber_cm1)
        for rows, setting, thickness_m in states.groups():  # columns alike but for their clouds
            mu = np.cos(np.radians([setting.view.zenith_deg]))
            through, air = self._air(setting, wavenumber_cm1, 0.0)
            sea = setting.sea.emissivity(wavenumber_cm1, mu)[0] * planck(wavenumber_cm1, setting.sea_temperature_K)
            terms["sea"][rows], terms["clouds"][rows], terms["air"][rows] = sea * through, 0.0, air
            for layer, column in zip(setting.layers, thickness_m.T, strict=True):  # from the lowest up
                bulk = self._inputs.optics.single_scattering(layer.microphysics, wavenumber_cm1)
                absorption_m1 = bulk.extinction_m1 * (1.0 - bulk.albedo)
                for row, thickness in zip(rows[column > 0.0], column[column > 0.0], strict=True):
                    top_m = float(layer.cloud_top_m(thickness))
                    kelvin = layer.temperature_K or float(setting.profile.temperature_at(top_m))
                    through = np.exp(-absorption_m1 * thickness / mu)
                    to_sensor, above = self._air(setting, wavenumber_cm1, top_m)
                    for term in terms.values():
                        term[row] *= through
                    terms["air"][row] += (1.0 - through) * above
                    terms["clouds"][row] += (1.0 - through) * planck(wavenumber_cm1, kelvin) * to_sensor
        return terms

    def _air(self, setting: ColumnSetting, wavenumber_cm1: Array, base_m: float) -> tuple[Array, Array]:
        """Return transmittance (V,) of the air above an altitude, and the radiance (V,) that it emits."""
        profile = setting.profile
        levels = np.concatenate(([base_m], profile.altitude_m[profile.altitude_m > base_m]))
        paths = [to_space(float(level), setting.view.zenith_deg) for level in levels]
        through = setting.transmittance.transmittance(wavenumber_cm1, paths)
        kelvin = profile.temperature_at(0.5 * (levels[1:] + levels[:-1]))
        emitted = np.sum(planck(wavenumber_cm1, kelvin[:, None]) * np.diff(through, axis=0), axis=0)
        return through[0], emitted if self._air_emits else np.zeros_like(emitted)
