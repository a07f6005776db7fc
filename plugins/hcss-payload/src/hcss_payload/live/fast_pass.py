"""Live frames in milliseconds: one layer of fractal clouds, from tiles of the sky as pixels see it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload
from hcss_payload.camera import Camera
from hcss_payload.checks import require_within
from hcss_payload.earth import SEMI_MAJOR_AXIS_M
from hcss_payload.examination import examine, examine_place
from hcss_payload.frames import Frame
from hcss_payload.live.footprints import PassFootprints
from hcss_payload.live.kernels import sky_rows, to_points
from hcss_payload.live.plane import fit_plane
from hcss_payload.live.prepared_pass import FrameCost, PreparedPass
from hcss_payload.live.radiance import FieldRadiance
from hcss_payload.live.sea import SeaTexture, field_nodes, node_weights
from hcss_payload.live.sensor import LiveSensor
from hcss_payload.live.sight import Sight, mesh_step, seen_m, view_and_sun, view_of_axis
from hcss_payload.live.sky import Sky, Tiles, tiles_around
from hcss_payload.live.target import TOP_M, PointTarget, SeenTarget, TargetLight
from hcss_payload.pose import Pose, pose_at
from hcss_payload.rays import geographic
from hcss_payload.shutter import LEAST_SMEAR_PX, largest_smear_px
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Points, Sun, View

FINENESS = 1.4
"""Points of a tile per width of the smallest footprint of a pass."""

_MARGIN_M = 20e3
"""Distance from what the nominal pass sees up to which frames may look, or more for large regions."""

_POSES = 33
"""Times of a pass at which footprints are determined."""

_AHEAD_S = 3.0
"""Time ahead of a frame for which tiles are made."""

_RATE_S = 1e-3
"""Time before and after a frame from which the motion of targets in the image follows."""

_STRIPS_PER_THREAD = 4

_RAREST, _FAINT = 5.0, 0.1
"""Standard deviations of a texture that no pixel exceeds, and share of the accuracy below which it is not listed."""


class FastPass(PreparedPass):
    """Frames of one layer of fractal clouds, whose detail within a pixel is averaged statistically.

    Parameters
    ----------
    plan : Plan
        Of the scene on the grid on the ground, with nothing that fast frames cannot show (:mod:`.fast_scenes`).
    omissions : tuple of Omission
        What the plan leaves out, to which the smear of the scene is added.
    highest_target_m : float, optional
        As :meth:`.twin.LiveTwin.prepare`.

    Attributes
    ----------
    errors : dict of str to float
        Measured in preparation: ``tables`` relative, between the tables along the pass; ``place_m`` of the plane.
    removed : (float, float)
        Smallest and largest share of the field's variance that is inside pixels.
    """

    method = "fast"

    def __init__(
        self,
        plan: Plan,
        payload: Payload,
        start_s: float,
        end_s: float,
        targets: Sequence[PointTarget],
        omissions: tuple[Omission, ...],
        threads: int,
        fineness: float,
        highest_target_m: float | None,
    ) -> None:
        super().__init__(plan, payload, start_s, end_s, targets)
        camera, trajectory, attitude, jitter = payload.camera, payload.trajectory, payload.attitude, payload.jitter
        self._camera, self._threads, self.omissions = camera, threads, omissions
        times = np.linspace(start_s, end_s, _POSES if end_s > start_s else 1)
        doubts = examine(trajectory, start_s, end_s)
        self._sensor = None if plan.scenario.sensor is None else LiveSensor(plan, camera)
        integration_s = payload.integration_s
        smear = largest_smear_px(camera, trajectory, attitude, jitter, times, integration_s)
        if smear >= LEAST_SMEAR_PX:
            self.omissions += (_smear_of_scene(smear, integration_s, self._sensor is not None),)
        poses = [pose_at(float(time), trajectory, attitude) for time in times]
        height = plan.layers[0].reference_height_m
        seen = np.concatenate([seen_m(camera, pose, height) for pose in poses])
        centre_deg = plan.scenario.place.latitude, plan.scenario.place.longitude
        seen_deg = np.stack(geographic(seen)[:2], axis=-1)
        apart_m = float(np.linalg.norm(np.ptp(seen[: len(seen) // times.size], axis=0)))
        positions_m = np.array([pose.position_m for pose in poses])
        self.notes = (*doubts, *examine_place(centre_deg, seen_deg, apart_m, positions_m))
        step = mesh_step(camera, poses[:: max(1, len(poses) // 4)], height)
        fit = fit_plane(seen, height, *centre_deg, 0.02 * _shortest(camera, poses), _MARGIN_M)
        self._sight = Sight(camera, fit, step)
        sea = np.concatenate([seen_m(camera, pose, 0.0) for pose in poses])
        self._sea_sight = Sight(
            camera, fit_plane(sea, 0.0, *centre_deg, 0.02 * _shortest(camera, poses), _MARGIN_M), step
        )
        footprints_m = np.array([self._sight.footprint_m(pose) for pose in poses])
        self._seen = PassFootprints(plan, times, footprints_m, fineness)
        self.removed, self.interval_s = self._seen.removed, self._seen.interval_s
        motion = plan.assembly.motion
        self._drift = np.array([motion.platform_speed_m_s, 0.0]) - np.array(motion.cloud_velocity_m_s)
        self._radiance = FieldRadiance(
            plan, self._view, self._seen.of_frame, self._views, start_s, end_s, plan.accuracy.relative
        )
        self._sea = SeaTexture(plan, float(np.min(np.hypot(footprints_m[:, 0], footprints_m[:, 1]))), step)
        self._field_weights = self._weights_of_field()
        self.omissions += self._finer_texture()
        self.errors = {"tables": self._radiance.error, "place_m": fit.error_m}
        views = [(float(time_s), self._view(float(time_s))) for time_s in self._radiance.times_s]
        self._light = TargetLight(plan, camera, views, self._radiance.edge)
        for target in targets:
            self._light.prepare(target)
        if highest_target_m is not None:
            require_within("highest_target_m", highest_target_m, 1.0, TOP_M, "m")
            self._light.prepare_up_to(highest_target_m)
        self._nodes, self._sea_nodes = np.empty((2, *self._sight.directions.shape[:2], 2))
        footprints = [
            self._tiles(float(time), self._sight.places(pose)) for time, pose in zip(times, poses, strict=True)
        ]
        self._corners = np.ascontiguousarray(self._sight.directions[[0, -1]][:, [0, -1]])
        # Those of a frame, of two keyframes and moved by what is seen ahead.
        capacity = 16 + 3 * max(
            (footprint.end_row - footprint.row + 2) * (footprint.end_column - footprint.column + 2)
            for footprint in footprints
        )
        self.sky = Sky(plan.scenario.seed, self._seen.of_tiles, self.interval_s, capacity, self._ahead)
        self.sky.require(footprints[0])
        self.sky.stalls = 0
        self._pool = ThreadPoolExecutor(self._threads, thread_name_prefix="live") if self._threads > 1 else None
        blocks = self._nodes.shape[0] - 1
        count = min(blocks, 1 if self._pool is None else _STRIPS_PER_THREAD * self._threads)
        bounds = [blocks * index // count for index in range(count + 1)]
        self._strips = list(itertools.pairwise(bounds))

    @property
    def has_numbers(self) -> bool:
        """Whether frames have digital numbers."""
        return self._sensor is not None and self._sensor.has_numbers

    @property
    def stalls(self) -> int:
        """Tiles of the sky that frames had to wait for."""
        return self.sky.stalls

    def warm_up(self, out: NDArray[np.float32] | None = None) -> FrameCost:
        """Compute a frame, which may compile for seconds, and measure what another one takes."""
        cost = super().warm_up(out)
        self.sky.stalls = 0
        return cost

    def _frame(
        self, time_s: float, pose: Pose | None, radiance: NDArray[np.float32], targets: Sequence[PointTarget]
    ) -> Frame:
        began = perf_counter()
        pose = self._payload.pose(time_s) if pose is None else pose
        scene = radiance if self._sensor is None else self._sensor.scene
        self._fill(time_s, pose, scene)
        filled = perf_counter()
        seen = list[tuple[PointTarget, SeenTarget]]()
        for target in targets:
            target_seen = self._light.seen(target, time_s, pose, lambda direction: self._field(time_s, pose, direction))
            if target_seen is not None:
                seen.append((target, target_seen))
        number, shown = None, perf_counter()
        if self._sensor is not None:
            number = self._sensor.measure(time_s, radiance, self._each, self._points(seen, time_s))
        else:
            for _, target_seen in seen:
                target_seen.add(scene)
        measured = perf_counter() - shown
        self.seconds = {"lines of sight, sky": filled - began, "targets": shown - filled, "sensor": measured}
        return Frame(pose, radiance, number)

    def close(self) -> None:
        """End the threads."""
        self.sky.close()
        if self._pool is not None:
            self._pool.shutdown()

    def _points(self, seen: Sequence[tuple[PointTarget, SeenTarget]], time_s: float) -> Points | None:
        """Return targets as the sensor draws them, with the motion that they have in the nominal pass."""
        if not seen:
            return None
        ends = max(time_s - _RATE_S, self.start_s), min(time_s + _RATE_S, self.end_s)
        rates = np.zeros((len(seen), 2))
        if ends[1] > ends[0]:
            before, after = (pose_at(end, self.trajectory, self.attitude) for end in ends)
            for rate, (target, _) in zip(rates, seen, strict=True):
                places = [self._light.pixel_of(target, pose.time_s, pose) for pose in (before, after)]
                rate[:] = np.subtract(places[1], places[0]) / (ends[1] - ends[0])
        position = np.array([(target_seen.row + 0.5, target_seen.column + 0.5) for _, target_seen in seen])
        light = np.stack([target_seen.light for _, target_seen in seen], axis=1)
        return Points(position[:, 0], position[:, 1], rates[:, 0], rates[:, 1], light)

    def _fill(self, time_s: float, pose: Pose, radiance: NDArray[np.float32]) -> None:
        nodes = self._sight.places(pose, self._nodes)
        _, later = self.sky.keyframe(time_s)
        tiles = self._tiles(time_s, nodes)
        slots = self.sky.require(tiles)
        self.sky.look_ahead(time_s)
        table, corner = self._radiance.at(time_s).reshape(-1), (tiles.row, tiles.column)
        views, per_K = self._radiance.clear_at(time_s)
        warmer_K = self._sea.at(self._sea_sight.places(pose, self._sea_nodes))
        clear = (self._field_weights @ views.astype(np.float32)).T.reshape(-1, *warmer_K.shape)
        clear = np.ascontiguousarray(clear + per_K.astype(np.float32)[:, None, None] * warmer_K.astype(np.float32))

        def strip(rows: tuple[int, int]) -> None:
            sky_rows(
                nodes,
                self._sight.step,
                rows,
                self.sky.pool,
                slots,
                corner,
                later,
                table,
                self._radiance.middle,
                clear,
                self._sea.fine,
                radiance,
            )

        self._each(strip, self._strips)

    def _each(self, work: Callable[[Any], None], parts: list[Any]) -> None:
        if self._pool is None:
            for part in parts:
                work(part)
        else:
            for _ in self._pool.map(work, parts):
                pass

    def _field(self, time_s: float, pose: Pose, direction: Array) -> float:
        """Return the field in a direction (3,) of the body within the image of the last frame."""
        position = self._sight.places(pose, directions=direction.reshape(1, 1, 3))
        tiles = self._tiles(time_s, position)
        return self.sky.value(position[0, 0], tiles, self.sky.require(tiles), float(self.sky.keyframe(time_s)[1]))

    def _view(self, time_s: float) -> View:
        """Return the nominal view of the optical axis."""
        return view_of_axis(self._plan, self._camera, pose_at(time_s, self.trajectory, self.attitude))

    def _views(self, time_s: float) -> list[tuple[View, Sun]]:
        """Return the nominal views toward the nodes of the field, and the suns of what they see."""
        pose = pose_at(time_s, self.trajectory, self.attitude)
        nodes = field_nodes(self._camera.rows, self._camera.columns).tolist()
        return [view_and_sun(self._plan, self._camera, pose, row, column) for row, column in nodes]

    def _weights_of_field(self) -> NDArray[np.float32]:
        """Return the weights (n x m, 25) of the nodes of the field at the finer nodes of the mesh."""
        parts, sizes = self._sea.parts, (self._camera.rows, self._camera.columns)
        up, across = (
            node_weights(2.0 * self._sea.fine * np.arange((count - 1) * parts + 1) / max(size - 1, 1) - 1.0)
            for count, size in zip(self._sight.directions.shape[:2], sizes, strict=True)
        )
        weights = up[:, None, :, None] * across[None, :, None, :]
        return weights.reshape(up.shape[0] * across.shape[0], -1).astype(np.float32)

    def _finer_texture(self) -> tuple[Omission, ...]:
        """Return what the mesh leaves out of the texture of the sea; nothing if it does not matter."""
        texture, clear = self._plan.texture, self._radiance.clear
        left_K = texture.temperature_K * self._sea.share_left**0.5
        relative = _RAREST * left_K * float(np.max(np.abs(clear.per_K) / clear.axis))
        if relative <= _FAINT * self._plan.accuracy.relative:
            return ()
        shown = f"fast frames show structures of the sea above {self._sea.finest_m:.3g} m"
        why = f"{shown}; what is finer has a standard deviation of {left_K:.2g} K"
        return (Omission("texture of the sea's temperature", why, relative, needs="frames of cubes"),)

    def _tiles(self, time_s: float, places: Array) -> Tiles:
        """Turn places in the plane into points of the sky, which drifts, in the same array; return their tiles."""
        keyframe = int(np.floor(time_s / self.interval_s))
        drift_x, drift_y = (self._drift * time_s).tolist()
        return tiles_around(to_points(places, drift_x, drift_y, self._seen.point_m(keyframe)), keyframe)

    def _ahead(self, time_s: float) -> Iterator[Tiles]:
        """Yield the tiles that frames soon after a time need."""
        for later in (0.25 * _AHEAD_S, _AHEAD_S, self.interval_s):
            at = min(time_s + later, self.end_s)
            pose = pose_at(at, self.trajectory, self.attitude)
            tiles = self._tiles(at, self._sight.places(pose, directions=self._corners))
            yield Tiles(tiles.row - 1, tiles.column - 1, tiles.end_row + 1, tiles.end_column + 1, tiles.keyframe)


def _shortest(camera: Camera, poses: list[Pose]) -> float:
    """Return about the smallest width of a pixel on the ground, m: at the altitude of the camera."""
    return camera.pixel_rad * min(float(np.linalg.norm(pose.position_m)) - SEMI_MAJOR_AXIS_M for pose in poses)


def _smear_of_scene(pixels: float, integration_s: float, sensor: bool) -> Omission:
    """Return the omission of the motion of the scene within the integration time."""
    why = f"live frames are instantaneous, and the ground moves by up to {pixels:.3g} pixels within {integration_s:g} s"
    smeared = "; the sensor smears targets by their own motion" if sensor else ""
    return Omission("smear of the scene", why + smeared, None, needs="a cube, whose scene smears")
