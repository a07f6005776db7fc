"""Element provider ``point-sources``: moving plumes and bodies smaller than a few pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, Problem, ScenarioError, choose_from
from hcss_twin.models.elements.parameters import FARTHEST_M, PointSourceParameters, Track
from hcss_twin.providers import Declaration, ElementInputs, ElementPoint, ElementScene

_PLACE = ("source", "time", "altitude")
_PLANE, _GLOBE = ("x", "y"), ("latitude", "longitude")
_INTENSITY, _EMISSIVITY = "intensity", "emissivity"


@dataclass(frozen=True)
class State:
    """A source at one instant: position (3,) in m, velocity (3,) in m s-1, and strength as in :class:`SourceTrack`."""

    position_m: Array
    velocity_m_s: Array
    strength: Array


@dataclass(frozen=True)
class SourceTrack:
    """A source over time.

    Attributes
    ----------
    time_s : ndarray (K,)
        Ascending; one time: the source is there at all times.
    position_m : ndarray (K, 3)
        East and north of the image centre at the start, and altitude.
    velocity_m_s : ndarray (3,)
        After a single time.
    strength : ndarray (K, B) or (K, 3)
        Intensities of a plume in W sr-1, or temperature in K, area in m2 and emissivity of a body.
    thermal : bool
        Whether it is a body.
    """

    time_s: Array
    position_m: Array
    velocity_m_s: Array
    strength: Array
    thermal: bool

    def at(self, time_s: float) -> State | None:
        """Return the source at a time; None if it is absent."""
        if self.time_s.size == 1:
            return State(self.position_m[0] + self.velocity_m_s * time_s, self.velocity_m_s, self.strength[0])
        if not self.time_s[0] <= time_s <= self.time_s[-1]:
            return None
        position, strength = (_between(time_s, self.time_s, values) for values in (self.position_m, self.strength))
        after = min(max(1, int(np.searchsorted(self.time_s, time_s, side="right"))), self.time_s.size - 1)
        velocity = np.diff(self.position_m[after - 1 : after + 1], axis=0)[0] / np.diff(self.time_s)[after - 1]
        return State(position, velocity, strength)


def _between(time_s: float, times_s: Array, values: Array) -> Array:
    return np.array([np.interp(time_s, times_s, column) for column in values.T])


def tracks_of(parameters: PointSourceParameters, inputs: ElementInputs) -> tuple[SourceTrack, ...]:
    """Return all tracks: those of the scenario, then those of the file by number.

    Raises
    ------
    ScenarioError, CatalogError
        If a band has no intensity, or the file is wrong.
    """
    bands = [band.name for band in inputs.bands]
    given = (_given(track, bands, index) for index, track in enumerate(parameters.tracks))
    return (*given, *_from_file(parameters.file, bands, inputs))


def _given(track: Track, bands: list[str], index: int) -> SourceTrack:
    if track.temperature is not None and track.area is not None:
        strength = [track.temperature, track.area, track.emissivity]
    elif isinstance(track.intensity, dict):
        for name in (*bands, *track.intensity):
            if name not in track.intensity or name not in bands:
                message = f"a number for each band and no other is needed; '{name}' is "
                message += "missing" if name in bands else f"no band: {choose_from(name, bands)}"
                raise ScenarioError([Problem(f"tracks[{index}].intensity", message)])
        strength = [track.intensity[name] for name in bands]
    else:
        strength = [float(track.intensity or 0.0)] * len(bands)
    path = np.array(track.path or [[0.0, track.x, track.y, track.altitude]])
    strengths = np.repeat(np.array([strength]), len(path), axis=0)
    thermal = track.temperature is not None
    return SourceTrack(path[:, 0], path[:, 1:], np.array(track.velocity), strengths, thermal)


def _from_file(name: str | None, bands: list[str], inputs: ElementInputs) -> list[SourceTrack]:
    if name is None:
        return []
    columns = inputs.catalog.columns(inputs.catalog.file(name))
    thermal = "temperature" in columns or "area" in columns
    strengths = ["temperature", "area", _EMISSIVITY] if thermal else [f"{_INTENSITY} {band}" for band in bands]
    if thermal:
        columns = {_EMISSIVITY: np.ones_like(next(iter(columns.values()))), **columns}
    if _INTENSITY in columns and not thermal:
        strengths = [_INTENSITY] * len(bands)
    across = _GLOBE if not {*_GLOBE}.isdisjoint(columns) else _PLANE
    wanted = {*_PLACE, *across, *strengths}
    wrong = sorted(wanted.symmetric_difference(columns))
    if wrong:
        raise CatalogError(
            f"'{name}': column '{wrong[0]}' is {'missing' if wrong[0] in wanted else 'unknown'}; allowed: "
            f"{', '.join(_PLACE)}; x, y or latitude, longitude; and {_INTENSITY}, {_INTENSITY} BAND for each band of "
            "the scene, or temperature, area and optionally emissivity"
        )
    strength = np.stack([columns[name] for name in strengths], axis=1)
    low = np.nextafter(0.0, 1.0) if thermal else 0.0
    for what, least, values in (("altitude", 0.0, columns["altitude"]), (strengths[0], low, strength)):
        if np.any(values < least):
            raise CatalogError(f"'{name}': {what} {values.min():g}; allowed: {'above 0' if least else '0 or more'}")
    if thermal and np.any(columns[_EMISSIVITY] > 1.0):
        raise CatalogError(f"'{name}': emissivity {columns[_EMISSIVITY].max():g}; allowed: above 0 to 1")
    x, y = (columns[name] for name in across)
    if across == _GLOBE:
        if np.any(np.abs(x) > 90.0):
            raise CatalogError(f"'{name}': latitude {x[np.argmax(np.abs(x))]:g}; allowed: -90 to 90")
        try:
            x, y = inputs.to_plane(x, y)
        except ValueError as error:
            raise CatalogError(f"'{name}': {error}") from error
    for what, values in zip(_PLANE, (x, y), strict=True):
        if np.any(np.abs(values) > FARTHEST_M):
            worst = values[np.argmax(np.abs(values))]
            raise CatalogError(f"'{name}': {what} {worst:g} m; allowed: {-FARTHEST_M:g} to {FARTHEST_M:g}")
    tracks = []
    for source in np.unique(columns["source"]):
        rows: NDArray[np.intp] = np.flatnonzero(columns["source"] == source)
        time = columns["time"][rows]
        if np.any(np.diff(time) <= 0.0):
            raise CatalogError(f"'{name}': the times of source {source:g} do not ascend")
        position = np.stack([coordinate[rows] for coordinate in (x, y, columns["altitude"])], axis=1)
        tracks.append(SourceTrack(time, position, np.zeros(3), strength[rows], thermal))
    return tracks


class PointSources:
    """Plumes of an intensity, and bodies of a temperature and area, on straight tracks.

    Parameters
    ----------
    inputs : ElementInputs
    parameters : PointSourceParameters
    """

    declares = Declaration(
        notes=(
            "point-sources: intensities are constants of the scenario and hide nothing (plumes); bodies reflect direct "
            "sun and thermal sky as horizontal diffusers, and cast no shadow; on the grid on the ground the sensor is "
            "so far away that altitude does not change distance",
        )
    )
    variables: ClassVar[Mapping[str, tuple[str, str]]] = {
        "source": ("1", "Number of the source, from 1: tracks of the scenario, then sources of the file by number."),
        "altitude": ("m", "Altitude of the source above the sea."),
    }

    def __init__(self, inputs: ElementInputs, parameters: PointSourceParameters) -> None:
        self._inputs, self._side_m = inputs, parameters.footprint
        self._tracks = tracks_of(parameters, inputs)

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPoint]:
        """Return the sources that are there at a time."""
        states = ((number, track, track.at(time_s)) for number, track in enumerate(self._tracks, start=1))
        return [self._source(number, track, state) for number, track, state in states if state is not None]

    def _source(self, number: int, track: SourceTrack, state: State) -> ElementPoint:
        x, y, altitude = state.position_m.tolist()
        east, north, up = state.velocity_m_s.tolist()
        truth = {"source": float(number), "altitude": altitude}
        if not track.thermal:
            return ElementPoint(
                x, y, altitude, state.strength.copy(), velocity_m_s=(east, north, up), side_m=self._side_m, truth=truth
            )
        kelvin, area_m2, emissivity = state.strength.tolist()
        return ElementPoint(
            x,
            y,
            altitude,
            radiance=emissivity * self._inputs.black_body(kelvin),
            area_m2=area_m2,
            reflectance=1.0 - emissivity,
            velocity_m_s=(east, north, up),
            side_m=self._side_m,
            temperature_K=kelvin,
            truth=truth,
        )
