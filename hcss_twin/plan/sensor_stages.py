"""Stages of a sensor: a chain of sensor providers, each of which measures what the one before it gives."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.plan.builder import Built, attribute_to_field
from hcss_twin.plan.sensor_geometry import examine_geometry
from hcss_twin.providers import Measured, Points, SceneInfo, SensorInputs
from hcss_twin.providers import Sensor as SensorModel
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.instrument import NamedInstrument, load_instrument
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.sensor import SensorSection, StageSection, choose_sensor

__all__ = ["Stage"]

Source = Callable[[int, float, slice, slice], tuple[Array, Points | None]]
"""Radiance (B, rows, columns) of the scene, and its small elements apart: number of a frame, time in s, rows and
columns of the measured image, from which the places of the elements count."""

TOLERANCE_S = 1e-9
"""Tolerance of the times at which a stage may ask for the scene."""


class StageScene:
    """The radiance that a stage receives at other instants: ``SensorInputs.scene_at``.

    Parameters
    ----------
    source : callable or None
        The scene; None where only the frames are known.
    earlier : sequence of Stage
        Stages through which the scene is seen.
    """

    instants: tuple[float, float] | None = None
    points_apart: bool = False

    def __init__(self, source: Source | None, earlier: Sequence[Stage], inputs: SensorInputs) -> None:
        self._source, self._earlier = source, tuple(earlier)
        self._whole = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
        self._now: tuple[int, float] | None = None
        self._last: tuple[int, float, Array] | None = None

    def begin(self, frame: int, time_s: float) -> None:
        """Tell which frame is measured, and at which time."""
        self._now, self._last = (frame, time_s), None

    def __call__(self, time_s: float, rows: slice, columns: slice) -> Array:
        """Return radiance as :attr:`hcss_twin.providers.SensorInputs.scene_at`.

        Raises
        ------
        ProviderError
            If nothing is measured, or the time or the window is not among those declared.
        """
        if self.instants is None:
            raise ProviderError("scene_at: the sensor has no attribute instants and so must not ask for other instants")
        if self._source is None or self._now is None:
            raise ProviderError("scene_at: the scene is known only while a run measures its frames")
        frame, now = self._now
        low, high = self.instants
        if not low - TOLERANCE_S <= time_s - now <= high + TOLERANCE_S:
            raise ProviderError(
                f"scene_at: {time_s - now:.9g} s after the frame is not among the instants {low:g} to {high:g} s"
            )
        for name, pixels, whole in zip(("rows", "columns"), (rows, columns), self._whole, strict=True):
            if not (0 <= pixels.start <= pixels.stop <= whole.stop):
                raise ProviderError(f"scene_at: {name} {pixels} are not in the frame; allowed: 0 to {whole.stop}")
        if not self._earlier:
            return self._given(*self._source(frame, time_s, rows, columns))
        if self._last is None or self._last[:2] != (frame, time_s):
            radiance, points = self._source(frame, time_s, *self._whole)
            for stage in self._earlier:
                measured, points = stage.measure(radiance, frame, time_s, points)
                radiance = measured.radiance
            radiance = self._given(radiance, points)
            self._last = frame, time_s, radiance.astype(np.float64, copy=False)
        return self._last[2][:, rows, columns]

    def _given(self, radiance: Array, points: Points | None) -> Array:
        """Return radiance as the stage gets it: with the small elements, unless it gets these apart."""
        return radiance if points is None or self.points_apart else with_points(radiance, points)


def with_points(radiance: NDArray[Any], points: Points) -> NDArray[Any]:
    """Return radiance (B, y, x) with small elements in the pixels that hold them."""
    total: NDArray[Any] = (radiance + points.in_pixels(*radiance.shape[1:])).astype(radiance.dtype)
    return total


@dataclass(frozen=True)
class Stage:
    """A guarded sensor provider and its settings.

    Attributes
    ----------
    field : str
        Its section in the scenario.
    section : StageSection
        The user's settings.
    named : NamedInstrument or None
        The named instrument file.
    entry : Entry
        Registry entry of the model.
    parameters : mapping
        All parameters, with defaults; empty if the model has none.
    built : Built
        How it was made.
    """

    field: str
    section: StageSection
    named: NamedInstrument | None
    entry: Entry
    parameters: Mapping[str, Any]
    provider: SensorModel
    seed: int
    scene: StageScene
    built: Built

    @property
    def title(self) -> str:
        """Title for users."""
        return self.entry.name if self.named is None else self.named.title

    @property
    def instants(self) -> tuple[float, float] | None:
        """Earliest and latest time at which it asks for the scene, s after that of the frame; None: at no other."""
        return self.scene.instants

    @property
    def smear_time_s(self) -> float | None:
        """Integration time in which motion smears what it measures; None if there is none."""
        return _smear_time_s(self.parameters)

    def measure(
        self, radiance: NDArray[Any], frame: int, time_s: float, points: Points | None = None
    ) -> tuple[Measured, Points | None]:
        """Return the measurement of a frame (B, y, x), which it cannot write to, and the points it leaves to others.

        A stage that neither draws points nor leaves them has them in the pixels that hold them.
        """
        sensor: Any = self.provider
        draws, leaves = hasattr(sensor, "measure_with"), hasattr(sensor, "points_after")
        if points is not None and not draws and not leaves:
            radiance, points = with_points(radiance, points), None
        single = getattr(sensor, "single_precision", False)
        given: NDArray[Any] = radiance.astype(np.float32 if single else np.float64, copy=False).view()
        given.flags.writeable = False
        self.scene.begin(frame, time_s)
        if points is not None and draws:
            return sensor.measure_with(given, points, frame, time_s), None
        return sensor.measure(given, frame, time_s), None if points is None else sensor.points_after(points)

    def as_dict(self, **more: str) -> dict[str, Any]:
        """Plain values for plan and provenance."""
        return {
            "name": self.section.name,
            "title": self.title,
            "model": self.entry.name,
            "distribution": self.entry.distribution,
            "version": self.entry.version,
            "seed": self.seed,
            **more,
            "parameters": dict(self.parameters),
            "worked_out": dict(getattr(self.provider, "worked_out", {})),
            "sources": {} if self.named is None else dict(self.named.sources),
        }

    @staticmethod
    def examine_geometry(data: Mapping[str, Any], stages: Sequence[Stage], binned: float = 1.0) -> tuple[str, ...]:
        """Return what is doubtful about the geometry of a sensor; raises ScenarioError for contradictions.

        Parameters
        ----------
        data : mapping
            A scenario as JSON, with the sections of plugins; any of these may have ``focal_length`` and
            ``detector_pitch``, and ``integration_time``.
        binned : float
            Pixels of the scenario along the side of a measured one.
        """
        return examine_geometry(data, stages, binned)

    @staticmethod
    def smear_of_sensor(sensor: SensorSection, catalog: Catalog) -> tuple[float, str] | None:
        """Return the integration time in which motion smears a measurement, s, and its key; None if there is none.

        For those who need it before the sensor is built, which is after the rays of the scene.

        Raises
        ------
        CatalogError, ScenarioError
            If there is no such sensor file, or it is wrong.
        ProviderError
            If no installed package has the model.
        """
        registry = Registry.discover()
        for index, stage in enumerate(sensor.stages or (sensor,)):
            choice = choose_sensor(stage, catalog)
            model = registry.parameters_model(registry.resolve(Kind.SENSORS, choice.model))
            defaults = (
                {} if model is None else {name: parameter.default for name, parameter in model.model_fields.items()}
            )
            time_s = _smear_time_s({**defaults, **choice.parameters})
            if time_s is not None:
                return time_s, f"sensor{f'.stages[{index}]' if sensor.stages else ''}.parameters.integration_time"
        return None

    @staticmethod
    def build(
        section: SensorSection, inputs: SensorInputs, source: Source | None = None, about: SceneInfo | None = None
    ) -> tuple[Stage, ...]:
        """Build the stages of a section; a section without ``stages`` is the only one.

        Parameters
        ----------
        inputs : SensorInputs
            With the scenario's seed, which the section may override. Later stages have seeds of their own.
        source : callable, optional
            The scene at other instants.
        about : SceneInfo, optional
            For sensors that take it.

        Raises
        ------
        ScenarioError
            Names the invalid key.
        ProviderError
            If a sensor model is broken.
        """
        base = inputs.seed if section.seed is None else section.seed
        stages: list[Stage] = []
        for index, stage_section in enumerate(section.stages or (section,)):
            field = f"sensor.stages[{index}]" if section.stages else "sensor"
            seed = _later_seed(base, index) if stage_section.seed is None else stage_section.seed
            with _of_stage(field):
                stages.append(_build(stage_section, field, replace(inputs, seed=seed), source, stages, about))
            remembers = [stage for stage in stages[:-1] if stage.provider.declares.remembers]
            if stages[-1].instants is not None and remembers:
                message = (
                    f"'{stages[-1].entry.name}' asks for the scene at other instants, as the stages before it measure "
                    f"it, and '{remembers[0].entry.name}' remembers earlier frames; allowed: the other order"
                )
                raise ScenarioError([Problem(f"{field}.model", message)])
        return tuple(stages)


def _smear_time_s(parameters: Mapping[str, Any]) -> float | None:
    """Return the integration time in which motion smears what a stage measures; None if there is none.

    There is none without an integration time, with ``smear = false``, and with ``exposures`` of the stage's own, which
    are the scene at as many instants.
    """
    time_s, exposures = parameters.get("integration_time"), parameters.get("exposures")
    if not isinstance(time_s, int | float) or not parameters.get("smear", True) or (exposures or 1) != 1:
        return None
    return float(time_s) if time_s > 0 else None


def _build(
    section: StageSection,
    field: str,
    inputs: SensorInputs,
    source: Source | None,
    earlier: Sequence[Stage],
    about: SceneInfo | None,
) -> Stage:
    with attribute_to_field(f"{field}.name"):
        if section.name is not None:
            load_instrument(section.name, inputs.catalog)
        choice = choose_sensor(section, inputs.catalog)
    registry = inputs.catalog.shelf.get_or_compute("registry", Registry.discover)
    scene = StageScene(source, earlier, inputs)
    inputs = replace(inputs, scene_at=scene)
    with attribute_to_field(f"{field}.model", choice.parameters):
        entry = registry.resolve(Kind.SENSORS, choice.model)
        parameters = _parameters(registry.parameters_model(entry), choice.parameters, field)

        def make(inputs: SensorInputs) -> SensorModel:
            sensor: SensorModel = guard(entry, registry.create(entry, inputs, parameters, about), inputs)
            return sensor

        provider = make(inputs)
        instants = getattr(provider, "instants", None)
    scene.instants = None if instants is None else (float(instants[0]), float(instants[1]))
    scene.points_apart = hasattr(provider, "points_after")
    dumped = {} if parameters is None else parameters.model_dump(mode="json")
    try:
        json.dumps(dict(getattr(provider, "worked_out", {})))
    except (TypeError, ValueError) as error:
        raise ProviderError(f"{entry.label}: worked_out cannot be written as JSON: {error}") from error
    built = Built(entry, parameters, inputs, provider, make)
    return Stage(field, section, choice.named, entry, dumped, provider, inputs.seed, scene, built)


def _later_seed(seed: int, index: int) -> int:
    """Return the seed of a stage: that of the sensor for the first, others for later ones."""
    if index == 0:
        return seed
    return int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1, np.uint64)[0] >> np.uint64(1))


@contextmanager
def _of_stage(field: str) -> Iterator[None]:
    """Attribute problems that a provider finds in the parameters of a sensor to those of its stage."""
    try:
        yield
    except ScenarioError as error:
        named = [
            Problem(problem.field.replace("sensor.parameters", f"{field}.parameters", 1), problem.message)
            if problem.field.startswith("sensor.parameters")
            else problem
            for problem in error.problems
        ]
        raise ScenarioError(named, error.origin) from error


def _parameters(model: type[BaseModel] | None, given: Mapping[str, Any], field: str) -> BaseModel | None:
    if model is None:
        if given:
            raise ScenarioError([Problem(f"{field}.parameters", "the model takes none; allowed: none")])
        return None
    try:
        return model.model_validate(dict(given))
    except ValidationError as error:
        raise ScenarioError(problems_from(error, model, prefix=f"{field}.parameters", raw=given)) from error
