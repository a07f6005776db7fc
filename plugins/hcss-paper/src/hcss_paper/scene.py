"""Radiance columns of the paper's scene, with the paper's equations and with the corrected physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from hcss_paper.inputs import fitted, published
from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.reference import reference_radiance
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

Model = Literal["as-printed", "physical"]

BANDS = {"2.7-3.0": "swir-2.7-3.0", "3.0-5.0": "mwir", "8.0-14.0": "lwir"}
"""Catalog names of the paper's bands (limits in um)."""

_PHYSICAL: Mapping[str, Any] = {
    "radiance": {"model": "physical"},
    "sea.model": "rough-sea",
    "optics": {"provider": "bulk"},
}


@lru_cache(maxsize=16)
def scene(
    model: Model,
    view_zenith_deg: float,
    bands: tuple[str, ...],
    glint_scale: float = 1.0,
    sea_temperature_K: float | None = None,
) -> Plan:
    """Return the plan of scenario ``baseline`` with the settings of Tables II and IV.

    Both models have the same place, time, air, sea temperature, wind, and cloud at 6 km. The other inputs fitted to
    the tables (the factor on the glint, no sunlight on the cloud) apply to ``as-printed`` only.

    Parameters
    ----------
    model : {"as-printed", "physical"}
    view_zenith_deg : float
    bands : tuple of str
        Catalog names.
    glint_scale : float
        Factor on the glint in ``as-printed``.
    sea_temperature_K : float, optional
        By default that of the scenario.
    """
    radiance = {"glint_scale": glint_scale, "cloud_sun_scale": 0.0}
    return make_plan(
        Scenario.load(
            "baseline",
            {
                "view.zenith": view_zenith_deg,
                "bands": list(bands),
                "frames.count": 1,
                "sea.temperature_texture": 0.0,  # the paper's sea has one temperature
                **({} if sea_temperature_K is None else {"sea.temperature": sea_temperature_K}),
                **({"radiance.parameters": radiance} if model == "as-printed" else _PHYSICAL),
            },
        )
    )


@dataclass(frozen=True)
class Columns:
    """Radiance of a clear and of an opaque column, each (views or suns, bands), W m-2 sr-1."""

    clear: Array
    opaque: Array

    def mixed(self, cover: float, band: int = 0) -> Array:
        """Return the radiance (views or suns,) of a scene with the fraction ``cover`` of opaque cloud."""
        result: Array = (1.0 - cover) * self.clear[:, band] + cover * self.opaque[:, band]
        return result


@lru_cache(maxsize=4)
def columns_over_views(model: Model, sunlit: bool = True) -> Columns:
    """Return the columns at the view zenith angles of Tables II and IV, for the three bands of :data:`BANDS`."""
    clear, opaque = [], []
    for zenith in published()["view_zenith_deg"]:
        plan = scene(model, float(zenith), tuple(BANDS.values()), fitted("glint scale"), fitted("sea temperature"))
        found = _columns(plan, plan.sun_track.at(0.0) if sunlit else None)
        clear.append(found[0])
        opaque.append(found[1])
    return Columns(np.array(clear), np.array(opaque))


@lru_cache(maxsize=6)
def columns_over_suns(model: Model, suns: tuple[Sun, ...], one_distance: bool = True) -> Columns:
    """Return the columns of Tables V and VI: nadir view, 3-5 um, one row for each sun position.

    Parameters
    ----------
    model : {"as-printed", "physical"}
    suns : tuple of Sun
    one_distance : bool
        If true, ``as-printed`` has the sun at 1 au on every day.
    """
    plan = scene(model, 0.0, (BANDS["3.0-5.0"],), fitted("glint scale"), fitted("sea temperature"))
    if model == "as-printed" and one_distance:
        # The printed radiance does not include the annual variation of solar irradiance.
        suns = tuple(replace(sun, distance_au=1.0) for sun in suns)
    found = [_columns(plan, sun) for sun in suns]
    return Columns(np.array([row[0] for row in found]), np.array([row[1] for row in found]))


def _columns(plan: Plan, sun: Sun | None) -> Array:
    """Clear and opaque column, (2, B)."""
    thickness_m = [0.0, plan.layers[0].thickness_max_m]
    return reference_radiance(plan.assembly.model, plan.spectral_grid, thickness_m, sun)


@dataclass(frozen=True)
class BlackSurface:
    """Thermal radiance of clear air above a black surface, which the MODTRAN columns agree with.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
    weights_cm1 : ndarray (V,)
        Weights of the band integral.
    transmittance, path_radiance : ndarray (views, V)
    """

    wavenumber_cm1: Array
    weights_cm1: Array
    transmittance: Array
    path_radiance: Array

    def radiance(self, temperature_K: float) -> Array:
        """Return the band radiance (views,) above a surface of that temperature."""
        emitted = self.transmittance * planck(self.wavenumber_cm1, temperature_K)
        result: Array = (emitted + self.path_radiance) @ self.weights_cm1
        return result


def black_surface(band: str) -> BlackSurface:
    """Return the clear air of the paper's scene at the view zenith angles of Tables II and IV.

    Parameters
    ----------
    band : str
        Catalog name, one of :data:`BANDS`.
    """
    wavenumber, weights, transmittance, path = _clear_air()
    return BlackSurface(wavenumber, weights[list(BANDS.values()).index(band)], transmittance, path)


@lru_cache(maxsize=1)
def _clear_air() -> tuple[Array, Array, Array, Array]:
    """Wavenumbers (V,), weights (bands, V), transmittance and path radiance (views, V)."""
    transmittance, path = [], []
    for zenith in map(float, published()["view_zenith_deg"]):
        plan = scene("as-printed", zenith, tuple(BANDS.values()))
        nu = plan.spectral_grid.wavenumber_cm1
        transmittance.append(plan.assembly.transmittance.transmittance(nu, [to_space(0.0, zenith)])[0])
        path.append(plan.assembly.model.clear(nu, None)["path_emission"])
    grid = plan.spectral_grid
    return grid.wavenumber_cm1, grid.weights_cm1, np.array(transmittance), np.array(path)
