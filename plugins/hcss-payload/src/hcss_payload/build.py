"""Camera, trajectory, attitude and jitter from the sections of a scenario."""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np

from hcss_payload.attitude import Attitude, AttitudeTable, Nadir, PushBroom, Track
from hcss_payload.camera import Camera
from hcss_payload.ccsds import read_aem, read_oem
from hcss_payload.checks import PayloadError
from hcss_payload.earth_rotation import EarthOrientation
from hcss_payload.jitter import Jitter, JitterLine
from hcss_payload.mean_elements import read_elements
from hcss_payload.pose import Pose, pose_at
from hcss_payload.sections import AttitudeSection, CameraSection, JitterSection, OrbitSection
from hcss_payload.sun_synchronous import sun_synchronous, sun_synchronous_above
from hcss_payload.trajectory import Circular, Geostationary, PositionTable, Trajectory
from hcss_payload.two_lines import TwoLineElements
from hcss_twin import Scenario
from hcss_twin.plan.sensor_stages import Stage
from hcss_twin.providers import Catalog, HcssError, Problem, ScenarioError, choose_from

ORBITS, ATTITUDES = "hcss_payload.orbits", "hcss_payload.attitudes"
"""Entry point groups of other packages: functions ``(parameters, scenario, catalog)`` that return a trajectory, and
``(parameters, trajectory, scenario, catalog)`` that return an attitude."""

ROUNDED = 0.05
"""Relative difference of times that are stated with two digits."""

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Payload:
    """A camera, and where it is and looks at any time.

    Attributes
    ----------
    points : int or None
        Points along each side of a pixel; None: chosen by its footprint.
    beyond : str
        As ``camera.beyond``.
    integration_s, line_s : float
        As ``camera.integration_time`` and ``camera.line_time``.
    climate : str
        As ``camera.climate``.
    integration_from : str or None
        Key of the sensor whose value the integration time is; None: it is stated.
    """

    camera: Camera
    trajectory: Trajectory
    attitude: Attitude
    jitter: Jitter | None = None
    points: int | None = None
    beyond: str = "refuse"
    integration_s: float = 0.0
    line_s: float = 0.0
    climate: str = "place"
    integration_from: str | None = None

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        return pose_at(time_s, self.trajectory, self.attitude, self.jitter)


def payload_of(scenario: Scenario, catalog: Catalog) -> Payload:
    """Build the payload of a scenario.

    Raises
    ------
    ScenarioError
        If a section is missing or invalid; names the field.
    """
    sections = scenario.sections
    for name in ("camera", "orbit"):
        if name not in sections:
            raise ScenarioError([Problem(name, "is missing; a camera in orbit needs [camera] and [orbit]")])
    camera = sections["camera"]
    attitude, jitter = sections.get("attitude", AttitudeSection.model_validate({})), sections.get("jitter")
    assert isinstance(camera, CameraSection)
    assert isinstance(attitude, AttitudeSection)
    _require_time(camera, scenario)
    optics = _named("camera", lambda: _camera(camera))
    trajectory = trajectory_of(scenario, catalog)
    toward = _named("attitude", lambda: _attitude(attitude, trajectory, scenario, catalog), attitude.file)
    shaken = None
    if jitter is not None:
        assert isinstance(jitter, JitterSection)
        shaken = _named("jitter", lambda: _jitter(jitter, scenario.seed))
    followed = None if scenario.sensor is None else Stage.smear_of_sensor(scenario.sensor, catalog)
    given_s = camera.integration_time
    integration_s, integration_from = followed if followed is not None and given_s is None else (given_s, None)
    return Payload(
        optics,
        trajectory,
        toward,
        shaken,
        camera.points,
        camera.beyond,
        integration_s or 0.0,
        camera.line_time,
        camera.climate,
        integration_from,
    )


SECTIONS = "camera", "orbit", "attitude", "jitter"
"""Names of the sections of this package."""


def scene_of(scenario: Scenario) -> Scenario:
    """Return a scenario without the sections of this package: sky and sea on the grid on the ground."""
    data = json.loads(scenario.to_json())
    of_scene = {name: value for name, value in data.items() if name not in SECTIONS}
    return Scenario.from_dict(of_scene, base=scenario.base, origin=scenario.origin)


def _named(section: str, make: Callable[[], _T], file: str | None = None) -> _T:
    """Call a function; its errors name the key, or the section or its file."""
    try:
        return make()
    except ScenarioError:
        raise
    except HcssError as error:
        field, _, message = str(error).partition(": ")
        known = field.startswith((f"{section}.", "trajectory.")) and file is None
        name = f"{section}.{field.partition('.')[2]}" if known else section if file is None else f"{section}.file"
        text = str(error).removeprefix("trajectory.").removeprefix(f"{name}: ")
        raise ScenarioError([Problem(name, message if known else text)]) from error


def _require_time(camera: CameraSection, scenario: Scenario) -> None:
    """Raise a :class:`ScenarioError` if a frame takes longer than the time to the next one."""
    interval_s = scenario.frames.interval
    taken = {"integration_time": camera.integration_time or 0.0, "line_time": abs(camera.line_time) * (camera.rows - 1)}
    for name, time_s in taken.items():
        if scenario.frames.count > 1 and time_s > interval_s * (1.0 + ROUNDED):
            given = f"{getattr(camera, name):g} s: a frame takes {time_s:g} s, and frames.interval is {interval_s:g} s"
            message = f"{given}; allowed: up to the interval"
            raise ScenarioError([Problem(f"camera.{name}", message)])


def _camera(section: CameraSection) -> Camera:
    return Camera(
        section.rows,
        section.columns,
        section.focal_length,
        section.detector_pitch,
        section.principal_point,
        section.radial,
        section.tangential,
        section.mounting,
    )


def _trajectory(section: OrbitSection, scenario: Scenario, catalog: Catalog) -> Trajectory:
    start = scenario.time.astimezone(UTC)
    earth = EarthOrientation(section.dut1 or 0.0, section.pole or (0.0, 0.0))
    match section.provider:
        case "circular":
            epoch = (section.epoch or start).astimezone(UTC)
            return _circular(section).later((start - epoch).total_seconds())
        case "sun-synchronous":
            epoch = (section.epoch or start).astimezone(UTC)
            return _sun_synchronous(section, epoch).later((start - epoch).total_seconds())
        case "geostationary":
            return Geostationary(float(section.longitude or 0.0))
        case "tle" | "omm":
            if section.lines:
                return TwoLineElements(section.lines[-2], section.lines[-1], start, earth)
            return read_elements(catalog.file(str(section.file)), start, earth)
        case "oem":
            return read_oem(catalog.file(str(section.file)), start, earth)
        case "table":
            table = _table(catalog, "orbit.file", str(section.file), ("time_s", "x_m", "y_m", "z_m"))
            return PositionTable(table[:, 0], table[:, 1:])
    made: Trajectory = _of_package(ORBITS, "orbit", section.provider)(section.parameters or {}, scenario, catalog)
    return made


def _circular(section: OrbitSection) -> Circular:
    altitude, inclination = float(section.altitude or 0.0), float(section.inclination or 0.0)
    if section.above is None:
        return Circular(altitude, inclination, section.node_longitude or 0.0, section.argument or 0.0)
    rising = section.direction != "descending"
    return Circular.above(altitude, inclination, *section.above, section.above_time or 0.0, rising)


def _sun_synchronous(section: OrbitSection, epoch: datetime) -> Circular:
    altitude, rising = float(section.altitude or 0.0), section.direction != "descending"
    node = None if section.local_time is None else (section.local_time, section.node != "descending")
    if section.above is not None:
        return sun_synchronous_above(altitude, epoch, section.above, section.above_time or 0.0, rising, node)
    assert node is not None  # the section requires it
    return sun_synchronous(altitude, epoch, node[0], section.argument or 0.0, node[1])


def trajectory_of(scenario: Scenario, catalog: Catalog) -> Trajectory:
    """Build the trajectory of a scenario; raises :class:`ScenarioError` that names the field."""
    orbit = scenario.sections.get("orbit")
    if orbit is None:
        raise ScenarioError([Problem("orbit", "is missing; allowed: [orbit] with a provider")])
    assert isinstance(orbit, OrbitSection)
    return _named("orbit", lambda: _trajectory(orbit, scenario, catalog), orbit.file)


def _attitude(section: AttitudeSection, trajectory: Trajectory, scenario: Scenario, catalog: Catalog) -> Attitude:
    match section.provider:
        case "nadir":
            return Nadir(trajectory)
        case "track":
            place = scenario.place
            latitude = place.latitude if section.latitude is None else section.latitude
            longitude = place.longitude if section.longitude is None else section.longitude
            return Track(trajectory, latitude, longitude, section.altitude or 0.0)
        case "push-broom":
            return PushBroom(trajectory, section.roll or 0.0, section.pitch or 0.0)
        case "aem":
            return read_aem(catalog.file(str(section.file)), scenario.time.astimezone(UTC))
        case "table":
            table = _table(catalog, "attitude.file", str(section.file), ("time_s", "x", "y", "z", "w"))
            return AttitudeTable(table[:, 0], table[:, 1:])
    maker = _of_package(ATTITUDES, "attitude", section.provider)
    made: Attitude = maker(section.parameters or {}, trajectory, scenario, catalog)
    return made


def _jitter(section: JitterSection, seed: int) -> Jitter:
    lines = tuple(
        JitterLine(line.frequency, _radians(line.amplitude), float(np.radians(line.phase))) for line in section.lines
    )
    jitter_seed = seed if section.seed is None else section.seed
    return Jitter(_radians(section.rms), section.lowest, section.highest, section.exponent, lines, jitter_seed)


def _radians(degrees: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = np.radians(degrees).tolist()
    return x, y, z


def _table(catalog: Catalog, field: str, name: str, columns: tuple[str, ...]) -> Any:
    table = catalog.columns(catalog.file(name))
    missing = [column for column in columns if column not in table]
    if missing:
        raise PayloadError(f"{field}: {name} lacks the columns {', '.join(missing)}; allowed: {', '.join(columns)}")
    return np.stack([table[column] for column in columns], axis=1)


def _of_package(group: str, section: str, name: str) -> Callable[..., Any]:
    """Return the function of another package; raises :class:`PayloadError`."""
    shipped: tuple[str, ...] = ("circular", "sun-synchronous", "geostationary", "tle", "omm", "oem", "table")
    shipped = shipped if section == "orbit" else ("nadir", "track", "push-broom", "aem", "table")
    known = {entry.name: entry for entry in importlib.metadata.entry_points(group=group)}
    if name not in known:
        raise PayloadError(
            f"{section}.provider: no provider is called '{name}'; {choose_from(name, (*shipped, *known))}"
        )
    try:
        function: Callable[..., Any] = known[name].load()
    except (Exception, SystemExit) as error:  # whatever the import of a package raises
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise PayloadError(f"{section}.provider: '{name}' cannot be imported: {why}") from error
    return function
