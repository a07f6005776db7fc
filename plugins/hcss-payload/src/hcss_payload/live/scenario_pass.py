"""Live frames of a scenario with the sections ``[camera]``, ``[orbit]``, ``[attitude]`` and ``[jitter]``."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_payload.build import payload_of
from hcss_payload.live.prepared_pass import PreparedPass
from hcss_payload.live.target import PointTarget
from hcss_payload.live.twin import FINENESS, LiveTwin, Method
from hcss_twin import Scenario
from hcss_twin.providers import Catalog


def live_pass(
    scenario: Scenario,
    start_s: float | None = None,
    end_s: float | None = None,
    threads: int = 2,
    fineness: float = FINENESS,
    target: PointTarget | Sequence[PointTarget] | None = None,
    highest_target_m: float | None = None,
    method: Method = "auto",
    margin_px: float | None = None,
    follower: str | None = None,
    keyframe_s: float | None = None,
) -> PreparedPass:
    """Prepare live frames along the pass of a scenario.

    Parameters
    ----------
    start_s, end_s : float, optional
        First and last time of poses, s; by default those of the scenario's first and last frame.
    threads : int
    fineness : float
        Points of the sky of fast frames per width of a pixel.
    target : PointTarget or sequence of them, optional
    highest_target_m : float, optional
        Altitude up to which fast frames may have targets that are decided on at run time.
    method : {"auto", "fast", "cube", "keyframes"}
    margin_px, keyframe_s : float, optional
    follower : str, optional
        As in :class:`~hcss_payload.live.twin.LiveTwin`.

    Raises
    ------
    ScenarioError
        If ``[camera]`` or ``[orbit]`` is missing, a section is invalid, or no cube shows the scene through a camera.
    PayloadError
        If the pass cannot be seen; names the key.
    """
    payload = payload_of(scenario, Catalog(base=scenario.base))
    twin = LiveTwin(scenario, payload.camera, threads, fineness, method, margin_px, follower, keyframe_s)
    frames = scenario.frames
    first, last = (float(number * frames.interval) for number in (frames.first, frames.first + frames.count - 1))
    start_s, end_s = first if start_s is None else start_s, last if end_s is None else end_s
    return twin.prepare_payload(payload, start_s, end_s, target, highest_target_m)
