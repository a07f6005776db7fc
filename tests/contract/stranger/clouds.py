"""Cloud streets: parallel rolls, thick in the middle and thin at their edges."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import CloudDeclaration


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    spacing_m: float = Field(3000.0, gt=0, description="Distance from street to street, in metres.")
    direction_deg: float = Field(30.0, description="Angle of the streets against +x, toward +y.")


class CloudStreets:
    skipped = (("evolution", "streets drift with the wind and keep their shape"),)

    def __init__(self, inputs, parameters):
        self._layer = inputs.layer
        pixel, motion = inputs.grid.pixel_size_m, inputs.motion
        angle = np.radians(parameters.direction_deg)
        self._streets_per_pixel = np.array([-np.sin(angle), np.cos(angle)]) * pixel / parameters.spacing_m
        self._phase = np.random.default_rng(inputs.seed).random()
        drift = motion.cloud_velocity_m_s
        self._pixels_per_s = (motion.platform_speed_m_s - drift[0]) / pixel, -drift[1] / pixel
        self.declares = CloudDeclaration(depends_on=frozenset({"time"} if any(self._pixels_per_s) else ()))

    def thickness_m(self, time_s, rows, columns):
        layer = self._layer
        if layer.coverage == 0.0:
            return np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        x = np.arange(columns.start, columns.stop) + self._pixels_per_s[0] * time_s
        y = np.arange(rows.start, rows.stop)[:, None] + self._pixels_per_s[1] * time_s
        across = self._phase + self._streets_per_pixel[0] * x + self._streets_per_pixel[1] * y
        # 0 in the middle of a street and 1 midway between two, uniform: a share c lies below c
        distance = np.abs(2.0 * (across % 1.0) - 1.0)
        span = layer.thickness_max_m - layer.thickness_min_m
        thickness = layer.thickness_min_m + span * (1.0 - (distance / layer.coverage) ** 2)
        return np.where(distance <= layer.coverage, thickness, 0.0).astype(np.float32)
