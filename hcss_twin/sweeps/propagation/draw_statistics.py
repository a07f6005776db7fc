"""Statistics of one scene, pixels by class and band and metrics of its clouds; and the tables that scenes share."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.measures.morphology import morphology
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError, Problem, ScenarioError
from hcss_twin.engine.certificate.part_sample import strata, stratum_names
from hcss_twin.engine.compile import compile_tables, table_key, tables_of
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.spectral_grid import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length

Thickness = NDArray[np.float32]

ALL = "all"
"""Class of every pixel."""

METRICS = ("coverage", "entropy", "density", "diagonal_peak", "fractal_dimension")

LEVELS = (np.arange(64) + 0.5) / 64
"""Of the quantiles over the pixels of a scene: each stands for 1/64 of them."""

VARIABLES = ("radiance", "cloud_mask", "cloud_thickness")
"""Of the cube that the statistics are of; brightness temperature is made of radiance."""

MAX_PIXELS = 2**25
"""Of all frames of a scene, whose radiance in all bands is held in memory."""


@dataclass(frozen=True)
class DrawStatistics:
    """Of all frames of one scene together; NaN where no pixel is of the class.

    Attributes
    ----------
    radiance, radiance_spread : ndarray (band, class)
        Mean over the pixels of a class, and their standard deviation, W m-2 sr-1.
    brightness_temperature, brightness_temperature_spread : ndarray (band, class)
        The same of brightness temperature, K.
    pixels : ndarray of int64 (class,)
    metrics : ndarray (metric,)
        Mean over the frames that have them.
    levels : ndarray of float32 (band, class, level) or None
        Radiance below which the shares ``LEVELS`` of the pixels lie.
    """

    radiance: Array
    radiance_spread: Array
    brightness_temperature: Array
    brightness_temperature_spread: Array
    pixels: NDArray[np.int64]
    metrics: Array
    levels: NDArray[np.float32] | None


class _Classes:
    """Looks at the thickness of each window as frames are made, and remembers what kind each pixel is."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.found = np.zeros(plan.pixels, dtype=np.int8)

    def observe(self, window: Window, thickness_m: Sequence[Thickness], shaded: NDArray[np.bool_] | None) -> None:
        """Take a window, in pixels of the part, which here is the whole image."""
        shape = length(window[0]), length(window[1])
        self.found[window] = strata(self._plan.layers, thickness_m, shape, self._plan.samples_per_pixel)


def class_names(layers: int) -> tuple[str, ...]:
    """Return the names of the classes of a scene with so many layers: those of certificates, and ``all``."""
    return (ALL, *stratum_names(layers))


def require_room(plan: Plan) -> None:
    """Refuse scenes whose frames do not fit into memory together.

    Raises ScenarioError naming the image.
    """
    rows, columns = plan.pixels
    pixels, frames = rows * columns, plan.frame_times_s.size
    if pixels * frames > MAX_PIXELS:
        told = (
            f"{rows} x {columns} pixels in {frames} frames; allowed for propagation: {MAX_PIXELS} pixels in all "
            "frames together (fewer frames, or image.window)"
        )
        raise ScenarioError([Problem("image", told)], plan.scenario.origin)


def statistics_of(
    plan: Plan, tables: RadianceTables, temperature: BrightnessTemperature, *, with_levels: bool
) -> DrawStatistics:
    """Compute all frames of a scene with the variables ``VARIABLES``, and summarise them.

    ``temperature`` is of the plan's spectral grid; ``with_levels`` adds quantiles over pixels. Raises ProviderError if
    a provider breaks its contract.
    """
    maker = PartMaker(plan, tables)
    kinds, radiance, kelvin, metrics = [], [], [], []
    for index in range(plan.frame_times_s.size):
        classes = _Classes(plan)
        frame, _ = maker.part(index, plan.extent, classes)
        kinds.append(classes.found.ravel())
        radiance.append(frame["radiance"].reshape(len(plan.bands), -1))
        kelvin.append(temperature(frame["radiance"]).reshape(len(plan.bands), -1))
        metrics.append(_metrics(frame["cloud_thickness"], frame["cloud_mask"] > 0))
    kind = np.concatenate(kinds)
    number = len(stratum_names(len(plan.layers)))
    pixels = np.bincount(kind, minlength=number)
    total = np.concatenate([[kind.size], pixels]).astype(np.int64)
    values, temperatures = np.concatenate(radiance, axis=1), np.concatenate(kelvin, axis=1)
    moments = [_moments(each, kind, number, total) for each in (values, temperatures)]
    levels = _levels(values, kind, number) if with_levels else None
    return DrawStatistics(*moments[0], *moments[1], total, _mean_where_known(np.array(metrics)), levels)


def _moments(
    values: NDArray[np.float32], kind: NDArray[np.int8], number: int, pixels: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Mean and standard deviation of values (band, pixel) over the pixels of each class, (band, class)."""
    mean, spread = np.full((2, values.shape[0], pixels.size), np.nan)
    known = pixels > 0
    for band, each in enumerate(values):
        level = float(each.mean(dtype=np.float64))  # sums of squares of differences keep their digits
        off = each.astype(np.float64) - level
        first, second = (np.bincount(kind, power, minlength=number) for power in (off, off * off))
        sums = np.stack([np.append(np.sum(power), power) for power in (first, second)])
        one, two = sums[:, known] / pixels[known]
        mean[band, known] = level + one
        spread[band, known] = np.sqrt(np.maximum(two - one * one, 0.0))
    return mean, spread


def _levels(values: NDArray[np.float32], kind: NDArray[np.int8], number: int) -> NDArray[np.float32]:
    found = np.full((values.shape[0], number + 1, LEVELS.size), np.nan, dtype=np.float32)
    for place in range(number + 1):
        own = values if place == 0 else values[:, kind == place - 1]
        if own.shape[1] == 0:
            continue
        ordered = np.sort(own, axis=1)
        position = LEVELS * own.shape[1] - 0.5
        low = np.clip(np.floor(position).astype(np.int64), 0, own.shape[1] - 1)
        high = np.minimum(low + 1, own.shape[1] - 1)
        weight = np.clip(position - low, 0.0, 1.0)
        found[:, place] = ordered[:, low] * (1.0 - weight) + ordered[:, high] * weight
    return found


def _metrics(thickness_m: NDArray[np.float32], cloudy: NDArray[np.bool_]) -> list[float]:
    """Metrics of one frame; where an image has no shape to speak of, only its coverage."""
    coverage = float(np.mean(cloudy))
    try:
        shape = morphology(thickness_m, cloudy)
    except ImageError:
        return [coverage, *[np.nan] * (len(METRICS) - 1)]
    return [coverage, *(float(getattr(shape, name)) for name in METRICS[1:])]


def _mean_where_known(metrics: Array) -> Array:
    """Mean over frames (frame, metric) of those that are numbers; NaN where none is."""
    known = np.isfinite(metrics)
    count = known.sum(axis=0)
    total = np.where(known, metrics, 0.0).sum(axis=0)
    return np.asarray(np.divide(total, count, out=np.full(count.shape, np.nan), where=count > 0))


_HELD = 4
"""Tables in memory: all that one draw and the last need."""


@dataclass
class TableCount:
    """How often tables were made.

    ``scenes`` asked for tables and needed ``sets`` different ones, if no more than a few different ones come in a row;
    ``compiled`` of them were compiled, the others were in the cache from earlier runs.
    """

    scenes: int = 0
    sets: int = 0
    compiled: int = 0


class SharedTables:
    """Gives the tables of one plan after the other."""

    def __init__(self) -> None:
        self.count = TableCount()
        self._held: OrderedDict[str, RadianceTables] = OrderedDict()
        self._temperatures: OrderedDict[bytes, BrightnessTemperature] = OrderedDict()

    def of(self, plan: Plan) -> RadianceTables:
        """Return the tables of a plan, the same to the bit as those of a run of its own."""
        self.count.scenes += 1
        key = f"{table_key(plan)} {plan.views} {plan.grid if plan.views is not None else None}"
        if key not in self._held:
            self.count.sets += 1
            compiled: list[Plan] = []  # of several views, where pixels have views of their own
            self._held[key] = tables_of(plan, partial(_noted, compiled))
            self.count.compiled += bool(compiled)
            while len(self._held) > _HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(key)
        return self._held[key]

    def temperature(self, plan: Plan) -> BrightnessTemperature:
        """Return what turns radiance into brightness temperature; its table takes longer than a small frame."""
        grid = plan.spectral_grid
        key = grid.wavenumber_cm1.tobytes() + grid.weights_cm1.tobytes()
        if key not in self._temperatures:
            self._temperatures.clear()
            self._temperatures[key] = BrightnessTemperature(grid, [band.name for band in plan.bands])
        return self._temperatures[key]


def _noted(compiled: list[Plan], plan: Plan) -> RadianceTables:
    compiled.append(plan)
    return compile_tables(plan)
