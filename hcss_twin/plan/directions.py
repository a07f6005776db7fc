"""Directions toward the sensor, between which radiance is tabulated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
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

    def of_place(self, of_centre: Sun) -> Sun:
        """Return the sun of the place, which may have set."""
        if self.place_deg == self.centre_deg:
            return of_centre
        angles_deg = of_centre.zenith_deg, of_centre.azimuth_deg
        zenith, azimuth = from_another_place_deg(*angles_deg, self.centre_deg, self.place_deg)
        return Sun(zenith, (azimuth - self.turn_deg) % 360.0, of_centre.distance_au)

    def sun(self, of_centre: Sun | None) -> Sun | None:
        """Return the sun of the place, or that of the centre where it has set at the place."""
        there = None if of_centre is None else self.of_place(of_centre)
        return of_centre if there is None or not there.is_up else there

    @classmethod
    def of_places(
        cls, views: Iterable[View], centre_deg: tuple[float, float], north: Array, east: Array, turn: Array
    ) -> list[SunlitView]:
        """Return views of places (N,): latitude, longitude and turn in degrees."""
        places = zip(views, north.tolist(), east.tolist(), turn.tolist(), strict=True)
        return [
            cls(view.zenith_deg, view.azimuth_deg, centre_deg, (latitude, longitude), turned)
            for view, latitude, longitude, turned in places
        ]


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


@dataclass(frozen=True)
class PassingView(View):
    """View along which a sequence sees one place after another, each with a sun of its own.

    Attributes
    ----------
    centre_deg : (float, float)
        Latitude and longitude of the centre of the scene.
    seen_m : tuple of (float, float)
        Place east and north of the centre, as a polynomial of the time: coefficients from order 0 on.
    span_s : (float, float)
        Middle and half of the time of the sequence, in which polynomials are.
    """

    centre_deg: tuple[float, float]
    seen_m: tuple[tuple[float, float], ...]
    span_s: tuple[float, float]

    def at(self, time_s: float) -> SunlitView:
        """Return the view of the place that is seen at a time."""
        seen_m = np.polynomial.polynomial.polyval((time_s - self.span_s[0]) / self.span_s[1], np.array(self.seen_m))
        placed = Ellipsoid.to_geographic_with_turn(seen_m[:1], seen_m[1:], *self.centre_deg)
        return SunlitView.of_places([self], self.centre_deg, *placed)[0]

    def sun(self, of_centre: Sun | None) -> Sun | None:
        """Return the sun of the place that is seen at its time, or in the middle of the sequence if it has none."""
        if of_centre is None:
            return None
        return self.at(self.span_s[0] if of_centre.time_s is None else of_centre.time_s).sun(of_centre)


@dataclass(frozen=True, eq=False)
class SunlitDirections:
    """Directions of which each has the sun of the place that is seen along it at a time.

    Attributes
    ----------
    directions : Directions
        Whose places have the sun of the centre.
    centre_deg : (float, float)
        Latitude and longitude of the centre of the scene.
    coefficients : ndarray (20, 2)
        Of the place, m east and north of the centre, as a polynomial of position and time (:func:`powers`).
    span_s : (float, float)
        Middle and half of the time of the sequence; the half is 1 s if it has one frame.
    """

    directions: Directions
    centre_deg: tuple[float, float]
    coefficients: Array
    span_s: tuple[float, float]
    suns: None = None

    def at(self, places: Iterable[tuple[float, float]]) -> list[View]:
        """Return the view from positions."""
        return [*self.passing(places)]

    def passing(self, places: Iterable[tuple[float, float]]) -> list[PassingView]:
        """Return the view from positions, with the places that it sees."""
        places = list(places)
        x, y = np.array(places, dtype=np.float64).reshape(-1, 2).T
        terms = powers(x, y, np.ones_like(x))
        seen_m = np.stack([terms[:, some] @ self.coefficients[some] for some in OF_TIME], axis=1)
        return [
            PassingView(view.zenith_deg, view.azimuth_deg, self.centre_deg, tuple(map(tuple, of_times)), self.span_s)
            for view, of_times in zip(self.directions.at(places), seen_m.tolist(), strict=True)
        ]

    def of_places(self, views: Sequence[View], east_m: Array, north_m: Array) -> list[View]:
        """Return views with the sun of places."""
        placed = Ellipsoid.to_geographic_with_turn(east_m, north_m, *self.centre_deg)
        return [*SunlitView.of_places(views, self.centre_deg, *placed)]


ORDER = 3
"""Of the polynomial of position and time."""

EXPONENTS = [
    (x, y, time) for time in range(ORDER + 1) for x in range(ORDER + 1 - time) for y in range(ORDER + 1 - time - x)
]
"""Of position and time in its terms, by that of the time."""

OF_TIME = [[number for number, each in enumerate(EXPONENTS) if each[2] == time] for time in range(ORDER + 1)]
"""Which terms have a power of the time."""


def powers(x: Array, y: Array, time: Array) -> Array:
    """Return the terms (..., 20) of the polynomial."""
    return np.stack([x**of_x * y**of_y * time**of_time for of_x, of_y, of_time in EXPONENTS], axis=-1)
