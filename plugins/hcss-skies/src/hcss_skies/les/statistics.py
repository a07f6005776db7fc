"""Means over the box: profiles and numbers that publications of cases report."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_skies.les.clouds import CLOUDY_G_KG
from hcss_skies.les.model import Model
from hcss_twin.providers import Array

PROFILES = {
    "theta_l": ("K", "liquid-water potential temperature"),
    "total_water": ("g kg-1", "vapour and cloud water"),
    "cloud_water": ("g kg-1", "cloud water"),
    "rain_water": ("g kg-1", "rain water"),
    "cloud_fraction": ("1", f"fraction of cells with more than {CLOUDY_G_KG:g} g/kg of cloud water"),
    "cloud_w": ("m s-1", "mean vertical velocity of cloudy cells; 0 without"),
    "u": ("m s-1", "velocity along x over the sea"),
    "v": ("m s-1", "velocity along y over the sea"),
    "w_variance": ("m2 s-2", "variance of the vertical velocity"),
    "w_third_moment": ("m3 s-3", "third moment of the vertical velocity"),
    "horizontal_variance": ("m2 s-2", "sum of the variances of both horizontal velocities"),
    "theta_l_flux": ("K m s-1", "resolved vertical flux of theta_l"),
    "water_flux": ("g kg-1 m s-1", "resolved vertical flux of total water"),
    "theta_v_flux": ("K m s-1", "resolved vertical flux of virtual potential temperature"),
}
"""Profiles (nz,) with units and description."""

SERIES = {
    "cloud_cover": ("1", f"fraction of columns with a cell of more than {CLOUDY_G_KG:g} g/kg of cloud water"),
    "mean_liquid_water_path": ("g m-2", "mean over all columns"),
    "highest_top": ("m", "of all clouds; 0 without"),
    "lowest_base": ("m", "of all clouds; 0 without"),
    "inversion_height": ("m", "height of the steepest mean theta_l"),
    "fastest_updraught": ("m s-1", "largest vertical velocity"),
    "rain_on_sea": ("mm", "since the start"),
    "water_error": ("1", "water that no source explains in the last step, as a part of all water"),
    "time_step": ("s", "last step"),
}
"""Numbers with units and description."""


def _mean(field: Any) -> Array:
    mean: Array = field.mean(axis=(0, 1), dtype=np.float64)
    return mean


def profiles(model: Model) -> dict[str, Array]:
    """Return the profiles of the present state."""
    w = 0.5 * (model.w[:, :, 1:] + model.w[:, :, :-1])
    frame = model.case.air.frame_m_s
    cloudy = model.liquid > CLOUDY_G_KG

    def departure(field: Array) -> Array:
        return field - _mean(field).astype(field.dtype)

    u, v = departure(model.u), departure(model.v)
    return {
        "theta_l": _mean(model.theta_l) + model.reference.theta_0_K,
        "total_water": _mean(model.water),
        "cloud_water": _mean(model.liquid),
        "rain_water": _mean(model.rain) if model.case.rain else np.zeros(model.mesh.levels),
        "cloud_fraction": _mean(cloudy),
        "cloud_w": _mean(w * cloudy) / np.maximum(_mean(cloudy), 1e-12),
        "u": _mean(model.u) + frame[0],
        "v": _mean(model.v) + frame[1],
        "w_variance": _mean(w * w),
        "w_third_moment": _mean(w * w * w),
        "horizontal_variance": _mean(u * u) + _mean(v * v),
        "theta_l_flux": _mean(w * departure(model.theta_l)),
        "water_flux": _mean(w * departure(model.water)),
        "theta_v_flux": _mean(w * departure(model.theta_v)),
    }


def series(model: Model) -> dict[str, float]:
    """Return the numbers of the present state."""
    mesh = model.mesh
    cloudy = model.liquid > CLOUDY_G_KG
    levels = np.flatnonzero(cloudy.any(axis=(0, 1)))
    slope = np.diff(_mean(model.theta_l)) / np.diff(mesh.centres_m)
    inner = mesh.faces_m[1:-1] < model.case.grid.sponge_bottom_m
    return {
        "cloud_cover": float(cloudy.any(axis=2).mean()),
        "mean_liquid_water_path": float(_mean(model.liquid) @ model.mass),
        "highest_top": mesh.floor_m + float(mesh.faces_m[levels[-1] + 1]) if len(levels) else 0.0,
        "lowest_base": mesh.floor_m + float(mesh.faces_m[levels[0]]) if len(levels) else 0.0,
        "inversion_height": mesh.floor_m + float(mesh.faces_m[1:-1][inner][slope[inner].argmax()]),
        "fastest_updraught": float(model.w.max()),
        "rain_on_sea": model.rain_on_sea_kg_m2,
        "water_error": model.budget.water_error,
        "time_step": model.step_s,
    }
