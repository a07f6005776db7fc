"""Clouds that only absorb and emit, over a sea that emits and reflects the sun."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import RadianceDeclaration, planck, relative_azimuth_rad, to_space


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    glint: bool = Field(True, description="Whether the sea reflects the sun.")


class Absorbing:
    declares = RadianceDeclaration(
        depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth", "thickness"}),
        notes=("absorbing radiance: clouds do not scatter, and the sea reflects no sky",),
    )
    terms = {  # noqa: RUF012
        "sea": "emitted by the sea",
        "clouds": "emitted by the clouds",
        "air": "emitted by the air",
        "glint": "sunlight reflected by the sea",
    }
    solar_terms = frozenset({"glint"})

    def __init__(self, inputs, parameters):
        self._inputs = inputs
        self._glint = parameters.glint

    def columns(self, states, wavenumber_cm1):
        result = states.empty(self.terms, wavenumber_cm1)
        for rows, setting, thickness_m in states.groups():
            mu = np.cos(np.radians([setting.view.zenith_deg]))
            through, air = self._air(setting, wavenumber_cm1, 0.0)
            emitted = planck(wavenumber_cm1, setting.sea_temperature_K) * through
            result["sea"][rows] = setting.sea.emissivity(wavenumber_cm1, mu)[0] * emitted
            result["clouds"][rows], result["air"][rows] = 0.0, air
            result["glint"][rows] = self._reflected_sun(setting, wavenumber_cm1, mu)
            for layer, column in zip(setting.layers, thickness_m.T, strict=True):  # from the lowest up
                bulk = self._inputs.optics.single_scattering(layer.microphysics, wavenumber_cm1)
                for row, thickness in zip(rows[column > 0.0], column[column > 0.0], strict=True):
                    through = np.exp(-bulk.extinction_m1 * (1.0 - bulk.albedo) * thickness / mu)
                    top_m = float(layer.cloud_top_m(thickness))
                    kelvin = layer.temperature_K or float(setting.profile.temperature_at(top_m))
                    to_sensor, above = self._air(setting, wavenumber_cm1, top_m)
                    for term in result.values():
                        term[row] *= through
                    result["air"][row] += (1.0 - through) * above
                    result["clouds"][row] += (1.0 - through) * planck(wavenumber_cm1, kelvin) * to_sensor
        return result

    def _air(self, setting, wavenumber_cm1, base_m):
        """Transmittance (V,) of the air above an altitude, and what it emits."""
        profile = setting.profile
        levels = np.concatenate(([base_m], profile.altitude_m[profile.altitude_m > base_m]))
        paths = [to_space(float(level), setting.view.zenith_deg) for level in levels]
        through = setting.transmittance.transmittance(wavenumber_cm1, paths)
        kelvin = profile.temperature_at(0.5 * (levels[1:] + levels[:-1]))
        emitted = planck(wavenumber_cm1, kelvin[:, None]) * np.diff(through, axis=0)
        return through[0], emitted.sum(axis=0)

    def _reflected_sun(self, setting, wavenumber_cm1, mu):
        view, sun = setting.view, setting.sun
        if sun is None or not self._glint:
            return np.zeros_like(wavenumber_cm1)
        mu_sun = np.cos(np.radians([sun.zenith_deg]))
        azimuth = np.array([relative_azimuth_rad(view.azimuth_deg, sun.azimuth_deg)])
        whole_way = to_space(0.0, sun.zenith_deg) + to_space(0.0, view.zenith_deg)
        received = mu_sun * self._inputs.solar_irradiance(wavenumber_cm1) / sun.distance_au**2
        brdf = setting.sea.brdf(wavenumber_cm1, mu, mu_sun, azimuth)[0]
        return received * brdf * setting.transmittance.transmittance(wavenumber_cm1, [whole_way])[0]
