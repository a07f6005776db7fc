"""Integration in time: smear by exposures within the integration time, and time delay and integration (TDI)."""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Array, Measured, Points, Problem, ScenarioError, SensorDeclaration, SensorInputs

_STEPS_PER_PIXEL = 8
"""Instants for each pixel by which small elements move."""


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    integration_time: Quantity.Duration = Field(
        1e-3, gt=0, le=100, description="Integration time around that of the frame, s."
    )
    exposures: int | None = Field(
        None, ge=1, le=256, description="Instants of it; default: two for each pixel of smear by the platform, or one."
    )
    stages: int = Field(1, ge=1, le=128, description="Lines whose charges are added while they follow the scene (TDI).")
    line_time: Quantity.Duration = Field(
        0.0,
        ge=0,
        le=100,
        description="Time after which charges move on by a column toward -x, s; 0: with the platform.",
    )


class Integration:
    """The mean over exposures and TDI stages; the scene is asked for at each of these instants.

    Exposures stand in the middles of equal parts of the integration time, so that linear motion smears by the sinc of
    the whole time. With TDI, stage m of M sees the scene m - M // 2 line times later, where the platform's motion
    along +x has brought it as many columns further toward -x; if the charges move at another speed, the difference
    smears.
    """

    variables = ()

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        self._inputs = inputs
        speed, pixel = abs(inputs.platform_speed_m_s), inputs.grid.pixel_size_m
        smear = speed * parameters.integration_time / pixel
        count = parameters.exposures or max(1, math.ceil(2.0 * smear))
        line_time = parameters.line_time
        if parameters.stages > 1 and not line_time:
            if not speed:
                message = "0 s with a platform at rest; allowed: a time above 0 for several stages"
                raise ScenarioError([Problem("sensor.parameters.line_time", message)])
            line_time = pixel / speed
        self._direction = 1 if inputs.platform_speed_m_s >= 0.0 else -1
        self._integration_s, self._line_s = parameters.integration_time, line_time
        middles = self._middles_s(count)
        self._stages = stages = np.arange(parameters.stages) - (parameters.stages // 2)
        self._parts = [(float(stage * line_time + middle), int(stage)) for stage in stages for middle in middles]
        times = [time for time, _ in self._parts]
        self.instants = min(0.0, *times), max(0.0, *times)
        reach = int(np.abs(stages).max())
        self.declares = SensorDeclaration(reach_pixels=reach)
        self.worked_out = {"smear_pixels": smear, "exposures": count, "line_time": line_time}

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return the mean of the exposures of a frame."""
        _, rows, columns = radiance.shape
        total = np.zeros(radiance.shape)
        for later, stage in self._parts:
            seen = self._inputs.scene_at(time_s + later, slice(0, rows), slice(0, columns))
            shift = -self._direction * stage
            # What the platform has moved by is where the charges are; the edge is repeated.
            column = np.clip(np.arange(columns) + shift, 0, columns - 1)
            total += seen[:, :, column]
        return Measured(total / len(self._parts))

    def points_after(self, points: Points) -> Points:
        """Return the places of small elements on the charges, at instants as close as their motion needs."""
        motion = self._integration_s * np.max(np.hypot(points.row_rate, points.column_rate), initial=0.0)
        middles = self._middles_s(max(1, math.ceil(_STEPS_PER_PIXEL * float(motion))))
        later = (self._stages[:, None] * self._line_s + middles)[..., None]
        row = points.row + later * points.row_rate
        column = points.column + later * points.column_rate + self._direction * self._stages[:, None, None]
        count, still = later.size, np.zeros(row.size)
        return Points(row.ravel(), column.ravel(), still, still, np.tile(points.radiance, count) / count)

    def _middles_s(self, count: int) -> Array:
        """Middles of equal parts of the integration time."""
        middles: Array = ((np.arange(count) + 0.5) / count - 0.5) * self._integration_s
        return middles
