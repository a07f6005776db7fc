"""Images of a scenario from poses that are known only when they are needed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Literal, get_args

from hcss_payload.attitude import Attitude
from hcss_payload.build import Payload, scene_of
from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.jitter import Jitter
from hcss_payload.live.fast_pass import FINENESS, FastPass
from hcss_payload.live.fast_scenes import EFFECT, excluded_by_payload, excluded_by_plan, excluded_by_scenario
from hcss_payload.live.keyframe_pass import KeyframePass
from hcss_payload.live.keyframe_worker import follower_named
from hcss_payload.live.prepared_pass import PreparedPass
from hcss_payload.live.scene_pass import MARGIN, ScenePass
from hcss_payload.live.target import PointTarget
from hcss_payload.trajectory import Trajectory
from hcss_twin import Scenario, make_plan
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.providers import Catalog, choose_from

__all__ = ["FINENESS", "LiveTwin", "Method", "PointTarget", "PreparedPass"]

Method = Literal["auto", "fast", "cube", "keyframes"]

_NOT_FAST = ("shadows of clouds on the sea", "waves as shapes", "texture of water vapour")


class LiveTwin:
    """A scenario and a camera, ready to be prepared for passes.

    Parameters
    ----------
    scenario : Scenario
        The scene. Its sensor, if any, is applied to the pixels of the camera.
    threads : int
        Threads that compute a fast frame; frames do not depend on it.
    fineness : float
        Points of the sky of fast frames per width of a pixel's footprint.
    method : {"auto", "fast", "cube", "keyframes"}
        ``"fast"``: one layer of fractal clouds in milliseconds, whose detail within a pixel is statistical and whose
        omissions are listed. ``"cube"``: the pixels of ``hcss run``, through the same stages, of any scene that it
        shows through a camera. ``"auto"``: fast frames of the scenes that have them, and those of cubes of all others.
        ``"keyframes"``: in milliseconds between the frames of cubes of a process of its own, also of scenes that follow
        images (:mod:`.keyframe_pass`).
    margin_px : float, optional
        Pixels by which frames of cubes may look beside those of the pass; by default a quarter of the detector.
    follower : str, optional
        ``"module:object"`` that makes a state of an image, for keyframes; by default that of the clouds' generator.
    keyframe_s : float, optional
        Time between keyframes; by default chosen by their error.

    Raises
    ------
    ScenarioError
        If fast frames are asked for and cannot show the scenario; names the fields.
    """

    def __init__(
        self,
        scenario: Scenario,
        camera: Camera,
        threads: int = 2,
        fineness: float = FINENESS,
        method: Method = "auto",
        margin_px: float | None = None,
        follower: str | None = None,
        keyframe_s: float | None = None,
    ) -> None:
        require_within("threads", threads, 1, 64)
        require_within("fineness", fineness, 1.0, 16.0)
        if margin_px is not None:
            require_within("margin_px", margin_px, 0.0, 65536.0, "pixels")
        if method not in get_args(Method):
            raise PayloadError(f"method: '{method}'; {choose_from(str(method), get_args(Method))}")
        self.scenario, self.camera, self.method = scenario, camera, method
        self._threads, self._fineness, self._margin_px = threads, fineness, margin_px
        self._fast: tuple[Plan, tuple[Omission, ...]] | None = None
        self._why: tuple[Excluded, ...] = ()
        self._follower, self._keyframe_s = follower, keyframe_s
        if method not in ("cube", "keyframes"):
            self._fast = self._planned()

    def prepare(
        self,
        trajectory: Trajectory,
        attitude: Attitude,
        start_s: float,
        end_s: float,
        jitter: Jitter | None = None,
        target: PointTarget | Sequence[PointTarget] | None = None,
        highest_target_m: float | None = None,
        integration_s: float | None = None,
    ) -> PreparedPass:
        """Compile the tables of a pass, and make the sky below its start.

        Parameters
        ----------
        trajectory, attitude
            Of the nominal pass. Frames may have other poses near those of the pass; view, footprint and sun of fast
            frames are those of the pass at the time of the frame.
        start_s, end_s : float
            Within the scenario's frames.
        jitter : Jitter, optional
            Of poses that :meth:`PreparedPass.frame` makes itself.
        target : PointTarget or sequence of them, optional
            Sources in the scene.
        highest_target_m : float, optional
            Altitude up to which fast frames may have targets that are decided on at run time; by default none but those
            with altitude and colour of ``target``. Frames of cubes may have any.
        integration_s : float, optional
            Integration time, whose smear fast frames omit; by default that of the sensor.

        Raises
        ------
        PayloadError, ScenarioError
            If the pass is too long, or the camera looks beyond what is computed.
        """
        followed: tuple[float | None, str | None] = integration_s, None
        if integration_s is None and self.scenario.sensor is not None:
            followed = Stage.smear_of_sensor(self.scenario.sensor, Catalog(base=self.scenario.base)) or (None, None)
        seconds, key = followed
        payload = Payload(self.camera, trajectory, attitude, jitter, integration_s=seconds or 0.0, integration_from=key)
        return self.prepare_payload(payload, start_s, end_s, target, highest_target_m)

    def prepare_payload(
        self,
        payload: Payload,
        start_s: float,
        end_s: float,
        target: PointTarget | Sequence[PointTarget] | None = None,
        highest_target_m: float | None = None,
    ) -> PreparedPass:
        """Prepare the pass of a payload, with all that the sections of a camera say; else as :meth:`prepare`."""
        frames = self.scenario.frames
        first, last = (float(number * frames.interval) for number in (frames.first, frames.first + frames.count - 1))
        if not first <= start_s <= end_s <= last:
            raise PayloadError(
                f"start_s, end_s: {start_s:g} to {end_s:g} s; allowed: within {first:g} to {last:g} s, the frames of "
                "the scenario"
            )
        targets = [] if target is None else [target] if isinstance(target, PointTarget) else list(target)
        why, table = [excluded.what.rstrip(",") for excluded in self._why], excluded_by_payload(payload)
        if self.method == "fast":
            Excluded.require_none(EFFECT, table, "method = 'cube'")
        why += [excluded.what for excluded in table if excluded.present] if self._fast is not None else []
        if self._fast is not None and not why:
            try:
                return FastPass(
                    self._fast[0],
                    payload,
                    start_s,
                    end_s,
                    targets,
                    self._fast[1],
                    self._threads,
                    self._fineness,
                    highest_target_m,
                )
            except PayloadError as error:
                if self.method == "fast":
                    raise
                why.append(f"this pass ({error})")
        if self.method == "keyframes":
            if targets:
                raise PayloadError("target: between keyframes there are none; allowed: method = 'fast' or 'cube'")
            margin_px = (
                MARGIN * max(self.camera.rows, self.camera.columns) if self._margin_px is None else self._margin_px
            )
            follower = follower_named(self.scenario) if self._follower is None else self._follower
            return KeyframePass(
                self.scenario, payload, start_s, end_s, margin_px, self._threads, follower, self._keyframe_s
            )
        prepared = ScenePass(self.scenario, payload, start_s, end_s, targets, self._margin_px)
        if why:
            reason = f"frames are those of cubes, since fast frames do not show {'; '.join(why)}"
            prepared.notes = (reason, *prepared.notes)
        return prepared

    def _planned(self) -> tuple[Plan, tuple[Omission, ...]] | None:
        """Return the plan of fast frames, and what they omit of what is on by default; None if they have not all."""
        scenario = scene_of(self.scenario)
        if self._excludes(excluded_by_scenario(scenario)):
            return None
        plan = make_plan(_of_columns(scenario))
        if self._excludes(excluded_by_plan(plan)):
            return None
        by_default = (scenario.slant.shadows, scenario.sea.waves, scenario.atmosphere.water_vapour_texture or "auto")
        wanted = [what for what, value in zip(_NOT_FAST, by_default, strict=True) if value == "auto"]
        omissions = tuple(item for item in plan.omissions if item.what in wanted and item.bound != 0.0)
        return plan, omissions

    def _excludes(self, table: tuple[Excluded, ...]) -> bool:
        if self.method == "fast":
            Excluded.require_none(EFFECT, table, "method = 'cube'")
        self._why = tuple(excluded for excluded in table if excluded.present)
        return bool(self._why)


def _of_columns(scenario: Scenario) -> Scenario:
    """Return a scenario without what is on by default and fast frames do not show; parallax is that of their rays."""
    data = json.loads(scenario.to_json())
    for section, name in (("slant", "shadows"), ("slant", "parallax"), ("sea", "waves")):
        if data[section][name] == "auto":
            data[section][name] = "off"
    data["atmosphere"]["water_vapour_texture"] = data["atmosphere"]["water_vapour_texture"] or 0.0
    return Scenario.from_dict(data, base=scenario.base, origin=scenario.origin)
