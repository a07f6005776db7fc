"""The image geometry of a camera in orbit, through which ``hcss run`` writes cubes in focal-plane coordinates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload, payload_of
from hcss_payload.checks import PayloadError
from hcss_payload.complete import complete
from hcss_payload.directions import directions_around, view_of
from hcss_payload.disk import Disk
from hcss_payload.disk_scene import climate_of, disk_notes, whole_disk
from hcss_payload.examination import examine, examine_place
from hcss_payload.limb import Limb
from hcss_payload.pixel_variables import PIXEL_VARIABLES, TANGENT_HEIGHT, coordinates
from hcss_payload.ray_clouds import RayClouds, require_in_reach
from hcss_payload.ray_elements import RayElementStage
from hcss_payload.ray_geometry import GROUND, LARGEST_WITH_LIMB_DEG, LARGEST_ZENITH_DEG, FrameGeometry
from hcss_payload.ray_look_up import RayLookUp, frame_views
from hcss_payload.ray_surfaces import RaySurfaceStage
from hcss_payload.rays import geographic
from hcss_payload.reference_pixel import solve_pixel
from hcss_payload.sampled_pass import FIELD, sample_pass
from hcss_payload.shutter import LEAST_SMEAR_PX, Exposure, Shutter, exposure_of, instants_for, largest_smear_px
from hcss_payload.zonal_disk import ZonalDisk
from hcss_twin import Scenario
from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.cube.header import ImageLayout
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.plan.accuracy import RequestedAccuracy
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.surroundings import FilledIn
from hcss_twin.plan.windows import Window
from hcss_twin.providers import View

TIMES = 33
"""Times of the pass at which directions and extent are sampled."""

FEWEST_POINTS, MOST_POINTS = 3, 8
"""Points along a pixel that are chosen without being asked for: between those of the scene, one point of a pixel shows
20 to 50 % too much contrast between neighbours, 3 leave up to 4 %."""

NOTES = (
    "camera: lines of sight are geometric, without aberration and refraction; pixels are points of the focal plane, "
    "without optics and detector",
    "camera: clouds are met at the height of each layer's flat side",
)

ONE_SUN = "camera: each pixel has its own view, but the sun and the air of [place]"

_SMEARLESS = "views, and the clouds before small elements, are those of its middle"

LIMB_NOTE = (
    "camera: limb, and ground beyond view zenith 85 deg, are clear air of the profile of [place] along refracted lines "
    "of sight above a black sea; their clouds and scattered sunlight are left out"
)


def make_imager(scenario: Scenario, catalog: Catalog) -> CameraImager:
    """Return the imager of a scenario with ``[camera]`` and ``[orbit]``.

    Raises
    ------
    ScenarioError
        If a section is invalid, contradicts other keys, or the camera looks beyond what is computed.
    """
    return camera_imager(scenario, payload_of(scenario, catalog), catalog)


def camera_imager(scenario: Scenario, payload: Payload, catalog: Catalog) -> CameraImager:
    """Return the imager of a payload above a scenario; raises as :func:`make_imager`."""
    _require_no_other_view(scenario)
    return CameraImager(scenario, payload, catalog)


def _require_no_other_view(scenario: Scenario) -> None:
    view, platform, motion = scenario.view, scenario.platform, scenario.motion
    given = {
        "view.zenith": view.zenith != 0.0,
        "view.azimuth": view.azimuth != 0.0,
        "motion.platform_speed": motion.platform_speed != 0.0,
        "image.window": scenario.image.window is not None,
        "slant.parallax": scenario.slant.parallax,
        "slant.shadows": scenario.slant.shadows,
        "output.derived": bool(scenario.output.derived),
        **{f"platform.{name}": getattr(platform, name) is not None for name in type(platform).model_fields},
    }
    problems = [
        Problem(
            name,
            "given together with [camera]; allowed: without it (the camera has its own view and parallax, and "
            "cannot show shadows or derived variables)",
        )
        for name, present in given.items()
        if present
    ]
    if scenario.sea.waves == "resolved":
        problems.append(Problem("sea.waves", "'resolved' with [camera]; allowed: 'averaged'; closest is 'averaged'"))
    if problems:
        raise ScenarioError(problems)


class CameraImager:
    """Image geometry of a camera in orbit; implements :class:`hcss_twin.plan.imager.Imager`."""

    def __init__(self, scenario: Scenario, payload: Payload, catalog: Catalog) -> None:
        self._payload, self._scenario = payload, scenario
        self._largest_deg = LARGEST_WITH_LIMB_DEG if payload.beyond == "limb" else LARGEST_ZENITH_DEG
        self.camera = payload.camera
        self.rows, self.columns = self.camera.rows, self.camera.columns
        self._centre = scenario.place.latitude, scenario.place.longitude
        frames = scenario.frames
        first, last = (float(number * frames.interval) for number in (frames.first, frames.first + frames.count - 1))
        self._times_s = (frames.first + np.arange(frames.count, dtype=np.float64)) * frames.interval
        self._last: tuple[float, FrameGeometry] | None = None
        self._limb: Limb | None = None
        self.notes: tuple[str, ...] = ()
        self.filled_in: tuple[FilledIn, ...] = ()
        # The same times for every list of frames between the same ends: tables depend on them.
        times = np.unique(np.linspace(first, last, TIMES if last > first else 1))
        with _named():
            doubts = examine(payload.trajectory, first, last)
        self._shutter = self._shutter_over(times)
        jitter = payload.jitter
        margin = 0.0 if jitter is None else jitter.largest_rad / self.camera.pixel_rad
        seen = sample_pass(self.camera, self._geometry, self._require_ground, times, margin, self._largest_deg)
        self.views, footprints = directions_around(seen.toward, seen.limit_deg), seen.footprint_m
        self.climate = climate_of(scenario, catalog, payload.climate)
        disk = whole_disk(scenario, catalog, payload.trajectory, self.views, seen, times, self.climate is not None)
        if disk is not None:
            self.views, self._centre, self._last = disk, disk.centre, None
        else:
            apart_m = max(self.rows, self.columns) / (FIELD - 1) * float(np.max(footprints))
            positions_m = np.array([payload.trajectory.at(each) for each in times.tolist()])
            places = seen.place_deg
            if payload.beyond == "limb":  # whose scene is the disk below the camera
                places = np.concatenate((places, np.stack(geographic(positions_m)[:2], axis=-1)))
            with _named():
                doubts += examine_place(self._centre, places, apart_m, positions_m)
        middle, _ = self._geometry(float(times[times.size // 2])).nodes()
        self.view = view_of(middle[len(middle) // 2]) if len(middle) else view_of(seen.toward[len(seen.toward) // 2])
        self._extent = (*_range(seen.place_deg[:, 0]), *_range(seen.place_deg[:, 1]))
        self.pixel_size_m = float(np.median(footprints))
        point_m = scenario.image.pixel_size / scenario.image.samples_per_pixel
        own = min(max(FEWEST_POINTS, int(np.ceil(np.max(footprints) / point_m - 0.5))), MOST_POINTS)
        instants = self._shutter.instants
        self.points = -(-(payload.points or own) // instants) * instants
        self.notes = (
            *NOTES,
            *self.notes,
            *doubts,
            *((ONE_SUN,) if disk is None else disk_notes(self.climate is not None)),
            *((LIMB_NOTE,) if payload.beyond == "limb" else ()),
            *(() if instants == 1 else (f"camera: {instants} instants within the integration time; {_SMEARLESS}",)),
            f"camera: {self.points} x {self.points} points per pixel; its footprint is {np.min(footprints):.4g} to "
            f"{np.max(footprints):.4g} m, points of the scene are {point_m:.4g} m apart",
        )

    def _require_ground(self, kind: NDArray[np.uint8], time_s: float) -> None:
        if self._payload.beyond != "refuse" or np.all(kind == GROUND):
            return
        share = 100.0 * float(np.mean(kind != GROUND))
        message = (
            f"'refuse', and at time {time_s:g} s {share:.3g} % of the image see the Earth beyond zenith "
            f"{LARGEST_ZENITH_DEG:g} deg, its limb or space; allowed: a pass or field without, 'missing' or 'limb'"
        )
        raise ScenarioError([Problem("camera.beyond", message)])

    def _geometry(self, time_s: float) -> FrameGeometry:
        if self._last is None or self._last[0] != time_s:
            with _named():
                pose = self._payload.pose(time_s)
            lines = self._shutter.lines(time_s, self.camera, self._payload.pose)
            self._last = time_s, FrameGeometry(self.camera, pose, self._centre, lines, self._largest_deg)
        return self._last[1]

    def _exposure(self, time_s: float) -> Exposure:
        return exposure_of(self._shutter, time_s, self.camera, self._payload.pose)

    def _shutter_over(self, times_s: Array) -> Shutter:
        """Return the shutter with the instants that the largest smear of the pass needs."""
        payload, follows = self._payload, self._payload.integration_from
        if payload.integration_s == 0.0:
            return Shutter(line_s=payload.line_s)
        with _named():
            smear = largest_smear_px(
                self.camera, payload.trajectory, payload.attitude, payload.jitter, times_s, payload.integration_s
            )
            instants = instants_for(smear, follows or "camera.integration_time")
        if follows is None:
            return Shutter(payload.integration_s, payload.line_s, instants)
        if instants == 1:  # small elements smear in the sensor
            self.notes = (
                f"camera: the scene moves by {smear:.2g} pixels within {follows}, and does not smear (below "
                f"{LEAST_SMEAR_PX:g} pixels); small elements do",
            )
            return Shutter(line_s=payload.line_s)
        why = f"that of {follows}, in which the scene moves by up to {smear:.2g} pixels"
        self.filled_in = (FilledIn("camera.integration_time", f"{payload.integration_s:g} s", why),)
        return Shutter(payload.integration_s, payload.line_s, instants)

    def variables(self, requested: tuple[VariableSpec, ...]) -> tuple[VariableSpec, ...]:
        """Return the requested variables, missing where nothing is computed, and the coordinates of pixels."""
        kept = (spec for spec in requested if spec.kind != "geometry")
        if self._payload.beyond != "refuse":
            kept = (
                replace(spec, may_be_missing=True) if np.dtype(spec.dtype).kind == "f" and spec.needs_radiance else spec
                for spec in kept
            )
        return (*kept, *PIXEL_VARIABLES, *((TANGENT_HEIGHT,) if self._payload.beyond == "limb" else ()))

    def require_supported(self, plan: Plan) -> None:
        """Raise a :class:`ScenarioError` that names what a camera cannot show yet."""
        problems = []
        for number, (layer, generator) in enumerate(zip(plan.layers, plan.assembly.generators, strict=True)):
            if not 0.0 < layer.coverage < 1.0 or getattr(generator, "image_coverage", None) is not None:
                continue
            if layer.coverage_mode == "frame":
                field = self._scenario.field_as_typed(f"clouds.layers[{number}].coverage_mode")
                message = "'frame' with [camera]: the image moves over the clouds; allowed: 'field'; closest is 'field'"
                problems.append(Problem(field, message))
        if plan.tops is not None:
            problems.append(Problem("clouds", "tops of their own with [camera]; allowed: tops of the layer"))
        if plan.assembly.air_over_field is not None and self.climate is None:
            problems.append(Problem("atmosphere.profile", "several profiles with [camera]; allowed: one"))
        if problems:
            raise ScenarioError(problems)
        try:
            for time_s in (self._times_s[0], self._times_s[self._times_s.size // 2], self._times_s[-1]):
                clouds = self.clouds(plan, float(time_s))
                for layer_number in range(len(plan.layers)):
                    below = clouds.below(layer_number)
                    if below is not None:
                        require_in_reach(plan, layer_number, below, float(time_s))
        except PayloadError as error:
            raise ScenarioError([Problem("image", str(error))]) from error
        self._limb = Limb(plan) if self._payload.beyond == "limb" and plan.needs_radiance else None

    def layout(self, plan: Plan) -> ImageLayout:
        """Return rows, columns and poses, and the extent of the ground that the frames show."""
        poses = [self._payload.pose(float(time_s)) for time_s in self._times_s]
        return ImageLayout(coordinates(self.rows, self.columns, poses), *self._extent)

    def clouds(self, plan: Plan, time_s: float) -> RayClouds:
        """Return the clouds of a frame."""
        return RayClouds(plan, self.camera, self._exposure(time_s))

    def look_up(self, plan: Plan, time_s: float, look_ups: Sequence[LookUp]) -> RayLookUp:
        """Return the look-up of a frame."""
        assert plan.views is not None
        geometry = self._geometry(time_s)
        views = frame_views(plan.views, self.views, geometry, [each.table for each in look_ups])
        return RayLookUp(views, look_ups, self.views, geometry)

    def surface_stage(self, plan: Plan, tables: Any) -> RaySurfaceStage:
        """Return the surfaces at the points of the frames."""
        return RaySurfaceStage(plan, tables, self._geometry, self._exposure, self.views)

    def element_stage(self, plan: Plan) -> RayElementStage:
        """Return the elements as the camera sees them."""
        pose, still = self._payload.pose, replace(self._shutter, instants=1)

        def clouds(time_s: float) -> RayClouds:
            return RayClouds(plan, self.camera, exposure_of(still, time_s, self.camera, pose))

        return RayElementStage(plan, self._geometry, clouds, self._shutter, pose)

    def views_of_pixels(self, time_s: float, rows: Sequence[int], columns: Sequence[int]) -> list[View]:
        """Return the exact view of pixels."""
        row, column = (np.asarray(each, dtype=np.float64) for each in (rows, columns))
        rays = self._geometry(time_s).exact(row, column)
        if isinstance(self.views, Disk | ZonalDisk):
            return self.views.views_of(rays.position_m)
        return [view_of(toward) for toward in rays.toward]

    def solve(self, solved: Callable[[Array], Array], columns: Array, accuracy: RequestedAccuracy) -> Array:
        """Return the values of the columns of a pixel of the certificate."""
        return solve_pixel(solved, columns, accuracy.relative)

    def unseen(self, time_s: float, window: Window) -> NDArray[np.bool_] | None:
        """Return which pixels of a window do not show the ground that is computed."""
        geometry = self._geometry(time_s)
        kind = geometry.window(*window).kind
        self._require_ground(kind, time_s)
        beyond: NDArray[np.bool_] = kind != GROUND
        return beyond if beyond.any() else None

    def complete(self, frame: dict[str, NDArray[Any]], time_s: float, extent: Window) -> None:
        """Add the coordinates of the pixels; set space to 0 and what is not computed to missing."""
        complete(frame, self._geometry(time_s), extent, self._payload.beyond == "limb", self._limb)


@contextmanager
def _named() -> Iterator[None]:
    """Turn errors of trajectory, attitude and camera into those of their keys of the scenario."""
    try:
        yield
    except PayloadError as error:
        field, _, message = str(error).partition(": ")
        raise ScenarioError([Problem(field.replace("trajectory", "orbit"), message)]) from error


def _range(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())
