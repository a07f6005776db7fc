"""Moist thermodynamics: the reference state, saturation, and the buoyancy that drives clouds.

The model carries the liquid-water potential temperature theta_l = (T - L/cp q_c) / Pi and the total water q_t = q_v +
q_c, both of which condensation keeps (Betts 1973, QJRMS 99, 178; the linear form). Rain q_r is apart. Pressure is that
of the reference state. Water is in g per kg of air, as specific humidity, so that the smoothness indicators of the
advection are far above their floor in single precision.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_skies.les.advection import FAST
from hcss_skies.les.grid import Mesh
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

GRAVITY = 9.81
"""m s-2."""
R_DRY = 287.04
"""Gas constant of dry air, J kg-1 K-1."""
CP = 1005.0
"""Heat capacity of dry air at constant pressure, J kg-1 K-1."""
LATENT = 2.5e6
"""Latent heat of vaporisation, J kg-1."""
EPSILON = 0.622
"""Ratio of the molar masses of water and dry air."""
VIRTUAL = 1.0 / EPSILON - 1.0
"""How much lighter vapour makes air."""
P_0 = 1e5
"""Reference pressure of potential temperature, Pa."""
G = 1e-3
"""kg in a gram."""


@dataclass(frozen=True)
class ReferenceState:
    """Air at rest, horizontally uniform, in hydrostatic balance.

    Attributes
    ----------
    cp_J_kg_K, latent_J_kg : float
        Heat capacity of air, latent heat.
    theta_0_K : float
        Constant of which theta_l of fields is the difference: single precision keeps small differences then.
    pressure_Pa, exner, theta_v_K, density : ndarray
        In cells (nz,); density in kg m-3.
    density_at_faces : ndarray
        (nz + 1,).
    """

    cp_J_kg_K: float
    latent_J_kg: float
    theta_0_K: float
    pressure_Pa: Array
    exner: Array
    theta_v_K: Array
    density: Array
    density_at_faces: Array

    @property
    def warming(self) -> float:
        """By how much the condensation of 1 g/kg warms air, K."""
        return self.latent_J_kg / self.cp_J_kg_K * G

    @classmethod
    def of_profiles(
        cls,
        mesh: Mesh,
        theta_l_K: Array,
        water_g_kg: Array,
        surface_pressure_Pa: float,
        cp: float = CP,
        latent: float = LATENT,
    ) -> ReferenceState:
        """Integrate dPi/dz = -g / (cp theta_v) upward from the sea, with liquid where the profile is saturated."""
        kappa, warming = R_DRY / cp, latent / cp * G
        exner_sea = (surface_pressure_Pa / P_0) ** kappa
        exner, theta_v = np.empty(mesh.levels), np.empty(mesh.levels)
        below, height, theta_below = exner_sea, 0.0, 0.0
        for k, z in enumerate(mesh.centres_m):
            here = theta_l_K[k]
            for _ in range(4):  # theta_v of the level depends on its pressure, weakly
                layer = 0.5 * (here + theta_below) if k else here
                exner[k] = below - GRAVITY / cp * (z - height) / layer
                pressure = P_0 * exner[k] ** (1.0 / kappa)
                liquid = condensate(theta_l_K[k], water_g_kg[k], pressure, exner[k], warming)
                here = virtual(theta_l_K[k], water_g_kg[k], liquid, 0.0, exner[k], warming)
            theta_v[k], below, height, theta_below = here, exner[k], z, here
        pressure_Pa = P_0 * exner ** (1.0 / kappa)
        density = pressure_Pa / (R_DRY * theta_v * exner)
        at_faces = np.exp(np.interp(mesh.faces_m, mesh.centres_m, np.log(density)))
        # beyond the first and last centres with the slope beside them
        for face, cell in ((0, 0), (-1, -1)):
            rate = GRAVITY / (R_DRY * theta_v[cell] * exner[cell])
            at_faces[face] = density[cell] * np.exp(rate * (mesh.centres_m[cell] - mesh.faces_m[face]))
        return cls(cp, latent, float(round(theta_l_K[0])), pressure_Pa, exner, theta_v, density, at_faces)


@kernel(inner=True, fastmath=FAST)
def saturation(temperature: float, pressure: float) -> tuple[float, float]:
    """Return q_s (g/kg) over water and dq_s/dT; the vapour pressure is a polynomial of eighth order.

    P. J. Flatau, R. L. Walko and W. R. Cotton, Polynomial fits to saturation vapor pressure, J. Appl. Meteorol. 31,
    1507 (1992), water, relative error norm, -85 to 70 deg C: an exponential would be no vector code.
    """
    x = temperature - 273.15
    es = 6.11239921 + x * (0.443987641 + x * (0.142986287e-1 + x * (0.264847430e-3 + x * (0.302950461e-5 + x * (
        0.206739458e-7 + x * (0.640689451e-10 + x * (-0.952447341e-13 - x * 0.976195544e-15)))))))  # fmt: skip
    slope = 0.443987641 + x * (2.0 * 0.142986287e-1 + x * (3.0 * 0.264847430e-3 + x * (4.0 * 0.302950461e-5 + x * (
        5.0 * 0.206739458e-7 + x * (6.0 * 0.640689451e-10 + x * (7.0 * -0.952447341e-13 - x * 8.0 * 0.976195544e-15))
    ))))  # fmt: skip
    dry = pressure - (1.0 - EPSILON) * 100.0 * es
    q = 1e5 * EPSILON * es / dry
    return q, 1e5 * EPSILON * slope * pressure / (dry * dry)


@kernel(fastmath=FAST)
def condensate(theta_l: float, water: float, pressure: float, exner: float, warming: float = LATENT / CP * G) -> float:
    """Return the cloud water q_c (g/kg) with which vapour is not supersaturated: Newton's method, four steps.

    q_c = q_t - q_s(T), T = Pi theta_l + L/cp q_c. The first step, from T = Pi theta_l, is the usual linear one; four
    leave less than 1e-8 g/kg.
    """
    cold = exner * theta_l
    temperature = cold
    liquid = 0.0
    for _ in range(4):
        q, slope = saturation(temperature, pressure)
        liquid = liquid + (water - q - liquid) / (1.0 + warming * slope)
        temperature = cold + warming * liquid
    return max(liquid, 0.0)


@kernel(fastmath=FAST)
def virtual(theta_l: float, water: float, liquid: float, rain: float, exner: float, warming: float) -> float:
    """Return theta_v = theta (1 + .608 q_v - q_c - q_r)."""
    theta = theta_l + warming / exner * liquid
    return theta * (1.0 + G * (VIRTUAL * (water - liquid) - liquid - rain))


@kernel(fastmath=FAST)
def saturation_adjustment(
    theta_l: Any,
    water: Any,
    rain: Any,
    theta_0: float,
    warming: float,
    pressure: Any,
    exner: Any,
    liquid: Any,
    theta_v: Any,
    mean: Any,
) -> None:
    """Set cloud water and theta_v of all cells, and the horizontal mean (nz,) of theta_v.

    Parameters
    ----------
    theta_l, water, rain : ndarray
        Fields; theta_l less theta_0. ``rain`` may have no column: there is none.
    theta_0, warming : float
        Of the reference state, K.
    pressure, exner : ndarray
        Reference state (nz,), double precision.
    liquid, theta_v : ndarray
        Results; theta_v less theta_0.
    mean : ndarray
        Mean of theta_v less theta_0, in double precision.
    """
    nx, ny, nz = theta_l.shape
    rains = rain.shape[0] > 0
    mean[:] = 0.0
    falling, excess, here = np.zeros(nz), np.empty(nz), np.empty(nz)
    for i in range(nx):
        for j in range(ny):
            if rains:
                for k in range(nz):
                    falling[k] = rain[i, j, k]
            for k in range(nz):
                here[k] = theta_0 + theta_l[i, j, k]
                excess[k] = water[i, j, k] - saturation(exner[k] * here[k], pressure[k])[0]
            for k in range(nz):
                # most cells are clear, and need no iteration
                excess[k] = (
                    condensate(here[k], water[i, j, k], pressure[k], exner[k], warming) if excess[k] > 0.0 else 0.0
                )
            for k in range(nz):
                value = virtual(here[k], water[i, j, k], excess[k], falling[k], exner[k], warming) - theta_0
                liquid[i, j, k] = excess[k]
                theta_v[i, j, k] = value
                mean[k] += value
    mean[:] /= nx * ny


@kernel(fastmath=FAST)
def add_buoyancy(theta_v: Any, mean: Any, per_theta: Any, tendency: Any) -> None:
    """Add g (theta_v - mean) / theta_v of the reference state, interpolated to faces, to the tendency of w.

    Parameters
    ----------
    theta_v, mean : ndarray
        Field and its horizontal mean (nz,).
    per_theta : ndarray
        g / theta_v of the reference state times the weight of the level, for the face above (0,) and below (1,) it.
    tendency : ndarray
        (nx, ny, nz + 1).
    """
    nx, ny, nz = theta_v.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(1, nz):
                tendency[i, j, k] += per_theta[0, k - 1] * (theta_v[i, j, k - 1] - mean[k - 1]) + per_theta[1, k] * (
                    theta_v[i, j, k] - mean[k]
                )
