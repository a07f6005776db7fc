"""View, pixel size and motion derived from the platform, and checks for contradictions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from hcss_twin.core.errors import Problem
from hcss_twin.physics.viewing import (
    GEOSTATIONARY_M,
    ground_speed_m_s,
    off_nadir_deg,
    slant_range_m,
    toward_equatorial_deg,
    view_zenith_deg,
)
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.section_types import AGREEMENT, ORBIT, Platform

_Model = TypeVar("_Model", bound=ScenarioModel)

LARGEST_ZENITH_DEG = 85.0
"""Upper limit of ``view.zenith``."""

AGREEMENT_DEG = 0.1
"""Difference of angles that state the same."""

FULL_SPEED_M_S = 465.0
"""Speed of the equator with the rotation of the Earth, which the speed of a circular orbit neglects."""

SMALLEST_PIXEL_M, LARGEST_PIXEL_M = 1e-3, 100_000.0
"""Limits of ``image.pixel_size``."""


def viewing_problems(scenario: ScenarioModel) -> Iterator[Problem]:
    """Yield every contradiction between the platform and the keys for view, pixels and motion."""
    platform, altitude = scenario.platform, scenario.platform.altitude
    if altitude is None:
        given = [name for name in Platform.model_fields if getattr(platform, name) is not None]
        if given:
            yield Problem("platform.altitude", f"is required with {', '.join(given)}; allowed: 100 km to 42000 km")
        elif scenario.motion.platform_speed == ORBIT:
            yield Problem("motion.platform_speed", f"'{ORBIT}' without platform.altitude; allowed: with it, or a speed")
        return
    yield from _look_angle(scenario, altitude) if platform.longitude is None else _geostationary(scenario)
    yield from _pixels(scenario, altitude)
    yield from _motion(scenario)


def with_viewing(scenario: _Model) -> _Model:
    """Return a valid scenario with the keys derived from its platform filled in.

    ``view`` from ``platform.off_nadir`` or ``longitude``, ``image.pixel_size`` from focal length and pitch,
    ``motion.platform_speed`` from ``"orbit"`` or the mode.
    """
    platform, altitude = scenario.platform, scenario.platform.altitude
    if altitude is None:
        return scenario
    view, image, motion = scenario.view, scenario.image, scenario.motion
    if platform.off_nadir is not None or platform.longitude is not None:
        view = view.model_copy(update=_direction(platform, view.model_dump(), scenario.place.model_dump()))
    if platform.focal_length is not None and platform.detector_pitch is not None:
        distance = slant_range_m(view.zenith, altitude)
        image = image.model_copy(update={"pixel_size": _pixel_m(platform, distance)})
    moves = platform.mode == "push-broom" and "platform_speed" not in motion.model_fields_set
    if moves or motion.platform_speed == ORBIT:
        motion = motion.model_copy(update={"platform_speed": ground_speed_m_s(altitude)})
    return scenario.model_copy(update={"view": view, "image": image, "motion": motion})


def as_given(scenario: ScenarioModel, data: dict[str, Any]) -> dict[str, Any]:
    """Remove the values that :func:`with_viewing` added to a dumped scenario, so that it can be read again."""
    platform = scenario.platform
    if platform.longitude is not None:
        del data["view"]
    else:
        del data["platform"]["longitude"]
    if platform.off_nadir is not None:
        del data["view"]["zenith"]
    if platform.detector_pitch is not None:
        del data["image"]["pixel_size"]
    if platform.altitude is not None and data["motion"]["platform_speed"] == ground_speed_m_s(platform.altitude):
        data["motion"]["platform_speed"] = ORBIT
    return data


def pixel_size_and_speed(data: Mapping[str, Any]) -> tuple[float, float]:
    """Return the pixel size, m, and ground speed of the footprint, m/s, of a scenario given as text.

    Raises
    ------
    KeyError, TypeError, ValueError
        If the text is not a scenario.
    """
    image, speed = data["image"], data["motion"]["platform_speed"]
    platform = Platform.model_validate(data.get("platform", {}))
    if platform.altitude is None or platform.detector_pitch is None:
        size = float(image["pixel_size"])
    else:
        zenith = _direction(platform, data.get("view", {}), data["place"])["zenith"]
        size = _pixel_m(platform, slant_range_m(zenith, platform.altitude))
    if platform.altitude is not None and speed == ORBIT:
        speed = ground_speed_m_s(platform.altitude)
    return size, float(speed)


def pixel_angles_rad(data: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
    """Yield what keys of a scenario given as text say about the angle of a pixel: keys, least and largest angle.

    A square pixel on the ground has the width of the footprint across the line of sight, or its solid angle, or a width
    between.

    Raises
    ------
    KeyError, TypeError, ValueError
        If the text is not a scenario.
    """
    for name, section in data.items():
        optics = section if isinstance(section, Mapping) and name != "sensor" else {}
        focal, pitch = optics.get("focal_length"), optics.get("detector_pitch")
        if focal and pitch:
            yield (
                f"{name}.detector_pitch {pitch:g} m with {name}.focal_length {focal:g} m",
                pitch / focal,
                pitch / focal,
            )
    platform = Platform.model_validate(data.get("platform", {}))
    if platform.altitude is None or platform.detector_pitch is not None:
        return
    size, _ = pixel_size_and_speed(data)
    zenith = _direction(platform, data.get("view", {"zenith": 0.0}), data["place"])["zenith"]
    angle, altitude_km = size / slant_range_m(zenith, platform.altitude), 1e-3 * platform.altitude
    keys = f"image.pixel_size {size:g} m with platform.altitude {altitude_km:g} km, seen at zenith {zenith:.3g} deg,"
    yield keys, angle * math.sqrt(math.cos(math.radians(zenith))), angle


def viewing_notes(scenario: ScenarioModel) -> tuple[str, ...]:
    """Return a note on a speed of the footprint that no circular orbit of the platform's altitude has."""
    altitude, speed = scenario.platform.altitude, scenario.motion.platform_speed
    if altitude is None or not isinstance(speed, float) or speed == 0.0:
        return ()
    orbit = ground_speed_m_s(altitude)
    if abs(abs(speed) - orbit) <= AGREEMENT * orbit + FULL_SPEED_M_S:
        return ()
    return (
        f"motion.platform_speed {speed:g} m/s is {abs(speed) / orbit:.3g} times that of a circular orbit at "
        f"platform.altitude {1e-3 * altitude:g} km, {orbit:.4g} m/s",
    )


def _direction(platform: Platform, view: Mapping[str, Any], place: Mapping[str, Any]) -> dict[str, float]:
    """Direction from the image centre toward the sensor, as the keys of ``view`` that the platform gives."""
    assert platform.altitude is not None
    if platform.longitude is not None:
        position_deg = float(place["latitude"]), float(place["longitude"])
        angles = toward_equatorial_deg(*position_deg, platform.longitude, platform.altitude)
        return dict(zip(("zenith", "azimuth"), angles, strict=True))
    look = platform.off_nadir
    return {"zenith": float(view["zenith"]) if look is None else view_zenith_deg(look, platform.altitude)}


def _geostationary(scenario: ScenarioModel) -> Iterator[Problem]:
    platform, place = scenario.platform, scenario.place
    seen = _direction(platform, {}, place.model_dump())
    # Near the zenith a small angle between two directions is a large one between their azimuths.
    within = {"zenith": AGREEMENT_DEG, "azimuth": AGREEMENT_DEG / max(math.sin(math.radians(seen["zenith"])), 1e-3)}
    given = [
        f"view.{name}"
        for name in scenario.view.model_fields_set
        if abs((getattr(scenario.view, name) - seen[name] + 180.0) % 360.0 - 180.0) > within[name]
    ]
    given += ["platform.off_nadir"] if platform.off_nadir is not None else []
    assert platform.altitude is not None
    if abs(platform.altitude - GEOSTATIONARY_M) > 0.01 * GEOSTATIONARY_M:
        yield Problem(
            "platform.longitude",
            f"with platform.altitude {1e-3 * platform.altitude:g} km, where no satellite stays above a place; allowed: "
            f"{1e-3 * GEOSTATIONARY_M:.0f} km within 1 %, or view.zenith and view.azimuth in its place",
        )
    if given:
        yield Problem(
            "platform.longitude",
            f"given with {', '.join(sorted(given))}, and means view zenith {seen['zenith']:.4g} deg, azimuth "
            f"{seen['azimuth']:.4g} deg; allowed: one of them, or both within {AGREEMENT_DEG:g} deg",
        )
    if platform.mode == "push-broom" or scenario.motion.platform_speed == ORBIT:
        yield Problem("platform.longitude", "with a platform that moves over the ground; allowed: mode = 'staring'")
    if (zenith := seen["zenith"]) > LARGEST_ZENITH_DEG:
        yield Problem(
            "platform.longitude",
            f"{platform.longitude:g} deg is seen at zenith {zenith:.2f} deg from {place.latitude:g}, "
            f"{place.longitude:g}; allowed: up to {LARGEST_ZENITH_DEG:g} deg; the highest is above {place.longitude:g}",
        )


def _look_angle(scenario: ScenarioModel, altitude: float) -> Iterator[Problem]:
    off_nadir = scenario.platform.off_nadir
    if off_nadir is None:
        return
    zenith = view_zenith_deg(off_nadir, altitude)
    if "zenith" in scenario.view.model_fields_set and not abs(zenith - scenario.view.zenith) <= AGREEMENT_DEG:
        yield Problem(
            "platform.off_nadir",
            f"{off_nadir:g} deg given with view.zenith {scenario.view.zenith:g} deg, and means zenith {zenith:.4g} "
            f"deg; allowed: one of them, or both within {AGREEMENT_DEG:g} deg",
        )
        return
    if zenith > LARGEST_ZENITH_DEG:
        most = off_nadir_deg(LARGEST_ZENITH_DEG, altitude)
        problem = "misses the Earth" if math.isinf(zenith) else f"meets the ground at zenith {zenith:.2f} deg"
        yield Problem(
            "platform.off_nadir",
            f"{off_nadir:g} deg from {altitude / 1e3:g} km {problem}; allowed: up to zenith {LARGEST_ZENITH_DEG:g} "
            f"deg; closest valid choice is {math.floor(most * 1e3) / 1e3:g}",
        )


def _pixels(scenario: ScenarioModel, altitude: float) -> Iterator[Problem]:
    platform = scenario.platform
    pair = {"focal_length": platform.focal_length, "detector_pitch": platform.detector_pitch}
    missing = [name for name, value in pair.items() if value is None]
    if len(missing) == 2:
        return
    if missing:
        (other,) = set(pair) - set(missing)
        yield Problem(f"platform.{missing[0]}", f"is required with {other}; allowed: both, or image.pixel_size alone")
        return
    zenith = _direction(platform, scenario.view.model_dump(), scenario.place.model_dump())["zenith"]
    if not zenith <= LARGEST_ZENITH_DEG:
        return  # reported at platform.off_nadir
    size, given = _pixel_m(platform, slant_range_m(zenith, altitude)), scenario.image.pixel_size
    if "pixel_size" in scenario.image.model_fields_set and not abs(given - size) <= AGREEMENT * size:
        yield Problem(
            "platform.detector_pitch",
            f"with image.pixel_size {given:g} m, and means {size:.4g} m with platform.focal_length and altitude; "
            f"allowed: one of them, or both within {100 * AGREEMENT:g} %",
        )
    if not SMALLEST_PIXEL_M <= size <= LARGEST_PIXEL_M:
        yield Problem(
            "platform.detector_pitch",
            f"pixels of {size:.3g} m follow from pitch, focal length and distance; allowed: {SMALLEST_PIXEL_M:g} to "
            f"{LARGEST_PIXEL_M:g} m",
        )


def _motion(scenario: ScenarioModel) -> Iterator[Problem]:
    mode, motion = scenario.platform.mode, scenario.motion
    if mode is None or "platform_speed" not in motion.model_fields_set:
        return
    speed = motion.platform_speed
    if mode == "staring" and speed != 0.0:
        yield Problem("platform.mode", f"'staring' with motion.platform_speed {Problem.shown(speed)}; allowed: speed 0")
    if mode == "push-broom" and speed == 0.0:
        yield Problem(
            "platform.mode",
            f"'push-broom' with motion.platform_speed 0; allowed: another speed, '{ORBIT}', or mode = 'staring'",
        )


def _pixel_m(platform: Platform, distance_m: float) -> float:
    """Pixel width across the line of sight."""
    assert platform.focal_length is not None
    assert platform.detector_pitch is not None
    return platform.detector_pitch / platform.focal_length * distance_m
