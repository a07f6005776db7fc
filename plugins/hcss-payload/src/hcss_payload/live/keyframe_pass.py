"""Live frames between keyframes: any scene in milliseconds, also one whose state follows images.

Keyframes are frames of cubes through a larger camera along the nominal pass, computed ahead of time in a process of
their own. A frame samples the two around its time where its pixels look, and mixes them. A new state of the scene has
another process; keyframes from the one at which it begins on are mixed from both, so that nothing jumps.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload, scene_of
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.frames import Frame
from hcss_payload.live.keyframe_store import SLOTS, StateProcess, wait_for
from hcss_payload.live.keyframe_worker import Image, Ready, Setup
from hcss_payload.live.prepared_pass import FrameCost, PreparedPass, StateChange
from hcss_payload.live.resampling import REACH, between_keyframes
from hcss_payload.live.sensor import LiveSensor
from hcss_payload.live.sight import mesh_step
from hcss_payload.live.target import PointTarget
from hcss_payload.pose import Pose, pose_at
from hcss_payload.rays import meet
from hcss_twin import Scenario, make_plan

BLEND_S = 10.0
"""Least time in which one state turns into the next."""

LONGEST_S, SHORTEST_S = 32.0, 0.5
"""Limits of the time between keyframes."""

_AHEAD = 2
"""Keyframes that are computed ahead of those around a frame; fewer than slots, so that none in use is overwritten."""

_WORST = 0.99
"""Quantile of the pixels whose error decides on the time between keyframes."""


@dataclass(eq=False)
class _Pending:
    """An image whose state does not begin yet; ``begins`` is None if it may at once."""

    number: int
    image: Image
    begins: int | None
    process: StateProcess | None = None


class KeyframePass(PreparedPass):
    """Frames between keyframes.

    Parameters
    ----------
    scenario : Scenario
        With or without the sections of the camera, which ``payload`` is.
    margin_px : float
        Pixels by which frames may look beside the nominal pass.
    follower : str, optional
        ``"module:object"`` of what makes a state of an image (:class:`.keyframe_worker.Follower`).
    keyframe_s : float, optional
        Time between keyframes; by default the longest whose error in the middle between them is within the scenario's
        accuracy in 99 % of the pixels, between 0.5 and 32 s.

    Attributes
    ----------
    errors : dict of str to float
        ``keyframes``: that relative error, where it was measured.
    keyframe_s, blend_s : float
        Time between keyframes, and in which one state turns into the next.
    """

    method = "keyframes"

    def __init__(
        self,
        scenario: Scenario,
        payload: Payload,
        start_s: float,
        end_s: float,
        margin_px: float,
        threads: int = 2,
        follower: str | None = None,
        keyframe_s: float | None = None,
    ) -> None:
        if not end_s > start_s:
            raise PayloadError(f"start_s, end_s: {start_s:g} to {end_s:g} s; allowed: a pass with some duration")
        if keyframe_s is not None:
            require_within("keyframe_s", keyframe_s, 1e-3, 3600.0, "s")
        camera = payload.camera
        self._step = mesh_step(
            camera, [pose_at(at, payload.trajectory, payload.attitude) for at in (start_s, end_s)], 0.0
        )
        rows, columns = (self._step * np.arange(-(-size // self._step) + 1.0) for size in (camera.rows, camera.columns))
        self._directions = camera.directions(rows[:, None], columns[None, :])
        # Nodes of the mesh lie up to a step beyond the detector.
        margin = math.ceil(margin_px) + REACH + self._step
        self._margin_px, (row, column) = margin_px, camera.centre
        self._wide = replace(
            camera, rows=camera.rows + 2 * margin, columns=camera.columns + 2 * margin,
            principal_point=(row + margin, column + margin),
        )  # fmt: skip
        shape = len(scenario.bands), self._wide.rows, self._wide.columns
        of_keyframes = replace(payload, camera=self._wide, jitter=None)
        self._setup = Setup(
            _bare(scenario, "sensor").to_json(), str(scenario.base), of_keyframes, start_s, end_s, shape
        )
        self._mixed, self._mixed_of = np.empty((SLOTS, *shape), np.float32), [(-1, -1)] * SLOTS
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="live") if threads > 1 else None
        lines = -(-camera.rows // (4 * threads))
        self._strips = [(first, first + lines) for first in range(0, camera.rows, lines)]
        self._poses = dict[float, Pose]()
        self._follower, self._pending, self._asked, self._count = follower, list[_Pending](), -1, 0
        self._stalls, self.state_number, self._refusals = 0, 0, list[str]()
        self._states, self._begins = [StateProcess(0, self._setup)], [0]
        self._processes = [*self._states]
        try:
            # The process plans the whole scene meanwhile; sensor, bands and accuracy are those of a clear sky, too.
            plan = make_plan(_bare(scene_of(scenario), "clouds"))
            super().__init__(plan, payload, start_s, end_s, ())
            self._sensor = None if plan.scenario.sensor is None else LiveSensor(plan, camera)
            ready = self._first_ready()
            self.omissions, self.notes, self._height_m = ready.omissions, ready.notes, ready.height_m
            self.keyframe_s = self._chosen_s(keyframe_s)
        except BaseException:
            self.close()
            raise
        self._last = round((end_s - start_s) / self.keyframe_s)
        self._ramp = math.ceil(BLEND_S / self.keyframe_s)
        self.blend_s = self._ramp * self.keyframe_s

    @property
    def has_numbers(self) -> bool:
        """Whether frames have digital numbers."""
        return self._sensor is not None and self._sensor.has_numbers

    @property
    def stalls(self) -> int:
        """Keyframes that frames had to wait for."""
        return self._stalls

    @property
    def states(self) -> tuple[StateChange, ...]:
        """States of images that have begun or whose beginning is known, in their order."""
        return tuple(
            StateChange(state.number, self._time_s(begins), self._time_s(begins + self._ramp))
            for state, begins in zip(self._states, self._begins, strict=True)
            if state.number
        )

    def assimilate(
        self, image: Any, time: datetime | None = None, begins_s: float | None = None, file: str | None = None
    ) -> int:
        """Let the scene take an image as its state, and return the number of this state.

        The state is prepared in another process, image after image. Frames from ``begins_s`` on turn into it within
        ``blend_s``.

        Parameters
        ----------
        image : object
            What the follower takes; None: that of ``file``.
        time : datetime
            Of the image.
        begins_s : float, optional
            When it begins, later than any frame so far; frames then wait for it. By default as soon as it is
            prepared; ``states`` has the time.
        file : str, optional
            From which the follower reads the image and its time.

        Raises
        ------
        PayloadError
            If nothing is known about how the scene follows images, or frames have gone past the beginning.
        """
        if self._follower is None:
            raise PayloadError(
                "assimilate: nothing makes a state of an image in this scene; allowed: clouds of a generator that "
                "follows images ('followed' of hcss-follow)"
            )
        begins = None
        if begins_s is not None:
            require_within("begins_s", begins_s, self.start_s, self.end_s, "s")
            begins = math.ceil((begins_s - self.start_s) / self.keyframe_s - 1e-9)
            known = [each.begins for each in self._pending if each.begins is not None]
            least = max(self._asked, *(each + self._ramp for each in (*self._begins[1:], *known)), 0)
            if begins < least:
                raise PayloadError(
                    f"begins_s: {begins_s:g} s; allowed: {self._time_s(least):g} s or later, since keyframes up to "
                    "then are computed, or belong to another state"
                )
        self._count += 1
        self._pending.append(_Pending(self._count, Image(self._follower, image, time, file), begins))
        self._advance()
        return self._count

    def look(self) -> list[str]:
        """Take up states that have been prepared, and return why others could not be, since the last call."""
        self._advance()
        refusals, self._refusals = self._refusals, []
        return refusals

    def close(self) -> None:
        """End the processes and threads."""
        for process in self._processes:
            process.close()
        if self._pool is not None:
            self._pool.shutdown()

    def warm_up(self, out: NDArray[np.float32] | None = None) -> FrameCost:
        """Compute a frame, which may compile for seconds, and measure what another one takes."""
        cost = super().warm_up(out)
        self._stalls = 0
        return cost

    def _frame(
        self, time_s: float, pose: Pose | None, radiance: NDArray[np.float32], targets: Sequence[PointTarget]
    ) -> Frame:
        if targets:
            raise PayloadError("targets: between keyframes there are none; allowed: method = 'fast' or 'cube'")
        began = perf_counter()
        pose = self._payload.pose(time_s) if pose is None else pose
        position = (time_s - self.start_s) / self.keyframe_s
        first = min(math.floor(position), self._last - 1)
        self._advance()
        if first >= self._begins[-1] + self._ramp:
            for state in self._states[:-1]:
                state.end()
        before, after = self._keyframe(first), self._keyframe(first + 1)
        for ahead in range(first + 2, min(first + 2 + _AHEAD, self._last + 1)):
            self._ask(ahead)
        there = perf_counter()
        scene = radiance if self._sensor is None else self._sensor.scene
        self._sample(pose, (self._time_s(first), self._time_s(first + 1)), (before, after), position - first, scene)
        self.state_number = next(
            state.number
            for state, begins in zip(self._states[::-1], self._begins[::-1], strict=True)
            if begins <= position
        )
        sampled = perf_counter()
        number = None if self._sensor is None else self._sensor.measure(time_s, radiance, self._each)
        measured = perf_counter()
        self.seconds = {"keyframes": there - began, "sampling": sampled - there, "sensor": measured - sampled}
        return Frame(pose, radiance, number)

    def _time_s(self, number: int) -> float:
        return self.start_s + number * self.keyframe_s if number < self._last else self.end_s

    def _parts(self, number: int) -> list[tuple[StateProcess, float]]:
        """Return the states of a keyframe with their weights."""
        index = max(index for index, begins in enumerate(self._begins) if begins <= number)
        share = 1.0 if index == 0 else min(1.0, (number - self._begins[index]) / self._ramp)
        parts = [(self._states[index], share)] if share else []
        if share < 1.0:
            parts.insert(0, (self._states[index - 1], 1.0 - share))
        if any(state.is_over for state, _ in parts):
            raise PayloadError(
                f"time_s: keyframe at {self._time_s(number):g} s belongs to a state that is over; allowed: times from "
                f"{self._time_s(self._begins[-1]):g} s on"
            )
        return parts

    def _ask(self, number: int) -> None:
        for state, _ in self._parts(number):
            state.ask(number, self._time_s(number))
        self._asked = max(self._asked, number)

    def _keyframe(self, number: int) -> NDArray[np.float32]:
        """Return a keyframe, mixed where one state turns into another."""
        self._await_state_of(number)
        parts = self._parts(number)
        self._ask(number)
        states = [state for state, _ in parts]
        if not all(state.has(number) for state in states):
            for state in states:
                state.receive()
        late = not all(state.has(number) for state in states)
        self._stalls += late
        while late:
            wait_for(states)
            late = not all(state.has(number) for state in states)
        if len(parts) == 1:
            return states[0].keyframe(number)
        slot, key = number % SLOTS, (number, states[1].number)
        if self._mixed_of[slot] != key:
            (old, keep), (new, share) = parts
            np.multiply(old.keyframe(number), np.float32(keep), out=self._mixed[slot])
            self._mixed[slot] += np.float32(share) * new.keyframe(number)
            self._mixed_of[slot] = key
        mixed: NDArray[np.float32] = self._mixed[slot]
        return mixed

    def _await_state_of(self, number: int) -> None:
        """Wait for a state that was asked to have begun before a keyframe."""
        while self._pending and (begins := self._pending[0].begins) is not None and begins < number:
            process = self._pending[0].process
            if process is None or (process.ready is None and not process.failed):
                self._stalls += 1
                if process is not None:
                    wait_for([process])
            self._advance()

    def _advance(self) -> None:
        """Take what processes have sent: start the next state, let a prepared one begin, end those that are over."""
        while self._pending:
            pending = self._pending[0]
            if pending.process is None:
                latest = self._states[-1].ready
                assert latest is not None
                setup = replace(self._setup, scenario=latest.scenario, image=pending.image)
                pending.process = StateProcess(pending.number, setup)
                self._processes.append(pending.process)
            pending.process.receive()
            if pending.process.failed:
                self._refusals.append(f"state {pending.number}: {pending.process.failed}")
                pending.process.end()
            elif pending.process.ready is None:
                return
            else:
                free = self._begins[-1] + (self._ramp if len(self._begins) > 1 else 0)
                begins = max(self._asked, free) if pending.begins is None else pending.begins
                self._states.append(pending.process)
                self._begins.append(begins)
            self._pending.pop(0)

    def _first_ready(self) -> Ready:
        (first,) = self._states
        while first.ready is None:
            wait_for([first])
        return first.ready

    def _sample(
        self,
        pose: Pose,
        times_s: tuple[float, float],
        keyframes: tuple[Any, Any],
        later: float,
        out: NDArray[np.float32],
    ) -> None:
        met = meet(pose.position_m, pose.to_earth(self._directions), self._height_m)
        places = np.empty((2, *met.shape[:2], 2))
        for place, time_s in zip(places, times_s, strict=True):
            seen_from = self._nominal(time_s)
            place[..., 0], place[..., 1] = self._wide.pixels(seen_from.to_body(met - seen_from.position_m))
        low, high = float(places.min()), np.array([self._wide.rows, self._wide.columns]) - 1 - REACH
        if not (low >= REACH - 1 and np.all(places.max(axis=(0, 1, 2)) <= high)):
            raise PayloadError(
                f"pose: at time {pose.time_s:g} s pixels look farther than {self._margin_px:g} pixels beside the "
                "nominal pass; allowed: poses near those of the pass, or a larger margin_px"
            )
        self._each(partial(between_keyframes, places, self._step, *keyframes, later, out), self._strips)

    def _nominal(self, time_s: float) -> Pose:
        """Return the pose of a keyframe, which many frames use."""
        if time_s not in self._poses:
            if len(self._poses) >= SLOTS:
                self._poses.clear()
            self._poses[time_s] = pose_at(time_s, self.trajectory, self.attitude)
        return self._poses[time_s]

    def _each(self, work: Any, parts: list[Any]) -> None:
        if self._pool is None:
            for part in parts:
                work(part)
        else:
            for _ in self._pool.map(work, parts):
                pass

    def _chosen_s(self, stated_s: float | None) -> float:
        """Return the time between keyframes, by the error in the middle between the first two."""
        (state,), start, camera = self._states, self.start_s, self._payload.camera
        duration = self.end_s - start
        interval = duration / math.ceil(duration / (LONGEST_S if stated_s is None else stated_s) - 1e-9)
        out = np.empty((len(self._plan.bands), camera.rows, camera.columns), np.float32)
        true = np.empty_like(out)

        def keyframe(number: int, later_s: float) -> NDArray[np.float32]:
            state.ask(number, start + later_s)
            while not state.has(number):
                wait_for([state])
            return state.keyframe(number)

        first, number = keyframe(0, 0.0), 1
        after = keyframe(1, interval)
        while True:
            number += 1
            middle = keyframe(number, 0.5 * interval)
            pose = pose_at(start + 0.5 * interval, self.trajectory, self.attitude)
            self._sample(pose, (start, start + interval), (first, after), 0.5, out)
            self._sample(pose, (pose.time_s, pose.time_s), (middle, middle), 0.0, true)
            self.errors = {"keyframes": float(np.quantile(np.abs(out / true - 1.0), _WORST))}
            is_accurate = self.errors["keyframes"] <= self._plan.accuracy.relative
            if is_accurate or stated_s is not None or 0.5 * interval < SHORTEST_S:
                state.forget(2 if number == 2 else 1)  # the others are not where they were
                return interval
            interval, after = 0.5 * interval, middle
            # The first keyframe stays where it is; the others take turns in the other slots.
            number += (number + 1) % SLOTS == 0


def _bare(scene: Scenario, section: str) -> Scenario:
    """Return a scenario of radiance alone, without a section."""
    data = json.loads(scene.to_json())
    data["output"] |= {"variables": ["radiance"], "derived": [], "certificate": 0}
    data.pop(section, None)
    return Scenario.from_dict(data, base=scene.base, origin=scene.origin)
