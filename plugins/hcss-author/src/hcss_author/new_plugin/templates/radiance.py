"""Sea, cloud and air that absorb and emit; nothing scatters, and the sea reflects nothing."""

from collections.abc import Mapping

import numpy as np
from hcss_twin.providers import to_space, planck, Array, RadianceDeclaration, RadianceInputs, Sun
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

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> dict[str, Array]:
        """Return each term (V,) of a column without cloud."""
        inputs, mu = self._inputs, np.cos(np.radians([self._inputs.view.zenith_deg]))
        through, air = self._air(wavenumber_cm1, 0.0)
        sea = inputs.sea.emissivity(wavenumber_cm1, mu)[0] * planck(wavenumber_cm1, inputs.sea_temperature_K)
        return {"sea": sea * through, "clouds": np.zeros(wavenumber_cm1.size), "air": air}

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> dict[str, Array]:
        """Return each term (N, V) of columns with layers of thickness (N, L), from the lowest up."""
        inputs, slant = self._inputs, 1.0 / np.cos(np.radians(self._inputs.view.zenith_deg))
        terms = {name: np.tile(term, (len(thickness_m), 1)) for name, term in self.clear(wavenumber_cm1, sun).items()}
        for layer, column in zip(inputs.layers, thickness_m.T, strict=True):
            bulk = inputs.optics.single_scattering(layer.microphysics, wavenumber_cm1)
            absorption_m1 = bulk.extinction_m1 * (1.0 - bulk.albedo)
            for row in np.flatnonzero(column):
                top_m = float(layer.cloud_top_m(column[row]))
                kelvin = layer.temperature_K or float(inputs.profile.temperature_at(top_m))
                through = np.exp(-absorption_m1 * column[row] * slant)
                to_sensor, above = self._air(wavenumber_cm1, top_m)
                for term in terms.values():
                    term[row] *= through
                terms["air"][row] += (1.0 - through) * above
                terms["clouds"][row] += (1.0 - through) * planck(wavenumber_cm1, kelvin) * to_sensor
        return terms

    def _air(self, wavenumber_cm1: Array, base_m: float) -> tuple[Array, Array]:
        """Return transmittance (V,) of the air above an altitude, and the radiance (V,) that it emits."""
        profile = self._inputs.profile
        levels = np.concatenate(([base_m], profile.altitude_m[profile.altitude_m > base_m]))
        paths = [to_space(float(level), self._inputs.view.zenith_deg) for level in levels]
        through = self._inputs.transmittance.transmittance(wavenumber_cm1, paths)
        kelvin = profile.temperature_at(0.5 * (levels[1:] + levels[:-1]))
        emitted = np.sum(planck(wavenumber_cm1, kelvin[:, None]) * np.diff(through, axis=0), axis=0)
        return through[0], emitted if self._air_emits else np.zeros_like(emitted)
