"""Profiles at several places from one NetCDF file, interpolated to any place between them.

Each profile of the file is checked, completed and resampled at the altitudes of the profile nearest to the image
centre. At these altitudes, temperature, the logarithm of pressure and the gases are interpolated in latitude and
longitude: linearly between two places, by monotone cubics (PCHIP) between more. Like linear interpolation, monotone
cubics stay between the neighbouring values; unlike it, they have no kinks, which the polynomials over the views of an
image could not follow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.reading import Reading
from hcss_twin.models.atmosphere.sounding import UNREADABLE, ProfileVariable, Sounding, profile_variables, sounding_of
from hcss_twin.models.atmosphere.time_choice import TimeChoice, values_of
from hcss_twin.physics.profile import Profile

PLACES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"latitude": ("latitude", "lat"), "longitude": ("longitude", "lon")}
)
"""Accepted names of the coordinates in a file."""


@dataclass(frozen=True)
class SoundingGrid:
    """Soundings on a grid of latitudes and longitudes.

    Attributes
    ----------
    name : str
        Name of the file as the user gave it, for messages.
    latitude_deg, longitude_deg : ndarray (N,), (M,)
        Ascending; a single value means that the soundings do not depend on this coordinate.
    variables : tuple of ProfileVariable
        Labels and units only: the file is closed.
    values : tuple of ndarray (N or 1, M or 1, L)
        Values of the variables, in the units of the file.
    """

    name: str
    latitude_deg: Array
    longitude_deg: Array
    variables: tuple[ProfileVariable, ...]
    values: tuple[Array, ...]
    notes: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: Path, name: str, time: datetime | None = None) -> Self | None:
        """Read a file; None if it holds only one place.

        Raises
        ------
        CatalogError
            If the file is not readable, a coordinate is not monotonic, or a variable has other dimensions.
        """
        with Reading(path, CatalogError, UNREADABLE).netcdf() as dataset:
            axes = [_axis(dataset, name, coordinate) for coordinate in PLACES]
            if axes == [None, None]:
                return None
            choice = TimeChoice.of(dataset, name, time)
            variables = profile_variables(dataset, name)
            places = [axis and axis[0] for axis in axes]
            values = [_by_place(variable, choice.values_of(variable.data), name, places) for variable in variables]
        degrees = []
        for number, axis in enumerate(axes):
            given = np.zeros(1) if axis is None else axis[1]
            order = np.argsort(given)
            degrees.append(given[order])
            values = [value if value.shape[number] == 1 else np.take(value, order, axis=number) for value in values]
        west, east = degrees[1][0], degrees[1][-1]
        if degrees[1].size > 1 and east - west + 1.001 * np.max(np.diff(degrees[1])) >= 360.0 > east - west:
            degrees[1] = np.append(degrees[1], west + 360.0)  # around the globe
            values = [
                value if value.shape[1] == 1 else np.concatenate((value, value[:, :1]), axis=1) for value in values
            ]
        without_data = tuple(replace(variable, data=None) for variable in variables)
        return cls(name, degrees[0], degrees[1], without_data, tuple(values), choice.notes)

    def node(self, row: int, column: int) -> Sounding:
        """Return the sounding of the file at one of its places.

        Raises
        ------
        CatalogError
            If it is incomplete or unphysical; the message names place and level.
        """
        coordinates = [
            f"{degrees[index]:g} {unit}"
            for degrees, index, unit in ((self.latitude_deg, row, "N"), (self.longitude_deg, column, "E"))
            if degrees.size > 1
        ]
        values = [value[min(row, value.shape[0] - 1), min(column, value.shape[1] - 1)] for value in self.values]
        return sounding_of(f"{self.name} at {' '.join(coordinates)}", self.variables, values, self.notes)

    def eastward(self, longitude_deg: float) -> float:
        """Return a longitude in the range used by the file, for example 0 to 360."""
        return longitude_deg + 360.0 * float(np.ceil((self.longitude_deg[0] - longitude_deg) / 360.0))


@dataclass(frozen=True)
class ProfileField:
    """Atmospheric profiles at any place within a grid of soundings.

    Attributes
    ----------
    grid : SoundingGrid
    built : callable
        Returns the checked and completed profile at a row and column of the grid.
    altitude_m : ndarray (K,) or None
        Levels of the interpolated profiles; None before :meth:`with_levels_near`.
    """

    grid: SoundingGrid
    built: Callable[[int, int], Profile]
    altitude_m: Array | None = None

    def with_levels_near(self, latitude_deg: float, longitude_deg: float) -> ProfileField:
        """Return the field with the levels of the profile nearest to a place."""
        return replace(self, altitude_m=self.built(*self._nearest(latitude_deg, longitude_deg)).altitude_m)

    def at(self, latitude_deg: float, longitude_deg: float) -> Profile:
        """Return the profile at a place.

        Raises
        ------
        CatalogError
            If the place lies outside the grid, or a profile around it is incomplete or not physical.
        """
        return self._interpolated((latitude_deg, longitude_deg), (None, None))

    def left_out(self, latitude_deg: float, longitude_deg: float) -> Iterator[tuple[float, Profile, Profile]]:
        """Yield, for each axis, a profile of the file near a place and the profile interpolated there without it.

        The first value is the factor that converts their difference into the interpolation error between the places of
        the file: the error of linear interpolation is proportional to the curvature and to the product of the distances
        to both ends. Two places on an axis do not determine the curvature: the factor is then 1, and the difference is
        that between the two profiles.
        """
        axes = self.grid.latitude_deg, self.grid.longitude_deg
        for number, axis in enumerate(axes):
            if axis.size == 1:
                continue
            node = self._nearest(latitude_deg, longitude_deg)
            node[number] = int(np.clip(node[number], 1, max(axis.size - 2, 1)))
            omitted = [node[dimension] if dimension == number else None for dimension in (0, 1)]
            steps = np.diff(axis[node[number] - 1 : node[number] + 2])
            factor = float(np.max(steps) ** 2 / (4.0 * np.prod(steps))) if steps.size == 2 else 1.0
            node_deg = float(axes[0][node[0]]), float(axes[1][node[1]])
            yield factor, self._resampled(self.built(*node)), self._interpolated(node_deg, omitted)

    def _nearest(self, latitude_deg: float, longitude_deg: float) -> list[int]:
        position_deg = latitude_deg, self.grid.eastward(longitude_deg)
        axes = self.grid.latitude_deg, self.grid.longitude_deg
        return [int(np.argmin(np.abs(axis - at))) for axis, at in zip(axes, position_deg, strict=True)]

    def _interpolated(self, place_deg: tuple[float, float], omitted: Sequence[int | None]) -> Profile:
        position_deg = place_deg[0], self.grid.eastward(place_deg[1])
        axes = self.grid.latitude_deg, self.grid.longitude_deg
        around = [
            _around(axis, at, left_out, f"{self.grid.name}: {which}")
            for axis, at, left_out, which in zip(axes, position_deg, omitted, PLACES, strict=True)
        ]
        profiles = [[self._resampled(self.built(int(row), int(column))) for column in around[1]] for row in around[0]]

        def mean(read: Callable[[Profile], Array]) -> Array:
            values = np.array([[read(profile) for profile in row] for row in profiles])
            for axis, at, neighbours in zip(axes, position_deg, around, strict=True):
                values = _along(axis[neighbours], values, at)
            return values

        def of_gas(gas: str) -> Array:
            return mean(lambda profile: profile.mixing_ratio[gas])

        first = profiles[0][0]
        return replace(
            first,
            name=f"{self.grid.name} at {place_deg[0]:.4g} N {place_deg[1]:.4g} E",
            pressure_Pa=np.exp(mean(lambda profile: np.log(profile.pressure_Pa))),
            temperature_K=mean(lambda profile: profile.temperature_K),
            mixing_ratio={gas: of_gas(gas) for gas in first.mixing_ratio},
        )

    def _resampled(self, profile: Profile) -> Profile:
        """Return a profile at the levels of the field."""
        levels = self.altitude_m
        assert levels is not None
        if levels[-1] > profile.altitude_m[-1]:
            raise CatalogError(
                f"{profile.name} ends at {profile.altitude_m[-1] / 1e3:g} km; allowed: {levels[-1] / 1e3:g} km, as at "
                "the image centre"
            )
        return profile.resampled(levels)


def _axis(dataset: Any, name: str, coordinate: str) -> tuple[str, Array] | None:
    """Return the dimension and the values of a coordinate; None if the file has fewer than two values."""
    for label in PLACES[coordinate]:
        variable = dataset.variables.get(label)
        if variable is None or variable.ndim != 1 or variable.size < 2:
            continue
        degrees = values_of(variable)
        if coordinate == "longitude":
            degrees = np.unwrap(degrees, period=360.0)
        steps = np.diff(degrees)
        if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            raise CatalogError(f"{name}: {label} does not ascend or descend; allowed: each {coordinate} once, in order")
        return variable.dimensions[0], degrees
    return None


def _by_place(variable: ProfileVariable, values: Array, name: str, places: list[str | None]) -> Array:
    """Return the values of a variable (latitude, longitude, level); missing axes have one element."""
    dimensions = list(variable.data.dimensions)
    levels = [
        dimension
        for dimension, size in zip(dimensions, values.shape, strict=True)
        if dimension not in places and size > 1
    ]
    if len(levels) != 1:
        raise CatalogError(
            f"{name}: '{variable.label}' has the dimensions {', '.join(dimensions)}; allowed: levels, latitude and "
            "longitude"
        )
    wanted = [*places, levels[0]]
    kept = [dimension for dimension in wanted if dimension in dimensions]
    order = [dimensions.index(dimension) for dimension in kept]
    others = tuple(index for index in range(values.ndim) if index not in order)
    ordered = np.transpose(values, (*order, *others)).reshape([values.shape[index] for index in order])
    result: Array = np.expand_dims(
        ordered, [axis for axis, dimension in enumerate(wanted) if dimension not in dimensions]
    )
    return result


def _around(degrees: Array, at: float, omitted: int | None, what: str) -> NDArray[np.intp]:
    """Return the indices of the places used for interpolation: two on either side, if available."""
    kept = np.arange(degrees.size) if omitted is None else np.delete(np.arange(degrees.size), omitted)
    if kept.size == 1:
        return kept
    kept_deg = degrees[kept]
    if not kept_deg[0] <= at <= kept_deg[-1]:
        raise CatalogError(
            f"{what} {at:.5g} lies outside the profiles; allowed: {kept_deg[0]:g} to {kept_deg[-1]:g} degrees"
        )
    low = int(np.clip(np.searchsorted(kept_deg, at, side="right") - 1, 0, kept_deg.size - 2))
    return kept[max(low - 1, 0) : low + 3]


def _along(degrees: Array, values: Array, at: float) -> Array:
    """Interpolate values (N, ...), given at coordinates (N,), along the first axis."""
    if degrees.size == 1:
        return np.asarray(values[0])
    from scipy.interpolate import PchipInterpolator  # only for several profiles

    return np.asarray(PchipInterpolator(degrees, values, axis=0)(at))
