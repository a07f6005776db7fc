"""Frames of a scenario as a camera sees them from its poses.

The scenario's cloud generator and radiance tables are used as they are. Each point of the image meets the cloud layer
at the height of its flat side, as in :mod:`hcss_twin.plan.slant_paths`, and gets the thickness that the scene has there
in the scene's own plane; so clouds move against the sea with the direction of view. Where the points lie between those
of the scene's generator, their thickness is interpolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_payload.attitude import Attitude
from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.jitter import Jitter
from hcss_payload.mesh import Mesh
from hcss_payload.pose import Pose, pose_at
from hcss_payload.rays import geographic, meet
from hcss_payload.trajectory import Trajectory
from hcss_twin import Scenario, make_plan
from hcss_twin.core.arrays import Array
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import FrameClouds
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import TableReader
from hcss_twin.physics.geodesy import east_north_up, to_geographic_with_turn, to_plane
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import reference_height_m
from hcss_twin.plan.windows import points_of
from hcss_twin.providers import View

LARGEST_ZENITH_DEG = 75.0
"""Beyond, refraction matters and ground pixels are many times longer than wide."""

_STRAIGHT_DEG = 1e-6

LARGEST_POINTS = 2**26
"""Points of the scene below one frame."""

VIEW_STEP_DEG = 2.0
"""Largest angle between the directions of view of two tables, between which radiance is interpolated in time."""


@dataclass(frozen=True, eq=False)
class Frame:
    """What the camera sees at one pose, before its optics and detector.

    Attributes
    ----------
    pose : Pose
        With the time.
    radiance : ndarray of float32 (B, rows, columns)
        Band radiance, W m-2 sr-1, as in the scenario's cube; the mean over the points of a pixel.
    latitude_deg, longitude_deg : ndarray (rows, columns)
        Of the sea that pixels look at.
    view : View
        Toward the camera from the place on the optical axis, for which the radiance is computed. The azimuth counts
        from the y axis of the scene's plane.
    """

    pose: Pose
    radiance: NDArray[np.float32]
    latitude_deg: Array
    longitude_deg: Array
    view: View


def frames(
    scenario: Scenario,
    camera: Camera,
    trajectory: Trajectory,
    attitude: Attitude,
    times_s: Sequence[float],
    jitter: Jitter | None = None,
    points: int | None = None,
) -> Iterator[Frame]:
    """Yield what a camera sees of a scenario at given times.

    Parameters
    ----------
    scenario : Scenario
        With at most one cloud layer, and a platform that does not move.
    times_s : sequence of float
        Seconds after the scenario's start, within its frames, ascending.
    points : int, optional
        Points along each side of a pixel; by default ``image.samples_per_pixel`` of the scenario.

    Raises
    ------
    PayloadError
        If the scenario has what frames from a pose cannot show, or the camera looks beyond the scene.
    """
    times_s = [float(time_s) for time_s in times_s]
    plan = make_plan(scenario)
    _require_supported(plan)
    per_pixel = plan.samples_per_pixel if points is None else points
    require_within("points", per_pixel, 1, 16)
    first, last = float(plan.frame_times_s[0]), float(plan.frame_times_s[-1])
    for time_s in times_s:
        if not first <= time_s <= last:
            raise PayloadError(f"times_s: {time_s:g} s; allowed: {first:g} to {last:g} s, the frames of the scenario")
    if not times_s or np.any(np.diff(times_s) < 0.0):
        raise PayloadError(f"times_s: {len(times_s)} times; allowed: one or more, none earlier than the one before")
    # The nominal view, without jitter, decides over tables: it is smooth in time.
    views = [_view(plan, camera, pose_at(time_s, trajectory, attitude)) for time_s in times_s]
    tables = _tables_over(plan, views)
    for number, time_s in enumerate(times_s):
        pose = pose_at(time_s, trajectory, attitude, jitter)
        sea = Mesh(camera, pose).positions_m()
        if np.isnan(sea).any():
            raise PayloadError(f"camera: looks beyond the limb at time {time_s:g} s; allowed: the sea in every pixel")
        latitude, longitude, _ = geographic(sea)
        thickness = [_thickness(plan, camera, pose, per_pixel)] if plan.layers else []
        radiance = sum(
            weight * _looked_up(plan, reader, time_s, thickness, camera, per_pixel) for reader, weight in tables[number]
        )
        yield Frame(pose, np.asarray(radiance, np.float32), latitude, longitude, views[number])


def _require_supported(plan: Plan) -> None:
    """Refuse by name what frames from a pose cannot show yet."""
    scenario = plan.scenario
    unsupported = {
        "clouds: more than one layer": len(plan.layers) > 1,
        "clouds: tops of their own": plan.tops is not None,
        "sea.waves: resolved waves": plan.waves is not None,
        "surfaces": plan.surfaces is not None,
        "sea.temperature_texture or atmosphere.water_vapour_texture": plan.texture is not None,
        "elements": bool(plan.assembly.elements),
        "slant.shadows": scenario.slant.shadows,
        "slant.parallax: the camera has its own": scenario.slant.parallax,
        "motion.platform_speed: the trajectory moves the camera": scenario.motion.platform_speed != 0.0,
    }
    found = [name for name, present in unsupported.items() if present]
    if found:
        raise PayloadError(f"scenario: {'; '.join(found)}; allowed: scenarios without, for frames from a pose")


def _view(plan: Plan, camera: Camera, pose: Pose) -> View:
    """Return the direction toward the camera from the sea on its optical axis."""
    at_row, at_column = (np.float64(each) for each in camera.centre)
    met = meet(pose.position_m, pose.to_earth(camera.directions(at_row, at_column)))  # type: ignore[arg-type]
    if np.isnan(met).any():
        raise PayloadError(f"attitude: the optical axis misses the Earth at time {pose.time_s:g} s; allowed: the sea")
    latitude, longitude, _ = geographic(met)
    x, y = _in_plane(plan, met[None], pose)[0]
    place = plan.scenario.place
    _, _, turn = to_geographic_with_turn(x, y, place.latitude, place.longitude)
    ray = pose.position_m - met
    east, north, up = (float(axis @ ray) for axis in east_north_up(latitude, longitude))
    zenith = float(np.degrees(np.arctan2(np.hypot(east, north), up)))
    require_within(f"attitude: view zenith at time {pose.time_s:g} s", zenith, 0.0, LARGEST_ZENITH_DEG, "deg")
    if zenith < _STRAIGHT_DEG:  # where rounding decides over the azimuth, and tables are not found in the cache again
        return View(0.0, 0.0)
    return View(zenith, float((np.degrees(np.arctan2(east, north)) - turn) % 360.0))


def _tables_over(plan: Plan, views: Sequence[View]) -> list[list[tuple[TableReader, float]]]:
    """Return for each frame the tables of one or two views with their weights, by time between few views."""
    toward = np.array([_vector(view) for view in views])
    nodes = [0]
    for number in range(1, len(views)):
        if toward[number] @ toward[nodes[-1]] < np.cos(np.radians(VIEW_STEP_DEG)) and number - 1 > nodes[-1]:
            nodes.append(number - 1)
    # Views that hardly differ share a table.
    if len(views) > 1 and toward[-1] @ toward[nodes[-1]] < np.cos(np.radians(0.01 * VIEW_STEP_DEG)):
        nodes.append(len(views) - 1)
    readers = [TableReader(tables_of(plan.toward(views[node]))) for node in nodes]
    result = []
    for number in range(len(views)):
        before = int(np.searchsorted(nodes, number, side="right")) - 1
        if before == len(nodes) - 1:
            result.append([(readers[before], 1.0)])
            continue
        # The weight by the angle: frames need not be equally spaced in time.
        start, end = toward[nodes[before]], toward[nodes[before + 1]]
        weight = float((toward[number] - start) @ (end - start) / ((end - start) @ (end - start)))
        result.append([(readers[before], 1.0 - weight), (readers[before + 1], weight)])
    return result


def _vector(view: View) -> Array:
    zenith, azimuth = np.radians(view.zenith_deg), np.radians(view.azimuth_deg)
    return np.array([np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)])


def _in_plane(plan: Plan, position_m: Array, pose: Pose) -> Array:
    """Return x and y (N, 2) in the plane of the scene of positions (N, 3)."""
    latitude, longitude, _ = geographic(position_m)
    place = plan.scenario.place
    try:
        return np.stack(to_plane(latitude, longitude, place.latitude, place.longitude), axis=-1)
    except ValueError as error:
        raise PayloadError(f"attitude: at time {pose.time_s:g} s, {error}") from error


def _thickness(plan: Plan, camera: Camera, pose: Pose, points: int) -> NDArray[np.float32]:
    """Return the thickness of the cloud layer at all points (y, x) of the image."""
    mesh = Mesh(camera, pose, reference_height_m(plan.layers[0]), points)
    place_m = mesh.values(lambda position: _in_plane(plan, position, pose))
    if np.isnan(place_m).any():
        raise PayloadError(f"camera: looks beyond the limb at time {pose.time_s:g} s; allowed: the sea in every pixel")
    per, grid = plan.samples_per_pixel, plan.grid
    point_m = grid.pixel_size_m / per
    # Rows and columns of the scene's points, whose centres are whole numbers.
    column = place_m[..., 0] / point_m + 0.5 * (grid.columns * per - 1)
    row = place_m[..., 1] / point_m + 0.5 * (grid.rows * per - 1)
    window = _around(row, per, grid.rows), _around(column, per, grid.columns)
    _require_in_reach(plan, window, pose)
    (field,) = FrameClouds(plan, pose.time_s).thickness_m(window)
    first_row, first_column = (points_of(pixels, per).start for pixels in window)
    return interpolated_thickness(field, row - first_row, column - first_column)


def _around(place: Array, per_pixel: int, size: int) -> slice:
    """Return the pixels of the scene that hold places; those that end on its border stay inside."""
    low, high = int(np.floor(place.min())), int(np.floor(place.max())) + 2
    # Half a point beyond the outermost centres is still inside the image.
    if place.min() >= -0.5:
        low = max(low, 0)
    if place.max() <= size * per_pixel - 0.5:
        high = min(high, size * per_pixel)
    return slice(low // per_pixel, -(-high // per_pixel))


def _require_in_reach(plan: Plan, window: tuple[slice, slice], pose: Pose) -> None:
    rows, columns = window
    inside = (
        rows.start >= 0 and columns.start >= 0 and rows.stop <= plan.grid.rows and columns.stop <= plan.grid.columns
    )
    count = (rows.stop - rows.start) * (columns.stop - columns.start) * plan.samples_per_pixel**2
    if count > LARGEST_POINTS:
        raise PayloadError(
            f"camera: sees {count:.3g} points of the scene at time {pose.time_s:g} s; allowed: up to "
            f"{LARGEST_POINTS:.3g}, with larger image.pixel_size or a smaller field"
        )
    if not inside and not all(hasattr(each, "thickness_around_m") for each in plan.assembly.generators):
        raise PayloadError(
            f"camera: sees rows {rows.start} to {rows.stop} and columns {columns.start} to {columns.stop} of the scene "
            f"at time {pose.time_s:g} s; allowed: its {plan.grid.rows} x {plan.grid.columns} pixels, since this cloud "
            "generator ends there"
        )


def interpolated_thickness(field: NDArray[np.float32], row: Array, column: Array) -> NDArray[np.float32]:
    """Return thickness (...) at places (...) between points (Y, X) of a field.

    A place is cloudy if the bilinear weights of its cloudy neighbours are at least half; then its thickness is their
    mean, so that none is thinner than the thinnest cloud.
    """
    up, left = (
        np.clip(np.floor(place).astype(np.int64), 0, max(0, size - 2))
        for place, size in zip((row, column), field.shape, strict=True)
    )
    down, right = np.minimum(up + 1, field.shape[0] - 1), np.minimum(left + 1, field.shape[1] - 1)
    y, x = np.clip(row - up, 0.0, 1.0), np.clip(column - left, 0.0, 1.0)
    cloudy, total = np.zeros(row.shape), np.zeros(row.shape)
    corners = ((up, left, (1 - y) * (1 - x)), (up, right, (1 - y) * x), (down, left, y * (1 - x)), (down, right, y * x))
    for i, j, weight in corners:
        values = field[i, j]
        cloudy += weight * (values > 0.0)
        total += weight * values
    return np.where(cloudy >= 0.5, total / np.maximum(cloudy, 0.5), 0.0).astype(np.float32)


def _looked_up(
    plan: Plan, reader: TableReader, time_s: float, thickness: list[NDArray[np.float32]], camera: Camera, points: int
) -> NDArray[np.float32]:
    """Return band radiance (B, rows, columns) toward the view of one table."""
    table = reader.at(time_s)
    radiance = np.empty((table.clear.size, camera.rows, camera.columns), dtype=np.float32)
    LookUp(table).fill(radiance, thickness, points)
    return radiance[: len(plan.bands)]  # the total is the first quantity
