"""Radiance columns of the paper's scene, with the paper's equations and with the corrected physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from hcss_paper.inputs import published
from hcss_twin import Scenario, make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, planck, to_space

Model = Literal["as-printed", "physical"]

BANDS = {"2.7-3.0": "swir-2.7-3.0", "3.0-5.0": "mwir", "8.0-14.0": "lwir"}
"""Catalog names of the paper's bands (limits in um)."""

COLUMNS: Mapping[str, Any] = {"slant.shadows": "off", "slant.parallax": "off", "sea.waves": "off"}
"""The paper has pixels that are columns, each for itself, over the mean sea."""

PHYSICAL: Mapping[str, Any] = {
    "radiance": {"model": "physical", "parameters": {}},
    "optics": {"provider": "bulk", "parameters": {}},
    "sea.model": "rough-sea",
}


def scene(model: Model, view_zenith_deg: float, bands: tuple[str, ...], changes: Mapping[str, Any]) -> Plan:
    """Return the plan of scenario ``baseline`` for one view, with a sun glint that no fit has scaled.

    Parameters
    ----------
    model : {"as-printed", "physical"}
    view_zenith_deg : float
    bands : tuple of str
        Catalog names.
    changes : mapping
        Further overrides of the scenario.
    """
    radiance = {"glint_scale": 1.0, "cloud_sun_scale": 0.0}
    common = {**COLUMNS, "view.zenith": view_zenith_deg, "bands": list(bands), "frames.count": 1}
    of_model = {"radiance.parameters": radiance} if model == "as-printed" else PHYSICAL
    return make_plan(Scenario.load("baseline", {**common, **of_model, **changes}))


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
    views = [float(zenith) for zenith in published()["view_zenith_deg"]]
    plans = [scene("as-printed", zenith, tuple(BANDS.values()), {}) for zenith in views]
    grid = plans[0].spectral_grid  # those of other views may be finer
    nu, transmittance, path = grid.wavenumber_cm1, [], []
    for zenith, plan in zip(views, plans, strict=True):
        transmittance.append(plan.assembly.transmittance.transmittance(nu, [to_space(0.0, zenith)])[0])
        path.append(plan.assembly.clear(nu, None)["path_emission"])
    return grid.wavenumber_cm1, grid.weights_cm1, np.array(transmittance), np.array(path)
