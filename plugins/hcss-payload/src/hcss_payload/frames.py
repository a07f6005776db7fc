"""Frames of a scenario as a camera sees them from its poses, at any times, for trajectories and attitudes in code.

A scenario with the sections of a camera gives the same frames (:meth:`hcss_twin.Twin.frames`) at the times of its
frames; here camera, trajectory and attitude are objects, and times any within the scenario's frames.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.attitude import Attitude
from hcss_payload.build import Payload
from hcss_payload.camera import Camera
from hcss_payload.camera_rays import CameraRays
from hcss_payload.checks import PayloadError, require_within
from hcss_payload.jitter import Jitter
from hcss_payload.pose import Pose, pose_at
from hcss_payload.trajectory import Trajectory
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker


@dataclass(frozen=True, eq=False)
class Frame:
    """What a camera sees at one pose; the first row is the upper one of the detector.

    Attributes
    ----------
    pose : Pose
        With the time.
    radiance : ndarray of float32 (B, rows, columns)
        Band radiance, W m-2 sr-1, mean over the pixel's footprint; of live frames as measured, if the scenario has a
        sensor.
    digital_number : ndarray of int32 (B, rows, columns) or None
        Of live frames with a sensor that has a converter.
    variables : mapping of str to ndarray
        Of :func:`frames` the variables of the cube, with the coordinates of pixels (``pixel_latitude``, ...).
    """

    pose: Pose
    radiance: NDArray[np.float32]
    digital_number: NDArray[np.int32] | None = None
    variables: Mapping[str, NDArray[Any]] = field(default_factory=dict)


def frames(
    scenario: Scenario,
    camera: Camera,
    trajectory: Trajectory,
    attitude: Attitude,
    times_s: Sequence[float],
    jitter: Jitter | None = None,
    points: int | None = None,
    beyond: str = "refuse",
    integration_s: float = 0.0,
    line_s: float = 0.0,
) -> Iterator[Frame]:
    """Yield what a camera sees of a scenario at given times; a time has the same bits in every list of times.

    Parameters
    ----------
    scenario : Scenario
        Without the sections of a camera.
    times_s : sequence of float
        Seconds after the scenario's start, within its frames.
    points : int, optional
        Points along each side of a pixel; by default as for cubes.
    beyond : {"refuse", "missing"}
        As ``camera.beyond``.
    integration_s, line_s : float
        As ``camera.integration_time`` and ``camera.line_time``.

    Raises
    ------
    ScenarioError
        If the scenario has what a camera cannot show, or the camera looks beyond what is computed.
    """
    require_within("points", 1 if points is None else points, 1, 16)
    payload = Payload(camera, trajectory, attitude, jitter, points, beyond, integration_s, line_s)
    plan = make_plan(scenario, rays=lambda planned, catalog: CameraRays(planned, payload, catalog))
    first, last = float(plan.frame_times_s[0]), float(plan.frame_times_s[-1])
    for time_s in times_s:
        if not first <= time_s <= last:
            raise PayloadError(f"times_s: {time_s:g} s; allowed: {first:g} to {last:g} s, the frames of the scenario")
    maker = PartMaker(plan, tables_of(plan) if plan.needs_radiance else None)
    for time_s in map(float, times_s):
        number = int(np.searchsorted(plan.frame_times_s, time_s, side="right")) - 1
        variables, _ = maker.part(number, plan.extent, time_s=time_s)
        yield Frame(pose_at(time_s, trajectory, attitude, jitter), variables["radiance"], variables=variables)
