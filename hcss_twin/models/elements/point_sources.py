"""Element provider ``point-sources``: moving plumes and bodies smaller than a few pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from hcss_twin.models.elements.parameters import PointSourceParameters
from hcss_twin.models.elements.tracks import SourceTrack, State, tracks_of
from hcss_twin.providers import Declaration, ElementInputs, ElementPoint, ElementScene


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
                x, y, altitude, state.strength, velocity_m_s=(east, north, up), side_m=self._side_m, truth=truth
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
