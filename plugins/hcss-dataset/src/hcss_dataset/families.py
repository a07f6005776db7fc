"""Families of targets: generic values with their sources, as files, and the strengths that follow from the scene.

A body may be so much warmer than the air, the sea, or the skin of what flies there; a plume radiates in the bands of
hot gas; a facet of the sea mirrors the sun.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from hcss_twin.engine.stages.element_paths import ElementPaths
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Catalog, Sun, View, planck

FAMILIES = ("aircraft", "boat", "glint", "ship")
REFERENCES = ("air", "sea", "recovery")

_RECOVERY = 0.89 * 0.5 * 0.4
"""Recovery factor of a turbulent boundary layer, .71^(1/3), times half of the ratio of heat capacities less 1."""

_SOUND_M_S = math.sqrt(1.4 * 287.05)
"""Speed of sound over the root of the temperature."""


@cache
def family(name: str) -> Mapping[str, Any]:
    """Return the file of a family: title, intended_use, sources, not_known and targets."""
    path = resources.files(__package__) / "families" / f"{name}.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def family_names(given: Mapping[str, Any]) -> list[Any]:
    """Return the names that ``family`` in ``[targets]`` may become."""
    wanted = given.get("family", [])
    if isinstance(wanted, Mapping):
        wanted = wanted.get("choice", [wanted])
    return list(wanted) if isinstance(wanted, list | tuple) else [wanted]


def with_family(given: Mapping[str, Any], name: str | None) -> dict[str, Any]:
    """Return ``[targets]`` with the values of a family where it does not say other ones."""
    if name is None:
        return dict(given)
    own = {key: value for key, value in given.items() if key != "family"}
    defaults = family(name)["targets"]
    if "strength" in own:  # the parts are those of the family's own strength
        defaults = {key: value for key, value in defaults.items() if key != "parts"}
    return {**defaults, **own}


def reference_K(name: str, plan: Plan, altitude_m: float, speed_m_s: float) -> float:
    """Return the temperature of the air at an altitude, of the skin of what flies there, or of the sea.

    Raises
    ------
    ValueError
        If the altitude is above the air of the scene.
    """
    if name == "sea":
        return float(plan.assembly.sea_temperature_K)
    air = float(plan.assembly.profile.temperature_at(altitude_m))
    if name == "air":
        return air
    return air * (1.0 + _RECOVERY * (speed_m_s / (_SOUND_M_S * math.sqrt(air))) ** 2)


def gas_intensity(plan: Plan, temperature_K: float, area_m2: float, bands: list[Mapping[str, Any]]) -> dict[str, float]:
    """Return the radiant intensity in W/sr by band of grey gas: area x emissivity x radiance of a black body.

    Parameters
    ----------
    bands : list of mapping
        ``limits`` in um and ``emissivity``; elsewhere the gas is transparent.
    """
    wavenumber = plan.spectral_grid.wavenumber_cm1
    micrometre, emissivity = 1e4 / wavenumber, np.zeros_like(wavenumber)
    for each in bands:
        low, high = each["limits"]
        emissivity[(micrometre >= low) & (micrometre <= high)] = each["emissivity"]
    radiance = plan.spectral_grid.weights_cm1 @ (emissivity * planck(wavenumber, temperature_K))
    return {band.name: area_m2 * float(value) for band, value in zip(plan.bands, radiance, strict=True)}


def glint_intensity(plan: Plan, radius_m: float, time_s: float, view: View) -> dict[str, float]:
    """Return the radiant intensity in W/sr by band of the sun in a facet of the sea: reflectance x irradiance x R2 / 4.

    The irradiance is that behind the air; half of the angle between sun and sensor is that of incidence.

    Raises
    ------
    ValueError
        If the sun is below the horizon, or sunlight is left out of the scene.
    """
    sun = plan.sun_at(time_s)
    if sun is None:
        raise ValueError("a glint without sun; allowed: draws by day, in bands with sunlight")
    (up, across), (view_up, view_across) = (
        (math.cos(math.radians(each.zenith_deg)), math.sin(math.radians(each.zenith_deg))) for each in (sun, view)
    )
    between = up * view_up + across * view_across * math.cos(math.radians(sun.azimuth_deg - view.azimuth_deg))
    incidence = 0.5 * math.degrees(math.acos(min(max(between, -1.0), 1.0)))
    reflectance = fresnel(*_water(plan.spectral_grid.wavenumber_cm1), incidence)
    power = reflectance * _sunlight(plan, sun) * radius_m**2 / 4.0
    values = plan.spectral_grid.weights_cm1 @ power
    return {band.name: float(value) for band, value in zip(plan.bands, values, strict=True)}


def fresnel(n: Array, k: Array, incidence_deg: float) -> Array:
    """Return the reflectance for unpolarised light of a surface with the refractive index n - ik."""
    index, cosine = n - 1j * k, math.cos(math.radians(incidence_deg))
    inside = np.sqrt(index**2 - 1.0 + cosine**2)
    across, along = (cosine - inside) / (cosine + inside), (index**2 * cosine - inside) / (index**2 * cosine + inside)
    result: Array = 0.5 * (np.abs(across) ** 2 + np.abs(along) ** 2)
    return result


def _sunlight(plan: Plan, sun: Sun) -> Array:
    """Return the spectral irradiance (V,) of a surface that faces the sun at the sea."""
    irradiance, paths = plan.assembly.solar_irradiance(plan.spectral_grid.wavenumber_cm1), ElementPaths(plan)
    result: Array = irradiance / sun.distance_au**2 * paths.air(0.0, sun.zenith_deg)
    return result


@cache
def _water_table() -> tuple[Array, Array, Array]:
    catalog = Catalog()
    columns = catalog.columns(catalog.root / "optical_constants" / "water.csv")
    return columns["wavelength_um"], columns["n"], columns["k"]


def _water(wavenumber_cm1: Array) -> tuple[Array, Array]:
    """Return n and k of water, linear and logarithmic in the logarithm of wavelength, as its file says."""
    at, (wavelength, n, k) = -np.log(wavenumber_cm1 * 1e-4), _water_table()
    return np.interp(at, np.log(wavelength), n), np.exp(np.interp(at, np.log(wavelength), np.log(k)))
