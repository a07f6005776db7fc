"""Arguments of sea models: cosines and bearings."""

from __future__ import annotations

import numpy as np

from hcss_twin.providers import Array


def directions(field: str, cosines: Array) -> Array:
    """Return cosines (M,) as float64.

    Raises
    ------
    ValueError
        If they do not have one axis or leave (0, 1].
    """
    values = np.asarray(cosines, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"{field} of shape {values.shape}: needs one axis (M,)")
    if not np.all((values > 0.0) & (values <= 1.0)):
        raise ValueError(f"{field} between {np.min(values)} and {np.max(values)}: allowed 0 < {field} <= 1")
    return values


def bearings(wind_azimuth: Array | None, count: int) -> Array | None:
    """Return bearings to the wind (count,) as float64, or None where there are none.

    Raises
    ------
    ValueError
        If their number is another, or one is not finite.
    """
    if wind_azimuth is None:
        return None
    values = np.asarray(wind_azimuth, dtype=np.float64)
    if values.shape != (count,) or not np.all(np.isfinite(values)):
        raise ValueError(f"wind_azimuth of shape {values.shape}: needs ({count},), finite radians")
    return values


def relative_azimuths(relative_azimuth: Array) -> Array:
    """Return angles between the bearings toward sensor and source (M,) as float64.

    Raises
    ------
    ValueError
        If one leaves [0, pi].
    """
    values = np.asarray(relative_azimuth, dtype=np.float64)
    if not np.all((values >= 0.0) & (values <= np.pi)):
        raise ValueError(
            f"relative_azimuth between {np.min(values)} and {np.max(values)}: allowed 0 to pi rad"
        )
    return values
