"""What is seen from above: water path, optical thickness, top and base of the clouds of a state.

The optical thickness is the sum of 3/2 rho q_c dz / (rho_w r_e) over a column, with the effective radius of N droplets
of one gamma distribution, r_e^3 = 3 rho q_c / (4 pi rho_w N k), k = .80 (G. M. Martin et al., J. Atmos. Sci. 51, 1823
(1994), maritime air).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_skies.les.model import Model
from hcss_twin.providers import Array

CLOUDY_G_KG = 0.01
"""Cloud water of a cloudy cell, as intercomparisons count it (Siebesma et al. 2003 take any; 1e-5 kg/kg is usual)."""

WATER_KG_M3 = 1000.0
K_DROPLETS = 0.80


def extinction(model: Model) -> Array:
    """Return the extinction (nx, ny, nz) of cloud droplets in m-1, visible (efficiency 2)."""
    content = 1e-3 * model.reference.density * model.liquid.astype(np.float64)
    droplets = 1e6 * model.case.output.droplets_cm3
    radius = np.cbrt(3.0 * content / (4.0 * np.pi * WATER_KG_M3 * droplets * K_DROPLETS))
    with np.errstate(invalid="ignore", divide="ignore"):
        result: Array = np.where(content > 0.0, 1.5 * content / (WATER_KG_M3 * radius), 0.0)
    return result


def picture(model: Model) -> dict[str, np.ndarray[Any, np.dtype[np.float32]]]:
    """Return fields (ny, nx), y along rows: liquid_water_path, optical_thickness, cloud_top, cloud_base.

    Top and base are those of the highest and the lowest cell with :data:`CLOUDY_G_KG`, the faces of the cells; NaN
    where there is none.
    """
    mesh, liquid = model.mesh, model.liquid
    cloudy = liquid > CLOUDY_G_KG
    any_cloud = cloudy.any(axis=2)
    highest = mesh.levels - cloudy[:, :, ::-1].argmax(axis=2)
    lowest = cloudy.argmax(axis=2)
    fields = {
        "liquid_water_path": liquid.astype(np.float64) @ model.mass,  # g/kg times kg m-2
        "optical_thickness": extinction(model) @ mesh.depth_m,
        "cloud_top": np.where(any_cloud, mesh.floor_m + mesh.faces_m[highest], np.nan),
        "cloud_base": np.where(any_cloud, mesh.floor_m + mesh.faces_m[lowest], np.nan),
    }
    return {name: np.ascontiguousarray(field.T, np.float32) for name, field in fields.items()}
