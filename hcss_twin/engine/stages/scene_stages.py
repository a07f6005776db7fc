"""The stages of a scene: truth, look-up, those of its effects, elements, and variables of whole parts.

What stages read and write decides their order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.variables import BETWEEN_COLUMNS, TERM_PREFIX, TOTAL
from hcss_twin.engine.stages.stage import Frame, FramePart, PartWindow, Stage
from hcss_twin.engine.stages.truth import Truth
from hcss_twin.plan.plan import Plan

if TYPE_CHECKING:
    from hcss_twin.engine.tables.radiance_tables import RadianceTables
    from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature


@dataclass(frozen=True)
class SceneTables:
    """What stages are made from.

    Attributes
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.
    axes : sequence of PointAxis
        Those along which the points of the plan differ.
    """

    plan: Plan
    tables: RadianceTables | None
    axes: Sequence[Any]

    def wants(self, effect: str) -> bool:
        """Whether radiance, or a variable about the effect, is computed."""
        return self.tables is not None or any(spec.needs == effect for spec in self.plan.computed)

    def named(self, name: str) -> list[Any]:
        """Return the axes of a name."""
        return [axis for axis in self.axes if axis.name == name]

    @property
    def point_effects(self) -> list[Any]:
        """Return the axes of effects of points, which change clear sky, too."""
        return [axis for axis in self.axes if axis.in_clear_sky]

    @property
    def of_surfaces(self) -> list[list[RadianceTables]]:
        """Tables of clear sky over each class of surface, at its lowest temperature.

        At all values of effects of points, toward all views.
        """
        if self.tables is None:
            return [[]]
        leaves = self.tables.leaves
        numbers: NDArray[np.intp] = np.arange(len(leaves)).reshape(*(len(axis.nodes) for axis in self.axes), -1)
        for place, axis in reversed(list(enumerate(self.axes))):
            if axis.name != "surfaces" and not axis.in_clear_sky:
                numbers = np.take(numbers, 0, place)
        surfaces = self.named("surfaces")
        of_classes = [numbers[nodes.start] for nodes in surfaces[0].of_classes] if surfaces else [numbers]
        return [[leaves[number] for number in of_class.ravel().tolist()] for of_class in of_classes]

    @property
    def sea(self) -> int:
        """Class of surface that is the scenario's sea, which alone has waves."""
        return next((axis.ground.sea for axis in self.named("surfaces")), 0)

    @property
    def of_sea(self) -> list[RadianceTables]:
        """Tables of the scenario's sea, as :attr:`of_surfaces`."""
        return self.of_surfaces[self.sea]


class LookUpStage(Stage):
    """Radiance of independent columns, from the tables."""

    title = "look-up of the radiance"
    writes = ("columns",)

    def __init__(self, plan: Plan) -> None:
        self._layers, self._samples = len(plan.layers), plan.samples_per_pixel

    def begin(self, part: FramePart) -> None:
        """Fill the whole part, without layers."""
        if part.look_up is not None and not self._layers:
            part.look_up.fill(part.radiance, (), self._samples)

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Fill a window of the part."""
        if part.look_up is not None and self._layers:
            corner = window.inside[0].start, window.inside[1].start
            part.look_up.fill(part.radiance, window.thickness_m, window.samples, corner)


class RadianceStage(Stage):
    """Radiance of complete parts, its terms, and the brightness temperature."""

    title = "terms and temperatures"
    reads = ("columns", "light between columns", "texture", "sunlight", "waves", "elements")
    writes = ("radiance",)

    def __init__(self, scene: SceneTables) -> None:
        plan = scene.plan
        self._names = () if scene.tables is None else scene.tables.quantities.names
        self._bands = len(plan.bands)
        self._between = any(spec.name == BETWEEN_COLUMNS for spec in plan.computed)
        self._temperature: BrightnessTemperature | None = None
        if any(spec.name == "brightness_temperature" for spec in plan.computed):
            from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature

            self._temperature = BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])

    def finish(self, part: FramePart, frame: Frame) -> None:
        """Add the quantities that were looked up, and what follows from the total."""
        for number, name in enumerate(self._names):
            bands = slice(number * self._bands, (number + 1) * self._bands)
            if name == TOTAL:
                frame[TOTAL] = part.shown[bands]
            else:  # of independent columns
                # The sea's light through thick cloud vanishes: interpolation may pass below 0, by far less than the
                # tables' error, which counts against the total.
                frame[TERM_PREFIX + name] = np.maximum(part.radiance[bands], 0.0)
        if self._between:
            frame[BETWEEN_COLUMNS] = part.shown[: self._bands] - part.radiance[: self._bands]
        if self._temperature is not None:
            frame["brightness_temperature"] = self._temperature(frame[TOTAL])


def _light(light: Any, scene: SceneTables) -> Iterator[Stage]:
    from hcss_twin.engine.stages.light import LightStage

    if scene.tables is not None:
        yield getattr(light.transport, "stage", LightStage)(scene.plan, scene.tables)


def _texture(texture: Any, scene: SceneTables) -> Iterator[Stage]:
    if scene.wants("texture"):
        from hcss_twin.engine.stages.texture import TextureStage

        yield TextureStage(scene.plan, texture, scene.tables, scene.axes, next(iter(scene.of_sea), None), scene.sea)


def _surfaces(_: Any, scene: SceneTables) -> Iterator[Stage]:
    from hcss_twin.engine.stages.surfaces import SurfaceStage

    yield from (SurfaceStage(axis.ground) for axis in scene.named("surfaces"))


def _shadows(_: Any, scene: SceneTables) -> Iterator[Stage]:
    if scene.wants("shadows"):
        from hcss_twin.engine.stages.shadows import ShadowStage

        yield ShadowStage(scene.plan, scene.of_surfaces, scene.point_effects)


def _waves(waves: Any, scene: SceneTables) -> Iterator[Stage]:
    if scene.wants("waves"):
        from hcss_twin.engine.stages.waves import WaveStage

        yield WaveStage(scene.plan, waves, scene.of_sea, scene.sea, scene.point_effects)


STAGES_OF_EFFECTS: Mapping[str, Callable[[Any, SceneTables], Iterator[Stage]]] = {
    "light": _light,
    "texture": _texture,
    "surfaces": _surfaces,
    "shadows": _shadows,
    "waves": _waves,
}
"""Stages of the effects of a plan, by :attr:`~hcss_twin.plan.effects.Effect.kind`; others have none."""


def stages_of(scene: SceneTables) -> list[Stage]:
    """Return the stages that a scene needs, in order; modules of others are not imported."""
    plan = scene.plan
    stages: list[Stage] = [Truth(plan, {axis.layer: axis.tops_m for axis in scene.named("tops")})]
    if scene.tables is not None:
        stages.append(LookUpStage(plan))
    for effect in plan.effects:
        if effect.kind in STAGES_OF_EFFECTS:
            stages += STAGES_OF_EFFECTS[effect.kind](effect, scene)
    if plan.assembly.elements:
        from hcss_twin.engine.stages.elements import ElementStage

        stages.append(ElementStage(plan, scene.point_effects))
    stages.append(RadianceStage(scene))
    if plan.assembly.derived:
        from hcss_twin.engine.stages.derived import DerivedStage

        stages.append(DerivedStage(plan))
    return ordered(stages)


def ordered(stages: Sequence[Stage]) -> list[Stage]:
    """Return stages so that each follows all that write what it reads; those that are free keep their order.

    Raises
    ------
    ValueError
        If two stages wait for each other.
    """
    left, order = list(stages), list[Stage]()
    while left:
        waiting = {name: stage for stage in left for name in stage.writes}
        free = [stage for stage in left if all(waiting.get(name, stage) is stage for name in stage.reads)]
        if not free:
            names = ", ".join(f"{type(stage).__name__} (reads {', '.join(stage.reads)})" for stage in left)
            raise ValueError(f"stages wait for each other: {names}")
        order.append(free[0])
        left.remove(free[0])
    return order
