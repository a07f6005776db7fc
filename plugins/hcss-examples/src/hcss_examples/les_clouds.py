"""Clouds of a large-eddy simulation: liquid water content by time and height, doubly periodic."""

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from hcss_twin.providers import CatalogError, CloudDeclaration, CloudInputs, Microphysics, NetcdfFile, ProviderError

Thickness = NDArray[np.float32]


class Parameters(BaseModel):
    """Keys that a scenario can set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: str = Field(description="NetCDF file with coordinates time (s), z, y, x (m) at even distances of y and x.")
    variable: str = Field("lwc", description="Liquid water content (time, z, y, x) in kg m-3.")


class LesClouds:
    """Thickness that gives a column of the layer's droplets the liquid water path, and optical depth, of the file.

    Columns thinner than ``thickness_min`` are clear. The field is linear between the times of the file and repeats
    along x and y; points take the value of the cell that contains them. It drifts with the scenario's wind.
    """

    def __init__(self, inputs: CloudInputs, parameters: Parameters) -> None:
        self._layer, self._grid = inputs.layer, inputs.grid
        wind, pixel = inputs.motion.cloud_velocity_m_s, inputs.grid.pixel_size_m
        self._pixels_per_s = -wind[1] / pixel, (inputs.motion.platform_speed_m_s - wind[0]) / pixel
        with NetcdfFile(path := inputs.catalog.file(parameters.file)) as file:
            if parameters.variable not in file.variables or file[parameters.variable].units != "kg m-3":
                raise CatalogError(f"{path}: no variable '{parameters.variable}' in kg m-3; has {list(file.variables)}")
            self._time_s, z, y, x = (np.asarray(file[name][:], dtype=float) for name in ("time", "z", "y", "x"))
            self._cells_per_pixel = pixel / (y[1] - y[0]), pixel / (x[1] - x[0])
            path_kg_m2 = np.stack([self._column(np.asarray(water), z) for water in file[parameters.variable][:]])
        self._thickness_m = thickness = path_kg_m2 / water_content_kg_m3(inputs.layer.microphysics)
        if thickness.max() > inputs.layer.thickness_max_m:
            most = f"allowed: up to the layer's thickness, {inputs.layer.thickness_max_m:g} m (clouds.top)"
            raise ProviderError(f"les: a column holds as much water as {thickness.max():g} m of this cloud; {most}")
        self.image_coverage = float(np.mean(thickness >= inputs.layer.thickness_min_m))
        self.declares = CloudDeclaration(depends_on=frozenset({"time"}), evolves=self._time_s.size > 1)

    def _column(self, water: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Integrate a water content (z, y, x) over height."""
        wet = z[np.any(water > 0.0, axis=(1, 2))]
        low, high = self._layer.base_m, self._layer.top_m
        if wet.size and not low <= wet[0] <= wet[-1] <= high:
            raise ProviderError(f"les: water at {wet[0]:g} to {wet[-1]:g} m; allowed: {low:g} to {high:g} m, the layer")
        return np.tensordot(np.gradient(z), water, axes=1)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> Thickness:
        """Return the thickness (y, x) of a window."""
        first, last = self._time_s[[0, -1]]
        if first < last and not first <= time_s <= last:
            raise ProviderError(f"les: time {time_s:g} s; allowed: those of the file, {first:g} to {last:g} s")
        number = float(np.interp(time_s, self._time_s, np.arange(self._time_s.size)))
        before, after = self._thickness_m[math.floor(number)], self._thickness_m[math.ceil(number)]
        spans, sizes = (rows, columns), (self._grid.rows, self._grid.columns)
        y, x = (
            np.floor((np.arange(span.start, span.stop) + 0.5 - 0.5 * size + speed * time_s) * cells)
            for span, size, speed, cells in zip(spans, sizes, self._pixels_per_s, self._cells_per_pixel, strict=True)
        )
        at = np.ix_(*(coordinate.astype(int) % size for coordinate, size in zip((y, x), before.shape, strict=True)))
        thickness = before[at] + (number % 1.0) * (after[at] - before[at])
        return np.where(thickness < self._layer.thickness_min_m, 0.0, thickness).astype(np.float32)

    def thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: None = None) -> Thickness:
        """Return the thickness (y, x) of a window in or around the image: the simulation has no end."""
        return self.thickness_m(time_s, rows, columns)


def water_content_kg_m3(cloud: Microphysics) -> float:
    """Return the liquid water content: number density times mean volume of the droplets times 1000 kg m-3."""
    radius = np.linspace(*cloud.radius_range_um, 4000)
    number = radius**cloud.alpha * np.exp(-cloud.b * radius**cloud.nu)
    return 4e3 / 3.0 * np.pi * 1e-18 * cloud.number_density_m3 * float(radius**3 @ number / number.sum())
