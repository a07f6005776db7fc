"""Directions of the view, the sun and the Gauss streams."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geometry import wind_azimuths
from hcss_twin.physics.multiple_scattering.directions import Streams, gauss_streams
from hcss_twin.providers import Sun, View

VIEW = 0
"""Index of the view among the directions."""


@dataclass(frozen=True)
class ColumnDirections:
    """The view first, then the streams.

    Attributes
    ----------
    mu : ndarray (1 + N,)
        Cosines of the zenith angles.
    zenith_deg : tuple of float (1 + N,)
    streams : Streams
        Nodes and weights on (0, 1).
    sun : Sun or None
        None where the sun is down or left out.
    mu_sun : float
        Cosine of its zenith angle; 0 without a sun.
    relative_azimuth : float
        Of view and sun, radians; 0 without a sun.
    wind_azimuth : float
        Bearing of the sensor minus the bearing that the wind comes from, radians, counted such that the azimuth of the
        sun is wind_azimuth + relative_azimuth.
    """

    mu: Array
    zenith_deg: tuple[float, ...]
    streams: Streams
    sun: Sun | None
    mu_sun: float
    relative_azimuth: float
    wind_azimuth: float

    @property
    def count(self) -> int:
        """Number of streams N."""
        return self.streams.mu.size

    @property
    def stream_indices(self) -> range:
        """Indices of the streams among the directions."""
        return range(1, 1 + self.count)


@lru_cache(maxsize=1024)
def column_directions(view: View, sun: Sun | None, wind_from_deg: float, streams: int) -> ColumnDirections:
    """Return the directions of a column; a sun below the horizon is ignored."""
    gauss = gauss_streams(streams)
    mu_view = math.cos(math.radians(view.zenith_deg))
    zenith = (view.zenith_deg, *(math.degrees(math.acos(mu)) for mu in gauss.mu))
    up = sun if sun is not None and sun.is_up else None
    sun_azimuth_deg = view.azimuth_deg if up is None else up.azimuth_deg
    relative, wind = wind_azimuths(view.azimuth_deg, sun_azimuth_deg, wind_from_deg)
    return ColumnDirections(
        mu=np.concatenate(([mu_view], gauss.mu)),
        zenith_deg=zenith,
        streams=gauss,
        sun=up,
        mu_sun=0.0 if up is None else math.cos(math.radians(up.zenith_deg)),
        relative_azimuth=relative,
        wind_azimuth=wind,
    )
