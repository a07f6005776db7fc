"""Hooks: commands, and stages of sensors; imported to list what there is, so it must import quickly."""

from __future__ import annotations

from hcss_twin.providers import CommandSpec, ProviderSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands."""
    return [
        CommandSpec("passes", "hcss_payload.passes_command:passes", "List the passes of a camera above a place."),
        CommandSpec("serve", "hcss_payload.live.command:serve", "Serve live frames of a camera in shared memory."),
    ]


def _stage(name: str, module: str, kind: str, summary: str) -> ProviderSpec:
    target = f"hcss_payload.stages.{module}"
    return ProviderSpec(name, f"{target}:{kind}", f"{target}:Parameters", 3, summary)


@hookimpl
def hcss_register_sensors() -> list[ProviderSpec]:
    """Register the stages of detectors and their optics."""
    return [
        _stage("bad-pixels", "bad_pixels", "BadPixels", "dead, hot and blinking detectors"),
        _stage("detector-drift", "detector_drift", "DetectorDrift", "drift and 1/f noise of the detectors"),
        _stage("integration", "integration", "Integration", "smear by exposures within the integration time, and TDI"),
        _stage("non-linearity", "non_linearity", "NonLinearity", "a response that is not proportional to radiance"),
        _stage("stray-light", "stray_light", "StrayLight", "veiling glare, and a ghost turned about the axis"),
    ]
