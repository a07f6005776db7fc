"""Per-pixel mean and spread over all draws, accumulated scene by scene: memory does not grow with their number."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Problem, ScenarioError

if TYPE_CHECKING:
    import xarray as xr


MAP = "_map_"
"""In the names of per-pixel statistics: ``radiance_map_mean``."""

CLOUD = "cloud_mask"

MAX_BYTES = 2**32
"""Of the sums of all maps together."""

_SUMS = 3
_UNITS = {"radiance": "W m-2 sr-1", "measured_radiance": "W m-2 sr-1", "brightness_temperature": "K"}

Scene = Mapping[str, NDArray[Any]]
"""Values of all pixels in all frames of a scene, (..., pixel), by quantity."""


class PairMoments:
    """Mean, variance and variance due to the seed of pairs of arrays, each pair with one draw of the inputs.

    B. P. Welford, Technometrics 4 (1962) 419-420, for the mean and the sum of squares; the variances are those of
    :func:`hcss_uncertainty.estimators.variance` and ``seed_variance``.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.pairs = 0
        sums: Array = np.zeros((_SUMS, *shape))
        self._mean, self._squares, self._apart = sums

    def add(self, first: NDArray[Any], second: NDArray[Any]) -> None:
        """Take the arrays of one draw with its two seeds."""
        for number, values in enumerate((first, second)):
            off = values - self._mean
            self._mean += off / (2 * self.pairs + number + 1)
            self._squares += off * (values - self._mean)
        self._apart += np.square(first - second.astype(np.float64))
        self.pairs += 1

    @property
    def mean(self) -> Array:
        """Mean over all scenes."""
        return np.asarray(self._mean)

    @property
    def variance(self) -> Array:
        """Variance over draws and seeds, unbiased although scenes of one draw share its inputs; needs two draws."""
        count = 2 * self.pairs
        whole = np.maximum(count * self._squares - self._apart, 0.0)  # rounding
        return np.asarray(whole / (count * (count - 1) - count))

    @property
    def seed_variance(self) -> Array:
        """Mean over draws of the variance due to the seed alone."""
        return np.asarray(self._apart / (2 * self.pairs))


class PixelMaps:
    """Moments of every pixel of every frame, for all mapped quantities."""

    def __init__(self) -> None:
        self._moments: dict[str, PairMoments] = {}

    def add(self, first: Scene, second: Scene) -> None:
        """Take the scenes of one draw with its two seeds; draws in order give the same bits."""
        for name, values in first.items():
            self._moments.setdefault(name, PairMoments(values.shape)).add(values, second[name])

    def dataset(self, plan: Plan) -> xr.Dataset:
        """Return the maps (band, time, y, x), with coordinates in metres from the centre and seconds.

        Images that are no grid on the ground have rows and columns, the first row at the top.
        """
        import xarray as xr

        plane = ("y", "x") if plan.is_grid else ("row", "column")
        frames, metres = (plan.frame_times_s.size, *plan.pixels), {"units": "m"}
        data: dict[str, Any] = {}
        for name, found in self._moments.items():
            of_band = () if name == CLOUD else (len(plan.bands),)
            dims, shape = (*(("band",) if of_band else ()), "time", *plane), (*of_band, *frames)
            label = {CLOUD: "cloud (1: cloud, 0: none)"}.get(name, name.replace("_", " "))
            for statistic, values, meaning in (
                ("mean", found.mean, "mean over scenes of the pixel's"),
                ("standard_deviation", np.sqrt(found.variance), "standard deviation over scenes of the pixel's"),
                ("seed_standard_deviation", np.sqrt(found.seed_variance), "the same due to the seed alone, of the"),
            ):
                about = {"long_name": f"{meaning} {label}", "units": _UNITS.get(name, "1")}
                data[f"{name}{MAP}{statistic}"] = (dims, values.reshape(shape).astype(np.float32), about)
        axes: dict[str, Any] = {name: (name, np.arange(count)) for name, count in zip(plane, plan.pixels, strict=True)}
        if plan.is_grid:
            sizes = zip(plane, plan.extent, plan.pixels, (plan.grid.rows, plan.grid.columns), strict=True)
            axes = {
                name: (name, (pixels.start + np.arange(count) - 0.5 * (size - 1)) * plan.grid.pixel_size_m, metres)
                for name, pixels, count, size in sizes
            }
        time = ("time", plan.frame_times_s, {"long_name": "time after the start of the scenario", "units": "s"})
        return xr.Dataset(data, {"time": time, **axes})


def require_room_for_maps(plan: Plan) -> None:
    """Raise ScenarioError for images whose maps do not fit into memory."""
    rows, columns = plan.pixels
    quantities = 4 if plan.sensor.stages else 2
    values = rows * columns * plan.frame_times_s.size * (1 + len(plan.bands) * quantities)
    needed = 8 * _SUMS * values
    if needed > MAX_BYTES:
        message = (
            f"maps of {rows} x {columns} pixels, frames: {plan.frame_times_s.size}, bands: {len(plan.bands)} need "
            f"{needed / 2**30:.1f} GiB; allowed: {MAX_BYTES / 2**30:.0f} GiB (fewer frames or bands, image.window, or "
            "no maps)"
        )
        raise ScenarioError([Problem("image", message)], plan.scenario.origin)
