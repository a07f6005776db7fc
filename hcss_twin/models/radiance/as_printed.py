"""Radiance model ``as-printed``: the HCSS paper's eqs 8 and 12 to 20.

Where the paper's own tables contradict a printed equation, the corrected equation is the default and a ``literal_...``
switch selects the printed one. The model deliberately violates Kirchhoff's law: its cloud reflects sunlight regardless
of thickness. docs/development/radiance.md lists every difference from physics.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import AsPrintedParameters
from hcss_twin.physics.geometry import relative_azimuth_rad, scattering_cosine, scattering_cosine_literal, wind_azimuths
from hcss_twin.physics.multiple_scattering.phase_function import henyey_greenstein
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import CloudLayer, ColumnSetting, ColumnStates, RadianceDeclaration, RadianceInputs, Sun
from hcss_twin.providers.declarations import Note


@dataclass(frozen=True)
class _Cloud:
    """Radiance of N columns of one cloud layer at the sensor, through the air above them.

    Attributes
    ----------
    emissivity : ndarray (N, V)
        Eq 8; the transmittance of the cloud is 1 minus this.
    emitted, reflected : ndarray (N, V)
        Eqs 15 and 16 at the sensor, without the effect of other clouds.
    air_above : ndarray (N, V)
        Path radiance from the cloud top.
    """

    emissivity: Array
    emitted: Array
    reflected: Array
    air_above: Array


class AsPrinted:
    """Single-scattering cloud over a rough sea, as printed in the HCSS paper.

    Parameters
    ----------
    inputs : RadianceInputs
        Any number of cloud layers that do not overlap.
    parameters : AsPrintedParameters
        Glint scale and literal switches.
    """

    terms: Mapping[str, str] = {
        "cloud_emission": "thermal emission of the cloud (eqs 8, 15)",
        "cloud_reflected_sun": "sunlight reflected by the cloud (eqs 12-14, 16)",
        "sea_emission": "thermal emission of the sea, through the cloud where there is one (eq 17)",
        "sea_reflected_sun": "sun glint of the sea, through the cloud where there is one (eq 18)",
        "path_emission": "thermal emission of the air above sea or highest cloud top",
    }
    solar_terms = frozenset({"cloud_reflected_sun", "sea_reflected_sun"})
    sea_sun_terms = frozenset({"sea_reflected_sun"})
    expected_failures: Mapping[str, str] = MappingProxyType(
        {"slanted cloud absorbs by its slant path": "eqs 8-11 take the vertical thickness, from any direction"}
    )

    model_errors = from_table(__file__, "as-printed")

    def __init__(self, inputs: RadianceInputs, parameters: AsPrintedParameters) -> None:
        self._inputs = inputs
        self._parameters = parameters
        self.declares = RadianceDeclaration(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth", "thickness"}),
            notes=_notes(parameters, len(inputs.setting.layers)),
        )

    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Return terms (N, V) of columns: eq 19 for clear sky, eq 20 for clouds (HCSS paper)."""
        result = states.empty(self.terms, wavenumber_cm1)
        for rows, setting, thickness_m in states.groups():
            columns, cloudy = (
                PrintedColumns(self._inputs, self._parameters, setting),
                np.any(thickness_m > 0.0, axis=1),
            )
            clear = columns.clear(wavenumber_cm1)
            clouds = columns.cloudy(wavenumber_cm1, thickness_m[cloudy], clear) if np.any(cloudy) else {}
            for name, values in result.items():
                values[rows[~cloudy]] = clear[name]
                if clouds:
                    values[rows[cloudy]] = clouds[name]
        return result


class PrintedColumns:
    """Columns of one setting."""

    def __init__(self, inputs: RadianceInputs, parameters: AsPrintedParameters, setting: ColumnSetting) -> None:
        self._inputs, self._parameters, self._setting = inputs, parameters, setting
        self._mu = math.cos(math.radians(setting.view.zenith_deg))

    def clear(self, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Terms (V,) of a cloud-free column: tau_s L_s + L_atm (HCSS paper, eq 19)."""
        zero = np.zeros_like(wavenumber_cm1)
        zenith = self._setting.view.zenith_deg
        surface = to_space(0.0, zenith)
        transmittance = self._setting.transmittance.transmittance(wavenumber_cm1, [surface])[0]
        air = path_radiance(self._setting.transmittance, self._setting.profile, wavenumber_cm1, [0.0], zenith)[0]
        return {
            "cloud_emission": zero,
            "cloud_reflected_sun": zero,
            "sea_emission": transmittance * self._sea_emission(wavenumber_cm1),
            "sea_reflected_sun": self._glint(wavenumber_cm1),
            "path_emission": air,
        }

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, clear: Mapping[str, Array]) -> Mapping[str, Array]:
        """Terms (N, V) of cloudy columns: tau_c L_c + tau_sc L_s + L_atm above the cloud top (HCSS paper, eq 20).

        The paper has one layer. With several, the radiance of each cloud (eq 15 and eq 16) is attenuated by the clouds
        above, which transmit 1 - emissivity, as in eq 20 for the sea.
        """
        layers = self._setting.layers
        shape = thickness_m.shape[0], wavenumber_cm1.size
        emitted, reflected, air = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        through = np.ones(shape)
        seen_first = np.ones(shape[0], dtype=bool)
        for index in sorted(range(len(layers)), key=lambda layer: layers[layer].base_m, reverse=True):
            rows = np.flatnonzero(thickness_m[:, index] > 0)
            if rows.size == 0:
                continue
            cloud = self._cloud(layers[index], wavenumber_cm1, thickness_m[rows, index])
            emitted[rows] += through[rows] * cloud.emitted
            reflected[rows] += through[rows] * cloud.reflected
            highest = seen_first[rows]
            air[rows[highest]] = cloud.air_above[highest]
            through[rows] *= 1.0 - cloud.emissivity
            seen_first[rows] = False
        if self._parameters.literal_eq20:
            through = through + 1.0
        return {
            "cloud_emission": emitted,
            "cloud_reflected_sun": reflected,
            "sea_emission": through * clear["sea_emission"],
            "sea_reflected_sun": through * clear["sea_reflected_sun"],
            "path_emission": air,
        }

    def _cloud(self, layer: CloudLayer, wavenumber_cm1: Array, thickness_m: Array) -> _Cloud:
        """Clouds of one layer of ``thickness_m`` (N,) > 0, seen through air alone: eq 8, eq 15 and eq 16."""
        setting = self._setting
        scattering = self._inputs.optics.single_scattering(layer.microphysics, wavenumber_cm1)
        # Columns of equal thickness, common with two layers, share everything; columns with equal cloud-top altitude
        # share their paths.
        thickness, same = np.unique(thickness_m, return_inverse=True)
        tops, column = np.unique(layer.cloud_top_m(thickness), return_inverse=True)
        emissivity = cloud_emissivity(scattering.extinction_m1, scattering.albedo, thickness)
        zenith = setting.view.zenith_deg
        above = [to_space(float(top), zenith) for top in tops]
        transmittance = setting.transmittance.transmittance(wavenumber_cm1, above)[column]
        air_from = np.zeros(1) if self._parameters.literal_eq19 else tops
        air = path_radiance(
            setting.transmittance, setting.profile, wavenumber_cm1, [float(top) for top in air_from], zenith
        )
        air = np.repeat(air, thickness.size, axis=0) if self._parameters.literal_eq19 else air[column]
        temperature = self._cloud_temperature(layer, thickness)
        emission = planck(wavenumber_cm1[None, :], temperature[:, None])
        reflected = self._cloud_reflection(wavenumber_cm1, tops, scattering.albedo, scattering.moments[1])[column]
        return _Cloud(emissivity[same], (transmittance * emissivity * emission)[same], reflected[same], air[same])

    def _cloud_temperature(self, layer: CloudLayer, thickness_m: Array) -> Array:
        if layer.temperature_K is not None:
            return np.full_like(thickness_m, layer.temperature_K)
        return self._setting.profile.temperature_at(layer.cloud_top_m(thickness_m))

    def _sea_emission(self, wavenumber_cm1: Array) -> Array:
        """Emissivity times Planck radiance at the sea surface, (V,) (HCSS paper, eq 17)."""
        emissivity = self._setting.sea.emissivity(wavenumber_cm1, np.array([self._mu]), **self._wind())[0]
        result: Array = emissivity * planck(wavenumber_cm1, self._setting.sea_temperature_K)
        return result

    def _glint(self, wavenumber_cm1: Array) -> Array:
        """Sun glint at the sensor, (V,): sunlight crosses the air down to the sea and up again (HCSS paper, eq 18)."""
        sun = self._setting.sun
        if sun is None or not sun.is_up or self._parameters.glint_scale == 0.0:
            return np.zeros_like(wavenumber_cm1)
        view = self._setting.view
        mu0 = math.cos(math.radians(sun.zenith_deg))
        azimuth = relative_azimuth_rad(view.azimuth_deg, sun.azimuth_deg)
        brdf = self._setting.sea.brdf(
            wavenumber_cm1, np.array([self._mu]), np.array([mu0]), np.array([azimuth]), **self._wind()
        )[0]
        path = to_space(0.0, view.zenith_deg)
        if not self._parameters.literal_eq18:
            path = path + to_space(0.0, sun.zenith_deg)
        transmittance = self._setting.transmittance.transmittance(wavenumber_cm1, [path])[0]
        result: Array = (
            self._parameters.glint_scale * transmittance * mu0 * self._irradiance(wavenumber_cm1, sun) * brdf
        )
        return result

    def _wind(self) -> dict[str, Array]:
        """Return the view azimuth relative to the wind, counted toward the sun, as argument of an anisotropic sea."""
        setting = self._setting
        if not getattr(setting.sea, "anisotropic", False):
            return {}
        azimuth, sun = setting.view.azimuth_deg, setting.sun
        sun_azimuth = azimuth if sun is None else sun.azimuth_deg
        return {"wind_azimuth": np.array([wind_azimuths(azimuth, sun_azimuth, self._inputs.wind_from_deg)[1]])}

    def _cloud_reflection(self, wavenumber_cm1: Array, tops_m: Array, albedo: Array, asymmetry: Array) -> Array:
        """Sunlight reflected by the cloud, at the sensor, (tops, V): eq 12 to eq 14 in eq 16 of the HCSS paper."""
        sun = self._setting.sun
        if sun is None or not sun.is_up or self._parameters.cloud_sun_scale == 0.0:
            return np.zeros((tops_m.size, wavenumber_cm1.size))
        view = self._setting.view
        mu0 = math.cos(math.radians(sun.zenith_deg))
        azimuth = relative_azimuth_rad(view.azimuth_deg, sun.azimuth_deg)
        turn = scattering_cosine_literal if self._parameters.literal_eq14 else scattering_cosine
        brdf = cloud_brdf(albedo, asymmetry, turn(self._mu, mu0, azimuth), self._mu, mu0)
        paths = [to_space(float(top), sun.zenith_deg) + to_space(float(top), view.zenith_deg) for top in tops_m]
        transmittance = self._setting.transmittance.transmittance(wavenumber_cm1, paths)
        received = self._parameters.cloud_sun_scale * mu0 * self._irradiance(wavenumber_cm1, sun)
        result: Array = transmittance * (received * brdf)
        return result

    def _irradiance(self, wavenumber_cm1: Array, sun: Sun) -> Array:
        result: Array = self._inputs.solar_irradiance(wavenumber_cm1) / sun.distance_au**2
        return result


def cloud_emissivity(extinction_m1: Array, albedo: Array, thickness_m: Array) -> Array:
    """Return 1 - exp(-k_abs z), k_abs = k_ext (1 - albedo), (N, V) (HCSS paper, eq 8 with eq 9, eq 10 and eq 11).

    As printed, without the slant factor 1 / mu.
    """
    absorption = extinction_m1 * (1.0 - albedo)
    result: Array = -np.expm1(-thickness_m[:, None] * absorption[None, :])
    return result


def cloud_brdf(albedo: Array, asymmetry: Array, scattering_cosine_: float, mu: float, mu0: float) -> Array:
    """Single-scattering BRDF of the cloud in sr-1, (V,), independent of thickness (HCSS paper, eq 12 with eq 13)."""
    phase = henyey_greenstein(np.array(scattering_cosine_), asymmetry)
    result: Array = albedo / (4.0 * math.pi) * phase * mu0 / (mu0 + mu)
    return result


def _notes(parameters: AsPrintedParameters, layers: int) -> tuple[str, ...]:
    notes = ["as-printed radiance: single scattering, no slant factor in the cloud, no reflected sky"]
    if layers > 1:
        notes.append("as-printed radiance: the paper has one cloud layer; a second one extends its eq 20")
    if not parameters.literal_eq19:
        notes.append("as-printed radiance: emission of the air below a cloud is lost, however thin the cloud")
    if parameters.glint_scale != 1.0:
        text = f"sun glint scaled by {parameters.glint_scale:g}, which is a fit and not physics"
        notes.append(Note(text, sunlight=True))
    if parameters.cloud_sun_scale != 1.0:
        scale = parameters.cloud_sun_scale
        text = f"sunlight reflected by cloud scaled by {scale:g}, which is a fit and not physics"
        notes.append(Note(text, sunlight=True))
    literal = [name for name, on in parameters if name.startswith("literal_") and on]
    if literal:
        notes.append(f"literal forms that the paper's own tables exclude: {', '.join(literal)}")
    return tuple(notes)
