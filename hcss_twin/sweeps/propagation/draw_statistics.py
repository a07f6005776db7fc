"""Statistics of one scene (radiance by pixel class and band, cloud metrics), and the tables that scenes share."""

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
"""Quantile levels over the pixels of a scene; each represents 1/64 of them."""

VARIABLES = ("radiance", "cloud_mask", "cloud_thickness")
"""Variables from which statistics are computed; brightness temperature is derived from radiance."""

MAX_PIXELS = 2**25
"""Maximum number of pixels in all frames of a scene, whose radiance in all bands is kept in memory."""


@dataclass(frozen=True)
class DrawStatistics:
    """Statistics over all frames of one scene; NaN for classes without pixels.

    Means and standard deviations over the pixels of a class (band, class), for radiance in W m-2 sr-1 and brightness
    temperature in K; ``pixels`` (class,); ``metrics`` (metric,), means over the frames that have them; and optionally
    ``levels`` (band, class, level), the quantiles of radiance over pixels at ``LEVELS``.
    """

    radiance: Array
    radiance_spread: Array
    brightness_temperature: Array
    brightness_temperature_spread: Array
    pixels: NDArray[np.int64]
    metrics: Array
    levels: NDArray[np.float32] | None


class _Classes:
    """Observes the thickness of each window as frames are computed, and records the class of each pixel."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.kinds = np.zeros(plan.pixels, dtype=np.int8)

    def observe(
        self,
        window: Window,
        thickness_m: Sequence[Thickness],
        shaded: NDArray[np.bool_] | None,
        elements: NDArray[np.bool_] | None = None,
        surface: NDArray[np.uint8] | None = None,
        over_sea: Sequence[Thickness] | None = None,
    ) -> None:
        """Process a window, in pixels of the computed part, which here is the whole image."""
        shape = length(window[0]), length(window[1])
        self.kinds[window] = strata(self._plan.layers, thickness_m, shape, self._plan.samples_per_pixel)


def class_names(layers: int) -> tuple[str, ...]:
    """Return the pixel classes of a scene with ``layers`` layers: those of certificates, and ``all``."""
    return (ALL, *stratum_names(layers))


def require_room(plan: Plan) -> None:
    """Raise ScenarioError for scenes whose frames do not fit into memory together."""
    rows, columns = plan.pixels
    pixels, frames = rows * columns, plan.frame_times_s.size
    if pixels * frames > MAX_PIXELS:
        message = (
            f"{rows} x {columns} pixels in {frames} frames; allowed for propagation: {MAX_PIXELS} pixels in all "
            "frames together (fewer frames, or image.window)"
        )
        raise ScenarioError([Problem("image", message)], plan.scenario.origin)


def statistics_of(
    plan: Plan, tables: RadianceTables, temperature: BrightnessTemperature, *, with_levels: bool
) -> DrawStatistics:
    """Compute the variables ``VARIABLES`` of all frames of a scene, and summarise them.

    ``temperature`` belongs to the plan's spectral grid; ``with_levels`` adds quantiles over pixels. Raises
    ProviderError if a provider violates its contract.
    """
    maker = PartMaker(plan, tables)
    kinds, radiance, kelvin, metrics = [], [], [], []
    for index in range(plan.frame_times_s.size):
        classes = _Classes(plan)
        frame, _ = maker.part(index, plan.extent, classes)
        kinds.append(classes.kinds.ravel())
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
        level = float(each.mean(dtype=np.float64))  # deviations from the mean avoid cancellation
        off = each.astype(np.float64) - level
        first, second = (np.bincount(kind, power, minlength=number) for power in (off, off * off))
        sums = np.stack([np.append(np.sum(power), power) for power in (first, second)])
        one, two = sums[:, known] / pixels[known]
        mean[band, known] = level + one
        spread[band, known] = np.sqrt(np.maximum(two - one * one, 0.0))
    return mean, spread


def _levels(values: NDArray[np.float32], kind: NDArray[np.int8], number: int) -> NDArray[np.float32]:
    levels = np.full((values.shape[0], number + 1, LEVELS.size), np.nan, dtype=np.float32)
    for place in range(number + 1):
        own = values if place == 0 else values[:, kind == place - 1]
        if own.shape[1] == 0:
            continue
        ordered = np.sort(own, axis=1)
        position = LEVELS * own.shape[1] - 0.5
        low = np.clip(np.floor(position).astype(np.int64), 0, own.shape[1] - 1)
        high = np.minimum(low + 1, own.shape[1] - 1)
        weight = np.clip(position - low, 0.0, 1.0)
        levels[:, place] = ordered[:, low] * (1.0 - weight) + ordered[:, high] * weight
    return levels


def _metrics(thickness_m: NDArray[np.float32], cloudy: NDArray[np.bool_]) -> list[float]:
    """Metrics of one frame; only the coverage if the morphology is undefined."""
    coverage = float(np.mean(cloudy))
    try:
        shape = morphology(thickness_m, cloudy)
    except ImageError:
        return [coverage, *[np.nan] * (len(METRICS) - 1)]
    return [coverage, *(float(getattr(shape, name)) for name in METRICS[1:])]


def _mean_where_known(metrics: Array) -> Array:
    """Mean over frames (frame, metric), ignoring NaN; NaN if all are NaN."""
    known = np.isfinite(metrics)
    count = known.sum(axis=0)
    total = np.where(known, metrics, 0.0).sum(axis=0)
    return np.asarray(np.divide(total, count, out=np.full(count.shape, np.nan), where=count > 0))


_HELD = 4
"""Maximum number of sets of tables in memory: those of the current and the previous draw."""


@dataclass
class TableCount:
    """Numbers of scenes, of sets of tables that they needed, and of sets compiled for them.

    The other sets came from the cache of earlier runs. A set dropped from memory and needed again counts twice.
    """

    scenes: int = 0
    sets: int = 0
    compiled: int = 0


class SharedTables:
    """Provides the tables of successive plans."""

    def __init__(self) -> None:
        self.count = TableCount()
        self._held: OrderedDict[str, RadianceTables] = OrderedDict()
        self._temperatures: OrderedDict[bytes, BrightnessTemperature] = OrderedDict()

    def of(self, plan: Plan) -> RadianceTables:
        """Return the tables of a plan, bit-identical to those of a separate run."""
        self.count.scenes += 1
        key = f"{table_key(plan)} {plan.views} {plan.grid if plan.views is not None else None}"
        if key not in self._held:
            self.count.sets += 1
            compiled: list[Plan] = []  # one per view, if the view varies over pixels
            self._held[key] = tables_of(plan, partial(_noted, compiled))
            self.count.compiled += bool(compiled)
            while len(self._held) > _HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(key)
        return self._held[key]

    def temperature(self, plan: Plan) -> BrightnessTemperature:
        """Return the cached conversion of radiance to brightness temperature, whose table is slow to compute."""
        grid = plan.spectral_grid
        key = grid.wavenumber_cm1.tobytes() + grid.weights_cm1.tobytes()
        if key not in self._temperatures:
            self._temperatures.clear()
            self._temperatures[key] = BrightnessTemperature(grid, [band.name for band in plan.bands])
        return self._temperatures[key]


def _noted(compiled: list[Plan], plan: Plan) -> RadianceTables:
    compiled.append(plan)
    return compile_tables(plan)
