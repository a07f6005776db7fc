"""Length of the line of sight in the cloud, and the angle between it and the mirror direction of the sun."""

from typing import ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import Declaration, OutputVariable


class Parameters(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    thinnest: float = Field(0.0, ge=0, description="Thickness up to which a cloud does not count, m.")


class Slant:
    declares = Declaration()
    needs = ("cloud_thickness", "view_zenith", "view_azimuth", "sun_zenith", "sun_azimuth")
    variables: ClassVar = {
        "cloud_path": OutputVariable(
            "m", "length of the line of sight in cloud", "Missing where clear.", may_be_missing=True, lowest=0.0
        ),
        "glint_angle": OutputVariable("degree", "angle from the mirror", "0: at the mirror.", dtype="float64"),
    }

    def __init__(self, inputs, parameters):
        self._thinnest = parameters.thinnest

    def values(self, fields, time_s):
        view, sun = (np.radians(fields[name]) for name in ("view_zenith", "sun_zenith"))
        turn = np.radians(fields["view_azimuth"] - fields["sun_azimuth"])
        cosine = np.cos(view) * np.cos(sun) - np.sin(view) * np.sin(sun) * np.cos(turn)
        thickness = fields["cloud_thickness"]
        path = np.where(thickness > self._thinnest, thickness / np.cos(view), np.nan)
        return {"cloud_path": path, "glint_angle": np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))}
