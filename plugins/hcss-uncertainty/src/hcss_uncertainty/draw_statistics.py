"""Statistics of one scene: radiance and what a sensor measures by pixel class and band, and cloud metrics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from hcss_evaluate.measures.morphology import morphology
from numpy.typing import NDArray

from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, ImageError, Problem, ScenarioError
from hcss_uncertainty.pixel_maps import CLOUD

if TYPE_CHECKING:
    from hcss_uncertainty.payload import Payload

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

SPREAD = "_spread"
"""Suffix of the standard deviation over the pixels of a class."""


@dataclass(frozen=True)
class DrawStatistics:
    """Statistics over all frames of one scene; NaN for classes without pixels.

    Attributes
    ----------
    values : mapping of str to ndarray (band, class)
        Means over the pixels of a class of radiance, in W m-2 sr-1, brightness temperature, in K, and what a sensor
        measures, their standard deviations (``..._spread``), and figures of merit of the sensor.
    pixels : ndarray (class,)
    metrics : ndarray (metric,)
        Means over the frames that have them.
    levels : mapping of str to ndarray (band, class, level)
        Quantiles of radiance and measured quantities over pixels at ``LEVELS``; may be empty.
    """

    values: Mapping[str, Array]
    pixels: NDArray[np.int64]
    metrics: Array
    levels: Mapping[str, NDArray[np.float32]]


class _Classes:
    """Observes the thickness of each window as frames are computed, and records the class of each pixel."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.kinds = np.zeros(plan.pixels, dtype=np.int8)

    def observe(self, seen: Any) -> None:
        """Process a window, in pixels of the computed part, which here is the whole image."""
        rows, columns = seen.inside
        shape = rows.stop - rows.start, columns.stop - columns.start
        self.kinds[seen.inside] = Certificate.stratum_of(
            self._plan.layers, seen.thickness_m, shape, self._plan.samples_per_pixel
        )


def class_names(layers: int) -> tuple[str, ...]:
    """Return the pixel classes of a scene with ``layers`` layers: those of certificates, and ``all``."""
    return (ALL, *Certificate.stratum_names(layers))


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
) -> tuple[DrawStatistics, dict[str, NDArray[Any]]]:
    """Compute the variables ``VARIABLES`` of all frames of a scene, and what its sensor measures, and summarise them.

    ``temperature`` belongs to the plan's spectral grid; ``with_levels`` adds quantiles over pixels. Returns the
    statistics, and the values (band, pixel) of all pixels and frames, with the cloud mask (pixel,). Raises
    ProviderError if a provider violates its contract.
    """
    maker = PartMaker(plan, tables)
    payload: Payload | None = None
    if plan.sensor.stages:
        from hcss_uncertainty.payload import Payload  # not for scenes without a sensor

        payload = Payload(plan, tables)
    kinds, masks, metrics = [], [], []
    frames: dict[str, list[NDArray[Any]]] = {}
    for index in range(plan.frame_times_s.size):
        classes = _Classes(plan)
        frame, _ = maker.part(index, plan.extent, classes)
        radiance, cloudy = frame["radiance"], frame["cloud_mask"] > 0
        found = {"radiance": radiance, "brightness_temperature": temperature(radiance)}
        if payload is not None:
            found |= payload.measure(index, radiance)
        for name, values in found.items():
            frames.setdefault(name, []).append(values.reshape(len(plan.bands), -1))
        kinds.append(classes.kinds.ravel())
        masks.append(cloudy.ravel())
        metrics.append(_metrics(frame["cloud_thickness"], cloudy))
    kind = np.concatenate(kinds)
    number = len(Certificate.stratum_names(len(plan.layers)))
    pixels = np.bincount(kind, minlength=number)
    total = np.concatenate([[kind.size], pixels]).astype(np.int64)
    every = {name: np.concatenate(values, axis=1) for name, values in frames.items()}
    moments = _all_moments(every, kind, number, total)
    if payload is not None:
        off, spread = (moments[f"{payload.DIFFERENCE}{end}"] for end in ("", SPREAD))
        moments = payload.with_figures_of_merit(moments, off**2 + spread**2)
        every = {name: values for name, values in every.items() if name not in payload.AUXILIARY}
    levels = {
        name: _levels(values, kind, number)
        for name, values in every.items()
        if with_levels and name != "brightness_temperature"  # from the levels of radiance
    }
    if with_levels:
        flat = levels["radiance"].reshape(len(plan.bands), -1).astype(np.float64)
        kelvin = temperature.where_known(flat).reshape(levels["radiance"].shape)
        levels["brightness_temperature"] = kelvin.astype(np.float32)
    statistics = DrawStatistics(moments, total, _mean_where_known(np.array(metrics)), levels)
    return statistics, {**every, CLOUD: np.concatenate(masks)}


def _all_moments(
    every: Mapping[str, NDArray[Any]], kind: NDArray[np.int8], number: int, pixels: NDArray[np.int64]
) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, values in every.items():
        found[name], found[f"{name}{SPREAD}"] = _moments(values, kind, number, pixels)
    return found


def _moments(
    values: NDArray[Any], kind: NDArray[np.int8], number: int, pixels: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Mean and standard deviation of values (band, pixel) over the pixels of each class, (band, class)."""
    mean, spread = np.full((2, values.shape[0], pixels.size), np.nan)
    known = pixels > 0
    for band, value in enumerate(values):
        level = float(value.mean(dtype=np.float64))  # deviations from the mean avoid cancellation
        off = value.astype(np.float64) - level
        first, second = (np.bincount(kind, power, minlength=number) for power in (off, off * off))
        sums = np.stack([np.append(np.sum(power), power) for power in (first, second)])
        one, two = sums[:, known] / pixels[known]
        mean[band, known] = level + one
        spread[band, known] = np.sqrt(np.maximum(two - one * one, 0.0))
    return mean, spread


def _levels(values: NDArray[Any], kind: NDArray[np.int8], number: int) -> NDArray[np.float32]:
    levels = np.full((values.shape[0], number + 1, LEVELS.size), np.nan, dtype=np.float32)
    for class_number in range(number + 1):
        class_values = values if class_number == 0 else values[:, kind == class_number - 1]
        if class_values.shape[1] == 0:
            continue
        ordered = np.sort(class_values, axis=1)
        position = LEVELS * class_values.shape[1] - 0.5
        low = np.clip(np.floor(position).astype(np.int64), 0, class_values.shape[1] - 1)
        high = np.minimum(low + 1, class_values.shape[1] - 1)
        weight = np.clip(position - low, 0.0, 1.0)
        levels[:, class_number] = ordered[:, low] * (1.0 - weight) + ordered[:, high] * weight
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
