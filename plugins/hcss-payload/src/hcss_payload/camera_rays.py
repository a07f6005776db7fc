"""The rays of a camera in orbit, through which ``hcss run`` writes cubes in focal-plane coordinates."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from datetime import UTC
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.build import Payload, payload_of
from hcss_payload.camera_points import CameraPoints, Window
from hcss_payload.checks import PayloadError
from hcss_payload.complete import complete
from hcss_payload.directions import PassDirections, directions_around, view_of
from hcss_payload.disk import Disk
from hcss_payload.disk_scene import climate_of, disk_notes, whole_disk
from hcss_payload.examination import examine, examine_place
from hcss_payload.limb import Limb
from hcss_payload.pass_text import assumed, pass_notes
from hcss_payload.passes import LOWEST_DEG, direction_deg, next_pass
from hcss_payload.pixel_variables import PIXEL_VARIABLES, TANGENT_HEIGHT, coordinates
from hcss_payload.ray_geometry import GROUND, LARGEST_WITH_LIMB_DEG, LARGEST_ZENITH_DEG, FrameGeometry
from hcss_payload.rays import geographic
from hcss_payload.sampled_pass import FIELD, sample_pass
from hcss_payload.sections import OrbitSection
from hcss_payload.shutter import LEAST_SMEAR_PX, Shutter, exposure_of, instants_for, largest_smear_px
from hcss_payload.trajectory import Circular
from hcss_payload.zonal_disk import ZonalDisk
from hcss_twin import Scenario
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.rays import Rays
from hcss_twin.providers import Array, Catalog, Grid, Problem, ScenarioError, View

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

ONE_AIR = "camera: each pixel has its own view, but the air of [place]"

OUTSIDE = 0.02
"""Farthest position beyond the edge of the rectangle of a pass at -1 or 1."""

_LINE_STEPS = 4
"""Steps to the line that sees an element; each reduces the error by the ratio of image motion to the speed of lines."""

_SMEARLESS = "views, and the clouds before small elements, are those of its middle"

LIMB_NOTE = (
    "camera: limb, and ground beyond view zenith 85 deg, are clear air of the profile of [place] along refracted lines "
    "of sight above a black sea; their clouds and scattered sunlight are left out"
)


def make_rays(scenario: Scenario, catalog: Catalog) -> CameraRays:
    """Return the rays of a scenario with ``[camera]`` and ``[orbit]``.

    Raises
    ------
    ScenarioError
        If a section is invalid, contradicts other keys, or the camera looks beyond what is computed.
    """
    return CameraRays(scenario, payload_of(scenario, catalog), catalog)


class CameraRays(Rays):
    """Rays of a camera in orbit.

    Parameters
    ----------
    margin_px : float
        Around the detector, within which radiance is known, too: for poses other than those of the payload.

    Attributes
    ----------
    gives_coordinates : bool
        Whether frames get the coordinates of their pixels.
    """

    directions: PassDirections
    gives_coordinates = True
    beyond_directions = (
        f"attitude: a pixel looks beyond the directions of {TIMES} times of the pass, which are examined; allowed: "
        "attitudes that turn smoothly between the first and the last frame, or a shorter sequence"
    )
    """Message about a pixel whose direction has no radiance."""

    def __init__(self, scenario: Scenario, payload: Payload, catalog: Catalog, margin_px: float = 0.0) -> None:
        self._payload, self._scenario = payload, scenario
        self._largest_deg = LARGEST_WITH_LIMB_DEG if payload.beyond == "limb" else LARGEST_ZENITH_DEG
        self.camera = payload.camera
        self._place_deg = self._centre = scenario.place.latitude, scenario.place.longitude
        frames = scenario.frames
        first, last = (float(number * frames.interval) for number in (frames.first, frames.first + frames.count - 1))
        self._times_s = (frames.first + np.arange(frames.count, dtype=np.float64)) * frames.interval
        self._last: tuple[Hashable, FrameGeometry] | None = None
        self._limb: Limb | None = None
        self._derived = frozenset[str]()
        self._points: dict[float, CameraPoints] = {}
        self._points_key: Hashable = None
        self.may_miss_ground = payload.beyond != "refuse"
        # The same times for every list of frames between the same ends: tables depend on them.
        times = np.unique(np.linspace(first, last, TIMES if last > first else 1))
        with _named():
            doubts = examine(payload.trajectory, first, last)
        with self._telling_next_pass(first):
            self._shutter = self._shutter_over(times)
        jitter = payload.jitter
        margin = margin_px + (0.0 if jitter is None else jitter.largest_rad / self.camera.pixel_rad)
        with self._telling_next_pass(first):
            seen = sample_pass(self.camera, self._geometry, self._require_ground, times, margin, self._largest_deg)
        self.directions, footprints = directions_around(seen.toward, seen.limit_deg), seen.footprint_m
        self.climate = climate_of(scenario, catalog, payload.climate)
        disk = whole_disk(scenario, catalog, payload.trajectory, self.directions, seen, times, self.climate is not None)
        if disk is not None:
            self.directions, self._centre, self._last = disk, disk.centre, None
        else:
            apart_m = max(self.camera.rows, self.camera.columns) / (FIELD - 1) * float(np.max(footprints))
            positions_m = np.array([payload.trajectory.at(time) for time in times.tolist()])
            places = seen.place_deg
            if payload.beyond == "limb":  # whose scene is the disk below the camera
                places = np.concatenate((places, np.stack(geographic(positions_m)[:2], axis=-1)))
            with _named():
                doubts += examine_place(self._centre, places, apart_m, positions_m)
        middle, _ = self._geometry(float(times[times.size // 2])).nodes()
        self.view = view_of(middle[len(middle) // 2]) if len(middle) else view_of(seen.toward[len(seen.toward) // 2])
        self._extent = (*_range(seen.place_deg[:, 0]), *_range(seen.place_deg[:, 1]))
        self.image = Grid(self.camera.rows, self.camera.columns, float(np.median(footprints)))
        point_m = scenario.image.pixel_size / scenario.image.samples_per_pixel
        points_wanted = min(max(FEWEST_POINTS, int(np.ceil(np.max(footprints) / point_m - 0.5))), MOST_POINTS)
        self.integration_s, self.instants = self._shutter.integration_s, self._shutter.instants
        instants = self.instants
        self.samples_per_pixel = -(-(payload.points or points_wanted) // instants) * instants
        self.filled_in = (*self.filled_in, *assumed(scenario, payload))
        self.notes = (
            *pass_notes(scenario, payload, first),
            *NOTES,
            *self.notes,
            *doubts,
            *((ONE_AIR,) if disk is None else disk_notes(self.climate is not None)),
            *((LIMB_NOTE,) if payload.beyond == "limb" else ()),
            *(() if instants == 1 else (f"camera: {instants} instants within the integration time; {_SMEARLESS}",)),
            f"camera: {self.samples_per_pixel} x {self.samples_per_pixel} points per pixel; its footprint is "
            f"{np.min(footprints):.4g} to {np.max(footprints):.4g} m, points of the scene are {point_m:.4g} m apart",
        )

    @contextmanager
    def _telling_next_pass(self, first_s: float) -> Iterator[None]:
        """Add to errors of a view past the Earth when the next pass above ``[place]`` is, unless it is now."""
        try:
            yield
        except ScenarioError as error:
            low = direction_deg(self._payload.trajectory, self._place_deg, first_s)[0] < LOWEST_DEG
            if not low or not any(problem.field in ("attitude", "camera.beyond") for problem in error.problems):
                raise
            start = self._scenario.time.astimezone(UTC)
            told = next_pass(self._payload.trajectory, self._place_deg, start, first_s)
            orbit = self._scenario.sections.get("orbit")
            if (
                isinstance(self._payload.trajectory, Circular)
                and isinstance(orbit, OrbitSection)
                and orbit.epoch is None
            ):
                told += f"; [orbit] counts from its epoch, by default `time`: keep it with epoch = {start.isoformat()}"
            raise ScenarioError(
                [Problem(problem.field, f"{problem.message}; {told}") for problem in error.problems], error.origin
            ) from error

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
        key = self.frame_key(time_s)
        if self._last is None or self._last[0] != key:
            with _named():
                pose = self._payload.pose(time_s)
            lines = self._shutter.lines(time_s, self.camera, self._payload.pose)
            self._last = key, FrameGeometry(self.camera, pose, self._centre, lines, self._largest_deg)
        return self._last[1]

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
        self.filled_in = (("camera.integration_time", f"{payload.integration_s:g} s", why),)
        return Shutter(payload.integration_s, payload.line_s, instants)

    def variables(self, requested: tuple[VariableSpec, ...]) -> tuple[VariableSpec, ...]:
        """Return the requested variables, missing where nothing is computed, and the coordinates of pixels."""
        limb = (TANGENT_HEIGHT,) if self._payload.beyond == "limb" else ()
        return (*super().variables(requested), *PIXEL_VARIABLES, *limb)

    def prepare(self, scenario: Scenario, assembly: Assembly, radiance: bool) -> None:
        """Raise a :class:`ScenarioError` that names what a camera cannot show yet."""
        super().prepare(scenario, assembly, radiance)
        self._derived = frozenset(name for provider in assembly.derived for name in provider.variables)
        scene, slant = assembly.plane(scenario.image.samples_per_pixel), assembly.slant
        below_clouds = (0.0,) if slant.shadows and slant.sun_zenith_deg.size else ()
        for time_s in (self._times_s[0], self._times_s[self._times_s.size // 2], self._times_s[-1]):
            for met_m, generator in zip(assembly.met_heights_m, assembly.generators, strict=True):
                for height_m in (*met_m, *below_clouds):
                    below = scene.around(*scene.in_points(*self._points_at(float(time_s), height_m).at_nodes()))
                    if below is not None:
                        scene.require_in_reach(generator, below, float(time_s))
        self._limb = Limb(assembly) if self._payload.beyond == "limb" and radiance else None

    def coordinates(self) -> tuple[tuple[VariableSpec, NDArray[Any]], ...]:
        """Return rows, columns and poses."""
        poses = [self._payload.pose(float(time_s)) for time_s in self._times_s]
        return coordinates(self.camera.rows, self.camera.columns, poses)

    def extent_deg(self, scenario: Scenario) -> tuple[float, float, float, float]:
        """Return the extent of the ground that the frames show."""
        return self._extent

    def still(self) -> CameraRays:
        """Return the rays of the middle of the integration time."""
        other = copy(self)
        other._shutter, other._points, other.instants = replace(self._shutter, instants=1), {}, 1
        return other

    def points_m(self, window: Window, time_s: float, height_m: float) -> tuple[Array, Array]:
        """Return where the rays of a window meet a height."""
        return self._points_at(time_s, height_m).window(window)

    def _points_at(self, time_s: float, height_m: float) -> CameraPoints:
        if self._points_key != (key := self.frame_key(time_s)):
            self._points_key, self._points = key, {}
        if height_m not in self._points:
            exposure = exposure_of(self._shutter, time_s, self.camera, self._payload.pose)
            self._points[height_m] = CameraPoints(
                self.camera, exposure, self._place_deg, height_m, self.samples_per_pixel
            )
        return self._points[height_m]

    def positions(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return the positions of pixels in the rectangle of the pass; raises :class:`PayloadError` outside it."""
        rays = self._geometry(time_s).window(*window)
        ground = rays.kind == GROUND
        seen = (np.where(ground[..., None], vector, 1.0) for vector in (rays.toward, rays.position_m))
        x, y = (np.where(ground, coordinate, np.nan) for coordinate in self.directions.places(*seen))
        if np.any(np.abs(x) > 1.0 + OUTSIDE) or np.any(np.abs(y) > 1.0 + OUTSIDE):
            raise PayloadError(self.beyond_directions)
        return x, y

    def bounds(self, time_s: float) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Return what a frame sees of the rectangle of the pass.

        None with the limb: between the outermost rays of the mesh that meet the ground and the limb other pixels do.
        """
        geometry = self._geometry(time_s)
        toward, position_m = geometry.nodes()
        if not toward.size or geometry.sees_limb:
            return None
        x, y = (_range(coordinate) for coordinate in self.directions.places(toward, position_m))
        return x, y

    def views_of_pixels(self, rows: Sequence[int], columns: Sequence[int], time_s: float) -> list[View]:
        """Return the exact view of pixels."""
        row, column = (np.asarray(numbers, dtype=np.float64) for numbers in (rows, columns))
        rays = self._geometry(time_s).exact(row, column)
        if isinstance(self.directions, Disk | ZonalDisk):
            return self.directions.views_of(rays.position_m)
        return [view_of(toward) for toward in rays.toward]

    def unseen(self, window: Window, time_s: float) -> NDArray[np.bool_] | None:
        """Return which pixels of a window do not show the ground that is computed."""
        kind = self._geometry(time_s).window(*window).kind
        self._require_ground(kind, time_s)
        beyond: NDArray[np.bool_] = kind != GROUND
        return beyond if beyond.any() else None

    def locations_deg(self, window: Window, time_s: float, scenario: Scenario) -> tuple[Array, Array]:
        """Return where the centres of pixels see the ground; the scene's place where they do not."""
        geometry = self._geometry(time_s)
        seen = geometry.latitude_longitude(geometry.window(*window))
        latitude, longitude = (
            np.where(np.isnan(angle), of_place, angle) for angle, of_place in zip(seen, self._place_deg, strict=True)
        )
        return latitude, longitude

    def angles_deg(self, window: Window, time_s: float) -> tuple[Array, Array]:
        """Return zenith and azimuth of the camera there; those of the typical view where pixels see no ground."""
        geometry = self._geometry(time_s)
        seen = geometry.angles_deg(geometry.window(*window))
        typical = self.view.zenith_deg, self.view.azimuth_deg
        zenith, azimuth = (
            np.where(np.isnan(angle), of_view, angle) for angle, of_view in zip(seen, typical, strict=True)
        )
        return zenith, azimuth

    def project(
        self, x_m: Array, y_m: Array, altitude_m: Array, time_s: float, later_s: float = 0.0
    ) -> tuple[Array, Array]:
        """Return where points appear through the pose of a time."""
        geometry = self._geometry(time_s)
        pose, lines = geometry.pose, geometry.mesh.lines
        if later_s:
            pose = self._payload.pose(time_s + later_s)
            lines = self._shutter.lines(time_s + later_s, self.camera, self._payload.pose)
        position, up = self._position_m(x_m, y_m, altitude_m)
        away = position - pose.position_m
        row, column = self.camera.pixels(pose.to_body(away))
        for _ in range(_LINE_STEPS):  # the row decides over the pose, and this over the row
            if lines is None:
                break
            turn, origin = lines.at(row)
            away = position - origin
            row, column = self.camera.pixels(np.einsum("...ji,...j->...i", turn, away))
        hidden = np.sum(away * up, axis=-1) >= 0.0  # below the horizon
        nowhere = hidden | np.isnan(row)
        return np.where(nowhere, self.NOWHERE, row + 0.5), np.where(nowhere, self.NOWHERE, column + 0.5)

    def pixel_area_m2(
        self, row: float, column: float, time_s: float, point_m: tuple[float, float, float] | None = None
    ) -> float:
        """Return the area of a pixel across its line of sight, at the distance of a point or else of the ground."""
        geometry, at = self._geometry(time_s), (np.float64(row - 0.5), np.float64(column - 0.5))
        ray = self.camera.directions(*at)  # type: ignore[arg-type]
        axis = self.camera.directions(*(np.float64(coordinate) for coordinate in self.camera.centre))  # type: ignore[arg-type]
        if point_m is None:
            seen = geometry.exact(*at).position_m  # type: ignore[arg-type]
        else:
            seen = self._position_m(*(np.array(coordinate) for coordinate in point_m))[0]
        distance = float(np.linalg.norm(geometry.pose.position_m - seen))
        # A detector sees the solid angle pitch^2 cos^3 / focal length^2.
        return distance**2 * self.camera.pixel_rad**2 * float(ray @ axis) ** 3

    def _position_m(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return Earth-fixed positions and vertical directions (..., 3) of points."""
        latitude, longitude, _ = Ellipsoid.to_geographic_with_turn(x_m, y_m, *self._place_deg)
        up = Ellipsoid.east_north_up(latitude, longitude)[2]
        return Ellipsoid.to_earth_centred(latitude, longitude) + np.asarray(altitude_m)[..., None] * up, up

    def complete(self, frame: dict[str, NDArray[Any]], time_s: float, extent: Window) -> None:
        """Add the coordinates of the pixels; set space to 0 and what is not computed to missing."""
        shows_limb, coordinates = self._payload.beyond == "limb", self.gives_coordinates
        complete(frame, self._geometry(time_s), extent, shows_limb, self._limb, self._derived, coordinates)


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
