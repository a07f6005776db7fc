"""Live frames of a scenario with the sections ``[camera]``, ``[orbit]``, ``[attitude]`` and ``[jitter]``."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_payload.build import payload_of, scene_of
from hcss_payload.live.target import PointTarget
from hcss_payload.live.twin import FINENESS, LiveTwin, PreparedPass
from hcss_twin import Scenario
from hcss_twin.providers import Catalog


def live_pass(
    scenario: Scenario,
    start_s: float = 0.0,
    end_s: float | None = None,
    threads: int = 2,
    fineness: float = FINENESS,
    target: PointTarget | Sequence[PointTarget] | None = None,
    highest_target_m: float | None = None,
) -> PreparedPass:
    """Prepare live frames along the pass of a scenario.

    Parameters
    ----------
    start_s, end_s : float, optional
        First and last time of poses, s; by default 0 and the time of the scenario's last frame.
    threads : int
    fineness : float
        Points of the sky per width of a pixel.
    target : PointTarget or sequence of them, optional
    highest_target_m : float, optional
        Altitude up to which frames may have targets that are decided on at run time.

    Raises
    ------
    ScenarioError
        If ``[camera]`` or ``[orbit]`` is missing, or a section is invalid.
    PayloadError
        If live frames cannot show the scene; names the key.
    """
    payload = payload_of(scenario, Catalog(base=scenario.base))
    twin = LiveTwin(scene_of(scenario), payload.camera, threads, fineness)
    last = float(twin.plan.frame_times_s[-1]) if end_s is None else end_s
    return twin.prepare(
        payload.trajectory,
        payload.attitude,
        start_s,
        last,
        payload.jitter,
        target,
        highest_target_m,
        payload.integration_s or None,
    )
