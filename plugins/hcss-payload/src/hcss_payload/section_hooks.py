"""The hook of sections of scenarios, which is read only when a scenario has such a section."""

from __future__ import annotations

from collections.abc import Sequence

from hcss_twin.core.commands import hookimpl
from hcss_twin.core.sections import SectionSpec

_MODELS = "hcss_payload.sections"


@hookimpl
def hcss_sections() -> Sequence[SectionSpec]:
    """Return the specs of the sections of a camera in orbit."""
    imager = "hcss_payload.imager:make_imager"
    return [
        SectionSpec("camera", f"{_MODELS}:CameraSection", "Detector and lens of a camera; needs [orbit].", imager),
        SectionSpec("orbit", f"{_MODELS}:OrbitSection", "Trajectory of the camera.", imager),
        SectionSpec("attitude", f"{_MODELS}:AttitudeSection", "Orientation of the camera's body.", imager),
        SectionSpec("jitter", f"{_MODELS}:JitterSection", "Small turns of the body.", imager),
    ]
