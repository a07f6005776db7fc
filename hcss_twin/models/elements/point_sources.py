"""Element provider ``point-sources``: moving sources smaller than a pixel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.elements.parameters import PointSourceParameters
from hcss_twin.models.elements.tracks import State, tracks_of
from hcss_twin.providers import Declaration, ElementInputs, ElementPixels, ElementScene


class PointSources:
    """Sources whose energy is spread evenly over a square on the image plane, or is in one pixel.

    A pixel gets the share of the energy that is the share of the square in it, computed exactly. Flux is conserved;
    the centroid of the pixels is that of the source if the side of the square is a whole number of pixels.

    Parameters
    ----------
    inputs : ElementInputs
    parameters : PointSourceParameters
    """

    declares = Declaration(
        notes=(
            "point-sources: intensities are constants of the scenario; sources reflect no light of the scene and cast "
            "no shadow; the sensor is so far away that their altitude does not change their distance",
        )
    )
    variables: ClassVar[Mapping[str, tuple[str, str]]] = {
        "source": ("1", "Number of the source, from 1: tracks of the scenario, then sources of the file by number."),
        "altitude": ("m", "Altitude of the source above the sea."),
    }

    def __init__(self, inputs: ElementInputs, parameters: PointSourceParameters) -> None:
        self._inputs = inputs
        self._side = parameters.footprint / inputs.grid.pixel_size_m
        self._tracks = tracks_of(parameters, inputs)

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPixels]:
        """Return the pixels of each source in a window."""
        states = [(number, track.at(time_s, self._inputs)) for number, track in enumerate(self._tracks, start=1)]
        found = (self._of_source(number, state, rows, columns, scene) for number, state in states if state is not None)
        return [each for each in found if each.rows.size]

    def _of_source(self, number: int, state: State, rows: slice, columns: slice, scene: ElementScene) -> ElementPixels:
        row, column = (float(each[0]) for each in scene.project(*state.position_m[:, None]))
        (y, up), (x, across) = covered(row, self._side, rows), covered(column, self._side, columns)
        at_y, at_x = (each.ravel() for each in np.meshgrid(y, x, indexing="ij"))
        altitude = float(state.position_m[2])
        return ElementPixels(
            at_y,
            at_x,
            np.outer(up, across).ravel(),
            altitude,
            intensity=state.intensity,
            temperature_K=state.temperature_K,
            truth={"source": np.full(at_y.size, float(number)), "altitude": np.full(at_y.size, altitude)},
        )


def covered(centre: float, side: float, within: slice) -> tuple[NDArray[np.intp], Array]:
    """Return the pixels that a segment meets along one axis, and the share of its length in each.

    Parameters
    ----------
    centre, side : float
        Middle and length of the segment, in pixels; pixel n extends from n to n + 1. With length 0 it is in one pixel.
    within : slice
        Pixels to return.
    """
    low, high = centre - 0.5 * side, centre + 0.5 * side
    pixels = np.arange(max(math.floor(low), within.start), min(math.floor(high) + 1, within.stop))
    if math.floor(low) == math.floor(high):
        return pixels, np.ones(pixels.size)
    share = (np.minimum(high, pixels + 1.0) - np.maximum(low, pixels)) / (high - low)
    return pixels[share > 0.0], share[share > 0.0]
