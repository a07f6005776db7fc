"""Sea ice from a file: ice where its concentration is large enough, with a map of its temperature."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.interpolate import RegularGridInterpolator

from hcss_twin.providers import Array, Declaration, NetcdfFile, ProviderError, SurfaceClass, SurfaceInputs, SurfaceMap


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    file: str = Field(description="NetCDF file with concentration and temperature on latitude and longitude.")
    least: float = Field(0.5, gt=0, lt=1, description="Concentration from which a point is ice.")


class IceMap:
    """Ice and open sea; both quantities are linear between the points of the file."""

    declares = Declaration(notes=("ice-map: a point is ice or sea, without a mixture of both",))

    def __init__(self, inputs: SurfaceInputs, parameters: Parameters) -> None:
        self._ground, self._of = inputs.ground, parameters
        with NetcdfFile(inputs.catalog.file(parameters.file)) as data:
            axes = tuple(np.asarray(data[name][:], dtype=float) for name in ("latitude", "longitude"))
            share = np.ma.filled(data["concentration"][:], np.nan).astype(float)
            kelvin = np.ma.filled(data["temperature"][:], np.nan).astype(float)
        if np.any(np.isnan(share)) or not np.all(np.isfinite(kelvin) & (kelvin > 200.0) & (kelvin <= 273.16)):
            raise ProviderError(
                f"ice-map: {parameters.file}: allowed: concentration, and temperature of 200 to 273.16 K"
            )
        self._axes = axes
        self._share, self._kelvin = RegularGridInterpolator(axes, share), RegularGridInterpolator(axes, kelvin)
        low, high = float(kelvin.min()), float(kelvin.max())
        self.classes = (SurfaceClass("sea"), SurfaceClass("ice", (low, high) if low < high else low))

    def surface(self, time_s: float, rows: slice, columns: slice) -> SurfaceMap:
        """Return class and temperature at the points of a window."""
        places: Array = np.stack(self._ground(time_s, rows, columns), axis=-1)
        for name, axis, coordinates in zip(
            ("latitude", "longitude"), self._axes, np.moveaxis(places, -1, 0), strict=True
        ):
            if coordinates.min() < axis[0] or coordinates.max() > axis[-1]:
                raise ProviderError(
                    f"ice-map: the image reaches {name} {coordinates.min():.2f} to {coordinates.max():.2f}; "
                    f"allowed: that of {self._of.file}, {axis[0]:.2f} to {axis[-1]:.2f}"
                )
        return SurfaceMap((self._share(places) >= self._of.least).astype(np.uint8), self._kelvin(places))
