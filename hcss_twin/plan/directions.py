"""Directions toward the sensor, between which radiance is tabulated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.viewing import from_another_place_deg
from hcss_twin.providers import Sun, View


@dataclass(frozen=True)
class SunlitView(View):
    """View of a place at which the sun stands elsewhere in the sky than at the image centre.

    Attributes
    ----------
    centre_deg, place_deg : (float, float)
        Latitude and longitude of the image centre and of the place.
    turn_deg : float
        Bearing of the plane's y axis at the place, clockwise from its north; azimuths count from this axis.
    """

    centre_deg: tuple[float, float]
    place_deg: tuple[float, float]
    turn_deg: float

    def sun(self, of_centre: Sun) -> Sun:
        """Return the sun of the place, or that of the centre where it has set at the place."""
        if self.place_deg == self.centre_deg:
            return of_centre
        angles_deg = of_centre.zenith_deg, of_centre.azimuth_deg
        zenith, azimuth = from_another_place_deg(*angles_deg, self.centre_deg, self.place_deg)
        there = replace(of_centre, zenith_deg=zenith, azimuth_deg=(azimuth - self.turn_deg) % 360.0)
        return there if there.is_up else of_centre


def sun_toward(view: View, sun: Sun | None) -> Sun | None:
    """Return the sun of the place that is seen, from that of the image centre."""
    return view.sun(sun) if isinstance(view, SunlitView) and sun is not None else sun


class Views(Protocol):
    """The view from any position in a rectangle."""

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions (x, y), -1 to 1 from edge to edge."""
        ...


class Directions(Views, Protocol):
    """All directions of a sequence as a rectangle of coordinates in which radiance is smooth."""

    @property
    def suns(self) -> Callable[[View], list[Sun | None]] | None:
        """Returns the suns of the place of a view at some frames; None if all places have one sun."""
        ...


@dataclass(frozen=True, eq=False)
class SunlitDirections:
    """Directions of which each has the sun of the place that is seen along it.

    Attributes
    ----------
    directions : Directions
        Whose places have the sun of the centre.
    centre_deg : (float, float)
        Latitude and longitude of the centre of the scene.
    coefficients : ndarray (6, 2)
        Of the place, m east and north of the centre, as a polynomial of second order of the position.
    """

    directions: Directions
    centre_deg: tuple[float, float]
    coefficients: Array
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions."""
        places = list(places)
        x, y = np.array(places, dtype=np.float64).reshape(-1, 2).T
        return self.of_places(self.directions.at(places), *(second_order(x, y) @ self.coefficients).T)

    def of_places(self, views: Sequence[View], east_m: Array, north_m: Array) -> list[View]:
        """Return views with the sun of places."""
        angles = Ellipsoid.to_geographic_with_turn(east_m, north_m, *self.centre_deg)
        return [
            SunlitView(view.zenith_deg, view.azimuth_deg, self.centre_deg, (north, east), turn)
            for view, north, east, turn in zip(views, *(each.tolist() for each in angles), strict=True)
        ]


def second_order(x: Array, y: Array) -> Array:
    """Return the powers (N, 6) of positions up to the second order."""
    return np.stack((np.ones_like(x), x, y, x**2, x * y, y**2), axis=-1)
