"""Live frames through the stages of cubes: what ``hcss run`` shows through a camera, from any pose near its pass."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload
from hcss_payload.frames import Frame
from hcss_payload.live.live_rays import LiveRays
from hcss_payload.live.prepared_pass import PreparedPass
from hcss_payload.live.target import PointTarget
from hcss_payload.pose import Pose
from hcss_payload.rays import geographic
from hcss_payload.scene_plane import to_scene
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Catalog, Declaration, ElementPoint, ElementScene, Points, Problem, ScenarioError

MARGIN = 0.25
"""Share of the detector's longer side by which frames may look beside those of the pass, by default."""

_TICKS_PER_S, _BETWEEN = 10**6, 2**40
"""Frames between those of the scenario are numbered for sensors by their time in microseconds, above this number."""

_STEP_S = 1e-3
"""Time before and after a frame from which the velocity of targets in the plane of the scene follows."""


@dataclass(eq=False)
class LiveTargets:
    """The point targets of a frame as elements of the scene.

    Attributes
    ----------
    place_deg : (float, float)
        Latitude and longitude of the centre of the scene.
    now : sequence of PointTarget
        Those of the next frame.
    """

    place_deg: tuple[float, float]
    now: Sequence[PointTarget] = ()
    declares: Declaration = field(default_factory=Declaration)
    variables: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    def pixels(self, time_s: float, rows: slice, columns: slice, scene: ElementScene) -> Sequence[ElementPoint]:
        """Return the targets at a time; those below the ground are not there."""
        return [point for target in self.now if (point := self._point(target, time_s)).altitude_m >= 0.0]

    def _point(self, target: PointTarget, time_s: float) -> ElementPoint:
        before, now, after = (self._in_scene_m(target.position_m(time_s + later)) for later in (-_STEP_S, 0.0, _STEP_S))
        x_m, y_m, altitude_m = now.tolist()
        east, north, up = ((after - before) / (2.0 * _STEP_S)).tolist()
        return ElementPoint(
            x_m,
            y_m,
            altitude_m,
            intensity=np.array(target.intensity),
            velocity_m_s=(east, north, up),
            temperature_K=target.temperature_K,
        )

    def _in_scene_m(self, position_m: Array) -> Array:
        """Return x, y and altitude (3,) of an Earth-fixed position."""
        latitude, longitude, altitude_m = geographic(position_m[None])
        x_m, y_m, _ = to_scene(latitude, longitude, self.place_deg)
        # Rounding puts ships a micrometre below the sea.
        return np.array([x_m[0], y_m[0], altitude_m[0] if abs(altitude_m[0]) > 1e-3 else 0.0])


class PosedScene(SceneAround):
    """The scene that a sensor measures through a pose, also at the instants that its stages ask for.

    Attributes
    ----------
    number : int
        Of the scenario's frame at or before the pose; noise has numbers of its own.
    """

    number = 0

    def at(self, frame: int, time_s: float, rows: slice, columns: slice) -> tuple[Array, Points | None]:
        """Return the radiance of a window of the scene, and its small elements, at another time."""
        return super().at(self.number, time_s, rows, columns)


class ScenePass(PreparedPass):
    """Frames of a pass with the pixels of its cube: bit by bit those of ``hcss run`` at its times, without a margin.

    Parameters
    ----------
    scenario : Scenario
        With or without the sections of the camera, which ``payload`` is.
    margin_px : float, optional
        Pixels by which frames may look beside those of the pass; by default a quarter of the detector.

    Raises
    ------
    ScenarioError
        If no cube shows the scene through a camera, or the sensor remembers earlier frames; names the field.
    """

    method = "cube"

    def __init__(
        self,
        scenario: Scenario,
        payload: Payload,
        start_s: float,
        end_s: float,
        targets: Sequence[PointTarget] = (),
        margin_px: float | None = None,
    ) -> None:
        margin = MARGIN * max(payload.camera.rows, payload.camera.columns) if margin_px is None else margin_px
        made = list[LiveRays]()

        def rays(planned: Scenario, catalog: Catalog) -> LiveRays:
            made.append(LiveRays(planned, payload, catalog, margin))
            return made[0]

        plan = make_plan(_of_radiance(scenario), rays=rays)
        super().__init__(plan, payload, start_s, end_s, targets)
        for target in targets:
            target.require_bands(len(plan.bands))
        (self._rays,) = made
        self._shown = LiveTargets((scenario.place.latitude, scenario.place.longitude))
        self.omissions = tuple(item for item in plan.omissions if item.bound != 0.0 and item.size)
        self.notes = plan.notes
        self.height_m = plan.layers[0].reference_height_m if plan.layers else 0.0
        tables = tables_of(plan)
        shown = replace(plan, assembly=replace(plan.assembly, elements=(*plan.assembly.elements, self._shown)))
        radiance = tuple(spec for spec in plan.variables if spec.name == "radiance")
        shown = replace(shown, variables=radiance, computed=radiance)
        self._maker = PartMaker(shown, tables)
        self._measured = _measured_scene(shown, tables) if plan.sensor.stages else None

    @property
    def has_numbers(self) -> bool:
        """Whether frames have digital numbers."""
        return self._measured is not None and any(
            spec.name == "digital_number" for spec in self._measured.sensor.variables
        )

    def _frame(
        self, time_s: float, pose: Pose | None, radiance: NDArray[np.float32], targets: Sequence[PointTarget]
    ) -> Frame:
        for target in targets:
            target.require_bands(len(self._plan.bands))
        self._rays.steer(pose)
        self._shown.now = targets
        times_s, first = self._plan.frame_times_s, self._plan.scenario.frames.first
        index = int(np.searchsorted(times_s, time_s, side="right")) - 1
        arrays, _ = self._maker.part(index, self._plan.extent, time_s=time_s)
        pose = self._payload.pose(time_s) if pose is None else pose
        self.seconds = self._maker.seconds
        if self._measured is None:
            radiance[:] = arrays["radiance"]
            return Frame(pose, radiance)
        began, self._measured.number = perf_counter(), first + index
        scene, points = self._measured.frame(index, arrays["radiance"], time_s)
        number = first + index if times_s[index] == time_s else _BETWEEN + round(time_s * _TICKS_PER_S)
        measured = self._measured.sensor.measure(scene, number, time_s, points)
        radiance[:] = measured["radiance"]
        self.seconds = {**self.seconds, "sensor": perf_counter() - began}
        return Frame(pose, radiance, measured.get("digital_number"))


def _of_radiance(scenario: Scenario) -> Scenario:
    """Return a scenario of radiance alone, without a certificate, which takes frames of a cube."""
    data = json.loads(scenario.to_json())
    data["output"] |= {"variables": ["radiance"], "derived": [], "certificate": 0}
    return Scenario.from_dict(data, base=scenario.base, origin=scenario.origin)


def _measured_scene(plan: Plan, tables: RadianceTables) -> PosedScene:
    """Return the scene behind the sensor of a plan, with its numbers whether the scenario asks for them or not."""
    sensor = plan.sensor
    if sensor.remembers:
        stage = next(stage for stage in sensor.stages if stage.provider.declares.remembers)
        message = (
            f"'{stage.entry.name}' remembers earlier frames, and live frames are those of any poses in any order; "
            "allowed: sensors whose frames depend on their time alone"
        )
        raise ScenarioError([Problem(stage.field, message)])
    names = tuple(name for stage in sensor.stages for name in stage.provider.variables if name == "digital_number")
    return PosedScene(plan, tables, sensor.measuring(names))
