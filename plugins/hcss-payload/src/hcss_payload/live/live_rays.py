"""Rays of a camera whose poses are known only when they are needed."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields

from hcss_payload.build import Payload
from hcss_payload.camera_rays import CameraRays
from hcss_payload.pose import Pose
from hcss_twin import Scenario
from hcss_twin.providers import Catalog


@dataclass(frozen=True, eq=False)
class SteeredPayload(Payload):
    """A payload that follows its pass from a pose of its own.

    Attributes
    ----------
    given : list of Pose
        At most one: the pose of a frame. At other times, of integration or of lines, the camera has moved and turned
        from it as it does in the pass.
    """

    given: list[Pose] = None  # type: ignore[assignment]  # dataclasses need a default after others

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time."""
        if not self.given:
            return super().pose(time_s)
        (given,) = self.given
        if time_s == given.time_s:
            return given
        before, now = super().pose(given.time_s), super().pose(time_s)
        position_m = given.position_m + (now.position_m - before.position_m)
        turned = now.rotation * (before.rotation.inv() * given.rotation)
        return Pose(time_s, position_m, turned.as_quat())


class LiveRays(CameraRays):
    """Rays of a camera near its pass, through one pose after another.

    Parameters
    ----------
    payload : Payload
        The nominal pass.
    margin_px : float
        Pixels by which frames may look beside the images of the pass.
    """

    gives_coordinates = False

    def __init__(self, scenario: Scenario, payload: Payload, catalog: Catalog, margin_px: float) -> None:
        of_pass = {field.name: getattr(payload, field.name) for field in fields(Payload)}
        self._steered, self._number = SteeredPayload(**of_pass, given=[]), 0
        super().__init__(scenario, self._steered, catalog, margin_px)
        self.beyond_directions = (
            f"pose: a pixel looks farther than {margin_px:g} pixels beside what the prepared pass sees; allowed: poses "
            "near those of the pass, or a larger margin_px"
        )

    def steer(self, pose: Pose | None) -> None:
        """See the next frames through a pose; None: through those of the pass."""
        self._steered.given[:] = [] if pose is None else [pose]
        self._number += 1

    def frame_key(self, time_s: float) -> Hashable:
        """Return what tells the rays of a frame from those of others: its time, and how often they were steered."""
        return time_s, self._number
