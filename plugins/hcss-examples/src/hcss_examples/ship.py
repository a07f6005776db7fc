"""A ship of several pixels: a rectangle on its course, which covers its exact share of each pixel."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Array, Declaration, ElementInputs, ElementPixels, ElementScene


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    x: Quantity.Length = Field(0.0, ge=-1e8, le=1e8, description="Start, m east of the image centre.")
    y: Quantity.Length = Field(0.0, ge=-1e8, le=1e8, description="Start, m north of the image centre.")
    length: Quantity.Length = Field(200.0, gt=0, le=500, description="Of the deck, m.")
    width: Quantity.Length = Field(30.0, gt=0, le=100, description="Of the deck, m.")
    height: Quantity.Length = Field(15.0, ge=0, le=100, description="Of the deck above the sea, m.")
    speed: Quantity.Speed = Field(10.0, ge=0, le=50, description="Over the ground, m/s.")
    heading: Quantity.Angle = Field(60.0, ge=0, le=360, description="Degrees clockwise from north.")
    temperature: Quantity.Temperature = Field(305.0, gt=0, le=1000, description="Of the deck, a grey body, K.")
    emissivity: float = Field(0.9, gt=0, le=1, description="Of the deck; it reflects nothing.")


class Ship:
    """A ship on a straight course."""

    declares = Declaration(notes=("ship: the deck reflects no light, and has no wake",))
    variables: Mapping[str, tuple[str, str]] = MappingProxyType(
        {"temperature": ("K", "Temperature of the deck."), "heading": ("degree", "Course of the ship, from north.")}
    )

    def __init__(self, inputs: ElementInputs, parameters: Parameters) -> None:
        self._of = parameters
        self._radiance = parameters.emissivity * inputs.black_body(parameters.temperature)

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPixels]:
        """Return the pixels of the window that the deck meets."""
        of, angle = self._of, math.radians(self._of.heading)
        along = np.array([1, 1, -1, -1]) * of.length / 2 + of.speed * time_s
        across = np.array([1, -1, -1, 1]) * of.width / 2
        x = of.x + along * math.sin(angle) + across * math.cos(angle)
        y = of.y + along * math.cos(angle) - across * math.sin(angle)
        deck = np.stack(scene.project(x, y, np.full(4, of.height)), axis=1)  # corners (4, 2): row, column
        low, high = np.floor(deck.min(axis=0)).astype(int), np.ceil(deck.max(axis=0)).astype(int)
        found = [
            (row, column, share)
            for row in range(max(low[0], rows.start), min(high[0], rows.stop))
            for column in range(max(low[1], columns.start), min(high[1], columns.stop))
            if (share := min(shared_area(deck, row, column), 1.0)) > 1e-9
        ]
        if not found:
            return []
        at = np.array(found)
        truth = {"temperature": np.full(len(at), of.temperature), "heading": np.full(len(at), of.heading)}
        where = at[:, 0].astype(np.intp), at[:, 1].astype(np.intp), at[:, 2]
        return [ElementPixels(*where, of.height, self._radiance.copy(), None, of.temperature, truth)]


def shared_area(polygon: Array, row: int, column: int) -> float:
    """Return the area of a convex polygon (N, 2) within one pixel (Sutherland and Hodgman, CACM 17, 32, 1974)."""
    for axis, limit, sign in ((0, row, 1.0), (0, row + 1, -1.0), (1, column, 1.0), (1, column + 1, -1.0)):
        inside, corners = sign * (polygon[:, axis] - limit), list[Array]()
        for n in range(len(polygon)):
            if inside[n - 1] * inside[n] < 0.0:
                part = inside[n - 1] / (inside[n - 1] - inside[n])
                corners.append(polygon[n - 1] + part * (polygon[n] - polygon[n - 1]))
            if inside[n] >= 0.0:
                corners.append(polygon[n])
        if len(corners) < 3:
            return 0.0
        polygon = np.array(corners)
    y, x = (polygon - (row, column)).T
    return 0.5 * abs(float(np.dot(y, np.roll(x, 1)) - np.dot(x, np.roll(y, 1))))
