"""The hook of sections of scenarios, which is read only when a scenario has such a section."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.providers import SectionSpec, hookimpl

_MODELS = "hcss_payload.sections"


@hookimpl
def hcss_sections() -> Sequence[SectionSpec]:
    """Return the specs of the sections of a camera in orbit."""
    rays = "hcss_payload.camera_rays:make_rays"
    return [
        SectionSpec("camera", f"{_MODELS}:CameraSection", "Detector and lens of a camera; needs [orbit].", rays),
        SectionSpec("orbit", f"{_MODELS}:OrbitSection", "Trajectory of the camera.", rays),
        SectionSpec("attitude", f"{_MODELS}:AttitudeSection", "Orientation of the camera's body.", rays),
        SectionSpec("jitter", f"{_MODELS}:JitterSection", "Small turns of the body.", rays),
    ]
