"""A rolling shutter: each row is read later than the one before, while clouds and targets move."""

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.core.units import QuantityParser as Quantity
from hcss_twin.providers import Array, Measured, SensorDeclaration, SensorInputs


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    delay: Quantity.Duration = Field(1e-4, ge=0, le=1, description="Time from one row to the next, s.")
    rows_together: int = Field(1, ge=1, le=4096, description="Rows that are read at once.")


class RollingShutter:
    """Rows from the first of the image to the last; the first is read at the time of the frame."""

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)

    def __init__(self, inputs: SensorInputs, parameters: Parameters) -> None:
        self._inputs, self._of = inputs, parameters
        late = self._late(np.array([0, inputs.grid.rows]))
        self.instants = min(0.0, float(late[0])), max(0.0, float(late[1]))

    def measure(self, radiance: Array, frame: int, time_s: float) -> Measured:
        """Return each row as the scene was when it was read."""
        rows, columns = radiance.shape[1:]
        late, measured = self._late(np.arange(rows)), np.empty(radiance.shape)
        for delay in np.unique(late):
            rows_of_delay = np.flatnonzero(late == delay)
            window = slice(int(rows_of_delay[0]), int(rows_of_delay[-1]) + 1), slice(0, columns)
            measured[:, window[0]] = self._inputs.scene_at(time_s + float(delay), *window)
        return Measured(measured)

    def _late(self, row: NDArray[np.int_]) -> Array:
        """Time in s at which rows of the frame are read; ``corner`` may lie above the image."""
        together = self._of.rows_together
        result: Array = np.asarray((self._inputs.corner[0] + row) // together * together, float) * self._of.delay
        return result
