"""Bars of cloud along y, of one thickness: they cover the same share of each period, and drift unchanged."""

import numpy as np
from hcss_twin.providers import CloudInputs, CloudDeclaration
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    period_m: float = Field(default=1000.0, gt=0, description="Distance from bar to bar, in metres.")


class Provider:
    """The seed places the bars, so that the mean cover over all seeds is the coverage."""

    def __init__(self, inputs: CloudInputs, parameters: Parameters) -> None:
        self._layer = inputs.layer
        pixel_m, motion = inputs.grid.pixel_size_m, inputs.motion
        self._bars_per_pixel = pixel_m / parameters.period_m
        self._pixels_per_s = (motion.platform_speed_m_s - motion.cloud_velocity_m_s[0]) / pixel_m
        self._phase = np.random.default_rng(inputs.seed).random()
        self.declares = CloudDeclaration(depends_on=frozenset({"time"} if self._pixels_per_s else ()))

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) in metres of the window that two slices cut out of the image; 0: clear."""
        x = np.arange(columns.start, columns.stop) + self._pixels_per_s * time_s
        cloudy = (x * self._bars_per_pixel + self._phase) % 1.0 < self._layer.coverage
        line = np.where(cloudy, self._layer.thickness_max_m, 0.0).astype(np.float32)
        return np.tile(line, (rows.stop - rows.start, 1))
