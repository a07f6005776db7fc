"""Arguments of sea models: cosines, and bearings counted from the wind."""

from __future__ import annotations

import numpy as np

from hcss_twin.providers import Array


def wind_azimuths(
    sensor_azimuth_deg: float, sun_azimuth_deg: float, wind_from_deg: float
) -> tuple[float, float]:
    """Return (relative_azimuth, wind_azimuth) in radians for bearings in degrees clockwise from north.

    The slopes are mirror-symmetric about the wind, so that the sense of counting may be turned until the sun
    lies at wind_azimuth + relative_azimuth with relative_azimuth in [0, pi].
    """
    difference = (sun_azimuth_deg - sensor_azimuth_deg + 180.0) % 360.0 - 180.0
    sense = 1.0 if difference >= 0.0 else -1.0
    bearing = sense * (sensor_azimuth_deg - wind_from_deg)
    return float(np.radians(abs(difference))), float(np.radians(bearing % 360.0))


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
