"""Position of the sun by the NREL solar position algorithm."""

from __future__ import annotations

import importlib.machinery
import importlib.util
from datetime import datetime
from functools import cache
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array

__all__ = ["sun_position"]

SEA_LEVEL_PRESSURE_HPA = 1013.25
AIR_TEMPERATURE_C = 12.0
HORIZON_REFRACTION_DEG = 0.5667
DELTA_T_S = 0.0
"""TT - UT1. The paper's tables use 0; the true 69 s of 2019 move the sun by less than 0.001 deg."""


def sun_position(
    times: list[datetime], latitude_deg: Array | float, longitude_deg: Array | float
) -> tuple[Array, Array, Array]:
    """Return apparent zenith, azimuth and distance of the sun as seen from sea level.

    Parameters
    ----------
    times : list of datetime (F,)
        Instants with a time zone.
    latitude_deg, longitude_deg : float or ndarray (F,)
        North and east positive; longitudes above 180 are allowed.

    Returns
    -------
    zenith_deg, azimuth_deg, distance_au : ndarray (F,)
        Refracted zenith angle, bearing clockwise from north, Earth-Sun distance.

    Raises
    ------
    ValueError
        If an instant lacks a time zone.

    References
    ----------
    I. Reda and A. Andreas, "Solar position algorithm for solar radiation applications", NREL/TP-560-34302 (2008), as
    implemented by pvlib.
    """
    if any(time.tzinfo is None for time in times):
        raise ValueError("time without zone: give an offset, for example +00:00")
    spa = _algorithm()
    unix = np.array([time.timestamp() for time in times], dtype=np.float64)
    longitude = (longitude_deg + 180.0) % 360.0 - 180.0
    air = SEA_LEVEL_PRESSURE_HPA, AIR_TEMPERATURE_C, DELTA_T_S, HORIZON_REFRACTION_DEG
    place_and_air = (unix, latitude_deg, longitude, 0.0, *air)
    zenith, _, _, _, azimuth, _ = spa.solar_position(*place_and_air)
    distance = spa.solar_position(*place_and_air, esd=True)[0]
    return np.asarray(zenith), np.asarray(azimuth), np.asarray(distance)


@cache
def _algorithm() -> Any:
    """Return the module ``pvlib.spa`` without importing the package around it.

    ``import pvlib`` imports pandas and more: one to five seconds, a third of the start of a run, for one module that
    needs none of it.
    """
    package = importlib.util.find_spec("pvlib")
    if package is not None and package.submodule_search_locations is not None:
        spec = importlib.machinery.PathFinder.find_spec("spa", package.submodule_search_locations)
        if spec is not None and spec.loader is not None:
            module = importlib.util.module_from_spec(spec)
            try:
                spec.loader.exec_module(module)
                return module
            except ImportError:  # a version of pvlib whose module does need the rest
                pass
    from pvlib import spa

    return spa
