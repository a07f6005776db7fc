"""Quantities that a sensor and other keys of a scenario both state: angle of a pixel, times, aperture.

Redundant keys may agree, rounded as people write them; keys that contradict each other are refused, since radiance
would follow one of them and electrons the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.scenario.section_types import AGREEMENT
from hcss_twin.scenario.viewing import pixel_angles_rad, pixel_size_and_speed

FASTEST_F_NUMBER = 0.5
"""Least ratio of focal length to aperture in air: that of a sine of 1 (M. Born and E. Wolf, "Principles of Optics")."""

MOST_OFF = 2.0
"""Ratio of line time to the time in which the footprint moves by a pixel from which both contradict each other: below,
their difference smears as it does with detectors whose clock is off."""


def examine_geometry(data: Mapping[str, Any], stages: Sequence[Any], binned: float = 1.0) -> tuple[str, ...]:
    """Return what is doubtful about the geometry of a sensor.

    Parameters
    ----------
    data : mapping
        A scenario as JSON, with the sections of plugins; any of these may have ``focal_length`` and ``detector_pitch``,
        and ``integration_time``.
    binned : float
        Pixels of the scenario along the side of a measured one.

    Raises
    ------
    ScenarioError
        If keys contradict each other; names both, their values and what they imply.
    """
    problems = [
        problem
        for index, stage in enumerate(stages)
        for problem in (
            *_between_stages(stage, stages[:index]),
            *_pixel_angle(stage, data, binned),
            *_integration_time(stage, data),
            *_aperture(stage, data),
        )
    ]
    notes = []
    for stage in stages:
        wrong, doubtful = _line_time(stage, data)
        problems += wrong
        notes += doubtful
    if problems:
        raise ScenarioError(problems)
    return tuple(notes)


def _field(stage: Any, name: str) -> str:
    return f"{stage.field}.parameters.{name}"


def _stated(stage: Any, name: str) -> str:
    """Return the value of a parameter for messages, with the sensor file that it comes from."""
    named = stage.section.name is not None and name not in stage.section.parameters
    return f"{stage.parameters[name]:g}" + (f" (of '{stage.section.name}')" if named else "")


def _number(stage: Any, name: str) -> float | None:
    value = stage.parameters.get(name)
    return float(value) if isinstance(value, int | float) and value > 0 else None


def _contradicts(value: float, low: float, high: float) -> bool:
    return not low * (1.0 - AGREEMENT) <= value <= high * (1.0 + AGREEMENT)


def _between_stages(stage: Any, earlier: Sequence[Any]) -> Iterator[Problem]:
    for name in ("pixel_angle", "integration_time", "aperture_diameter"):
        value = _number(stage, name)
        for other in earlier:
            known = _number(other, name)
            if value is not None and known is not None and _contradicts(value, known, known):
                yield Problem(
                    _field(stage, name),
                    f"{_stated(stage, name)}, and {_field(other, name)} {_stated(other, name)}; allowed: one value for "
                    f"all stages of a sensor, within {100 * AGREEMENT:g} %",
                )


def _pixel_angle(stage: Any, data: Mapping[str, Any], binned: float) -> Iterator[Problem]:
    angle = _number(stage, "pixel_angle")
    if angle is None:
        return
    for keys, low, high in pixel_angles_rad(data):
        if _contradicts(angle, binned * low, binned * high):
            implied = f"{binned * low:.4g}" + (f" to {binned * high:.4g}" if high > low else "")
            closest = binned * (low if angle < binned * low else high)
            yield Problem(
                _field(stage, "pixel_angle"),
                f"{_stated(stage, 'pixel_angle')} rad, and {keys} make pixels of {implied} rad; allowed: keys that "
                f"agree within {100 * AGREEMENT:g} %; closest valid choice is {closest:.4g}",
            )


def _integration_time(stage: Any, data: Mapping[str, Any]) -> Iterator[Problem]:
    time_s = _number(stage, "integration_time")
    if time_s is None:
        return
    field = _field(stage, "integration_time")
    for section, keys in _sections(data):
        other = keys.get("integration_time")
        if other is None or (other == 0 and stage.smear_time_s is None):
            continue
        if _contradicts(time_s, float(other), float(other)):
            without = "" if other else f", or without {section}.integration_time, or smear = false"
            yield Problem(
                field,
                f"{_stated(stage, 'integration_time')} s, and {section}.integration_time {other:g} s; allowed: keys "
                f"that agree within {100 * AGREEMENT:g} %{without}",
            )
    frames = data.get("frames", {})
    interval = frames.get("interval") if frames.get("count", 1) > 1 else None
    if interval is not None and time_s > interval * (1.0 + AGREEMENT):
        yield Problem(
            field,
            f"{_stated(stage, 'integration_time')} s, and frames.interval {interval:g} s: one frame ends before the "
            f"next begins; allowed: up to the interval; closest valid choice is {interval:g}",
        )


def _aperture(stage: Any, data: Mapping[str, Any]) -> Iterator[Problem]:
    diameter = _number(stage, "aperture_diameter")
    for section, keys in _sections(data):
        focal = keys.get("focal_length")
        if diameter is not None and focal and focal < FASTEST_F_NUMBER * diameter:
            yield Problem(
                _field(stage, "aperture_diameter"),
                f"{_stated(stage, 'aperture_diameter')} m, and {section}.focal_length {focal:g} m make "
                f"f/{focal / diameter:.3g}; allowed: f/{FASTEST_F_NUMBER:g} and slower; closest valid choice is "
                f"{focal / FASTEST_F_NUMBER:g}",
            )


def _line_time(stage: Any, data: Mapping[str, Any]) -> tuple[list[Problem], list[str]]:
    """Compare the speed of the charges of several lines with that of the platform."""
    line_s, lines = _number(stage, "line_time"), stage.parameters.get("stages")
    if line_s is None or not isinstance(lines, int) or lines < 2:
        return [], []
    size, speed = pixel_size_and_speed(data)
    moved = abs(speed) * line_s / size
    text = (
        f"{_stated(stage, 'line_time')} s, in which the footprint moves by {moved:.3g} pixels (image.pixel_size "
        f"{size:g} m, motion.platform_speed {speed:g} m/s)"
    )
    if speed and not 1.0 / MOST_OFF < moved < MOST_OFF:
        closest = size / abs(speed)
        message = f"{text}; allowed: {closest / MOST_OFF:.4g} to {closest * MOST_OFF:.4g} s; closest is {closest:.4g}"
        return [Problem(_field(stage, "line_time"), message)], []
    if speed and abs(moved - 1.0) > AGREEMENT:
        return [], [
            f"{_field(stage, 'line_time')}: {text}; {lines} lines smear by {abs(moved - 1.0) * (lines - 1):.3g}"
        ]
    return [], []


def _sections(data: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the sections that describe an instrument, but for the sensor itself."""
    for name, section in data.items():
        if isinstance(section, Mapping) and name != "sensor":
            yield name, section
