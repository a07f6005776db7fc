"""A case from a sounding: what a user measured of the air, and what is estimated where it is not given."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_skies.les.case import Case, case_of
from hcss_skies.les.thermodynamics import CP, EPSILON, GRAVITY, P_0, R_DRY
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError

LIMITS = {
    "height_m": (0.0, 2e4), "temperature_K": (200.0, 330.0), "theta_K": (230.0, 450.0), "water_g_kg": (0.0, 40.0),
    "relative_humidity": (0.0, 1.0), "u_m_s": (-80.0, 80.0), "v_m_s": (-80.0, 80.0),
}  # fmt: skip
"""Columns of a file with the least and the greatest value."""

COOLING_K_DAY = 2.0
"""Of clear air by radiation, where none is given (the trade-wind cases have 2 to 2.5)."""

EARTH_S = 7.292e-5
"""Angular velocity of the earth, s-1."""


@dataclass(frozen=True)
class Sounding:
    """Air over the sea.

    Attributes
    ----------
    height_m, theta_K, water_g_kg, u_m_s, v_m_s : ndarray
        Profiles (n,), ascending.
    humidity : ndarray
        Relative humidity (n,).
    pressure_Pa : float
        At the sea.
    """

    height_m: Array
    theta_K: Array
    water_g_kg: Array
    u_m_s: Array
    v_m_s: Array
    humidity: Array
    pressure_Pa: float

    @property
    def inversion_m(self) -> float:
        """Height of the steepest rise of theta over 100 m, between 200 m and 4 km; the middle of a layer with it."""
        z = np.arange(200.0, min(4000.0, self.height_m[-1]) - 100.0, 10.0)
        rise = np.interp(z + 100.0, self.height_m, self.theta_K) - np.interp(z, self.height_m, self.theta_K)
        return float(z[rise >= 0.99 * rise.max()].mean() + 50.0)


def read_sounding(path: Path, pressure_Pa: float, wind_m_s: tuple[float, float] | None) -> Sounding:
    """Read a file of comma-separated columns with a line of names: height_m, temperature_K or theta_K, ...

    Parameters
    ----------
    path : Path
        With water_g_kg or relative_humidity (0 to 1), too, and u_m_s and v_m_s unless a wind is given.
    pressure_Pa : float
        At the sea.
    wind_m_s : tuple of float, optional
        Of all heights.

    Raises
    ------
    CatalogError
        With the column, line and value that is wrong, and what is allowed.
    """
    columns = _columns(path)
    z = columns["height_m"]
    if len(z) < 4 or np.any(np.diff(z) <= 0.0) or z[-1] < 1500.0:
        raise CatalogError(
            f"{path}: height_m: {len(z)} heights to {z[-1]:g} m; allowed: 4 or more, ascending, to 1500 m"
        )
    if wind_m_s is None and not {"u_m_s", "v_m_s"} <= columns.keys():
        raise CatalogError(f"{path}: u_m_s and v_m_s: missing; add these columns, or give --wind")
    for choice in (("temperature_K", "theta_K"), ("water_g_kg", "relative_humidity")):
        given = [name for name in choice if name in columns]
        if len(given) != 1:
            raise CatalogError(f"{path}: {' and '.join(given) or 'neither'} given; allowed: one of {', '.join(choice)}")
    exner = np.empty_like(z)
    theta, kelvin = np.empty_like(z), np.empty_like(z)
    below, height, last = (pressure_Pa / P_0) ** (R_DRY / CP), 0.0, None
    for k in range(len(z)):
        exner[k] = below
        for _ in range(5):
            theta[k] = columns["theta_K"][k] if "theta_K" in columns else columns["temperature_K"][k] / exner[k]
            layer = theta[k] if last is None else 0.5 * (theta[k] + last)
            exner[k] = below - GRAVITY / CP * (z[k] - height) / layer
        kelvin[k] = theta[k] * exner[k]
        below, height, last = exner[k], z[k], theta[k]
    pressure = P_0 * exner ** (CP / R_DRY)
    vapour = 611.2 * np.exp(17.67 * (kelvin - 273.15) / (kelvin - 29.65))  # Bolton 1980, eq. 10
    saturated = 1e3 * EPSILON * vapour / (pressure - (1.0 - EPSILON) * vapour)
    water = columns["water_g_kg"] if "water_g_kg" in columns else columns["relative_humidity"] * saturated
    names = "u_m_s", "v_m_s"
    wind = [columns[name] if wind_m_s is None else np.full(len(z), wind_m_s[n]) for n, name in enumerate(names)]
    return Sounding(z, theta, water, wind[0], wind[1], water / saturated, pressure_Pa)


def _columns(path: Path) -> dict[str, Array]:
    with Reading(path, CatalogError, "not a readable CSV file"), path.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if row]
    names = [name.strip() for name in rows[0]] if rows else []
    unknown = [name for name in names if name not in LIMITS]
    if unknown or "height_m" not in names or len(set(names)) != len(names):
        raise CatalogError(
            f"{path}: columns {', '.join(names) or 'none'}; allowed: height_m and of {', '.join(LIMITS)}"
        )
    values = np.empty((len(rows) - 1, len(names)))
    for line, row in enumerate(rows[1:]):
        for n, name in enumerate(names):
            text = row[n] if n < len(row) else ""
            low, high = LIMITS[name]
            try:
                number = float(text)
            except ValueError:
                number = math.nan
            if len(row) != len(names) or not low <= number <= high:
                raise CatalogError(f"{path}: {name} in line {line + 2}: '{text}' given; allowed: {low:g} to {high:g}")
            values[line, n] = number
    return {name: values[:, n] for n, name in enumerate(names)}


def case_of_sounding(
    sounding: Sounding,
    sea_K: float,
    *,
    latitude_deg: float = 25.0,
    cooling_K_day: float | None = None,
    subsidence_m_s: float | None = None,
    changed: dict[str, dict[str, object]],
) -> tuple[Case, list[str]]:
    """Return the case of a sounding, and what was estimated for it, in words.

    Parameters
    ----------
    sounding : Sounding
        The air; its wind is taken as geostrophic.
    sea_K : float
        Temperature of the sea.
    latitude_deg : float
        For the earth's rotation.
    cooling_K_day : float, optional
        Of clear air.
    subsidence_m_s : float, optional
        Of the air at and above the inversion, positive downward. By default the one whose warming of the air above the
        inversion balances the cooling.
    changed : dict
        Values that replace those chosen, by section.

    Raises
    ------
    CatalogError
        If a value is not allowed.
    """
    notes = []
    inversion = sounding.inversion_m
    top = min(float(sounding.height_m[-1]), max(1.5 * inversion, inversion + 1200.0))
    if top < inversion + 400.0:
        raise CatalogError(
            f"the sounding ends at {sounding.height_m[-1]:g} m, {top - inversion:.0f} m above the steepest rise of "
            f"theta at {inversion:.0f} m; allowed: 400 m and more"
        )
    cooling = COOLING_K_DAY if cooling_K_day is None else cooling_K_day
    if cooling_K_day is None:
        notes.append(f"clear air cools by {cooling:g} K a day (as in trade-wind cases)")
    at = np.array([0.5 * (inversion + top), top])
    slope = float(np.diff(np.interp(at, sounding.height_m, sounding.theta_K))[0] / np.diff(at)[0])
    sinking = subsidence_m_s
    if sinking is None:
        sinking = min(max(cooling / 86400.0 / max(slope, 1e-4), 0.0), 0.015)
        notes.append(
            f"air sinks by {1e3 * sinking:.2g} mm/s above the inversion at {inversion:.0f} m, which balances that"
        )
    z = [float(h) for h in sounding.height_m if 0.0 < h < top]
    heights = [0.0, *z, top]

    def pairs(values: Array) -> list[list[float]]:
        return [[h, float(np.interp(h, sounding.height_m, values))] for h in heights]

    frame = [float(np.interp(inversion * 0.6, sounding.height_m, wind)) for wind in (sounding.u_m_s, sounding.v_m_s)]
    thin = inversion < 1200.0
    fine = [(0.0, 20.0), (max(inversion - 350.0, 1.0), 20.0), (max(inversion - 150.0, 2.0), 8.0)]
    fine += [(inversion + 150.0, 8.0), (inversion + 400.0, 25.0)]
    table: dict[str, dict[str, object]] = {
        "grid": {
            "columns": [96, 96], "side_m": 50.0 if thin else 100.0, "top_m": top, "spacing_m": fine if thin else 40.0,
            "sponge_bottom_m": top - min(0.25 * top, 0.6 * (top - inversion)),
        },
        "air": {
            "surface_pressure_Pa": sounding.pressure_Pa, "theta_l_K": pairs(sounding.theta_K),
            "water_g_kg": pairs(sounding.water_g_kg), "u_m_s": pairs(sounding.u_m_s), "v_m_s": pairs(sounding.v_m_s),
            "frame_m_s": frame, "noise_below_m": inversion,
        },
        "forcing": {
            "coriolis_s": 2.0 * EARTH_S * math.sin(math.radians(latitude_deg)),
            "geostrophic_u_m_s": pairs(sounding.u_m_s), "geostrophic_v_m_s": pairs(sounding.v_m_s),
            "subsidence_m_s": [[0.0, 0.0], [inversion, -sinking], [top, -sinking]], "theta_l_K_day": [[0.0, -cooling]],
        },
        # neutral coefficients over sea (van Zanten et al. 2011, section 2)
        "surface": {"sea_K": sea_K, "drag": 0.001229, "heat_coefficient": 0.001094, "water_coefficient": 0.001133},
        "output": {"hours": 4.0, "spin_up_hours": 2.0},
    }  # fmt: skip
    layered = sounding.humidity[(sounding.height_m < inversion + 50.0) & (sounding.height_m > 0.5 * inversion)]
    if layered.size and layered.max() > 0.97:
        law = {"f_0_W_m2": 70.0, "f_1_W_m2": 22.0, "kappa_m2_kg": 85.0, "divergence_s": 0.0, "density_kg_m3": 1.1}
        across = np.interp([inversion - 100.0, inversion + 150.0], sounding.height_m, sounding.water_g_kg)
        table["radiation"] = {**law, "inversion_water_g_kg": float(max(across.mean(), 1e-3))}
        notes.append("the air below the inversion is nearly saturated: cloud cools by the two-stream law of DYCOMS-II")
    for name, values in changed.items():
        table[name] = {**table.get(name, {}), **values}
    case = case_of({"title": "Clouds of a sounding", "source": "a sounding of the user", **table}, "sounding")
    return case, notes
