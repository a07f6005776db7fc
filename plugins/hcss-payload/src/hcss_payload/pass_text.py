"""What the plan says about a pass: the orbit and the age of its elements, the attitude, the jitter."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import UTC

import numpy as np

from hcss_payload.build import Payload
from hcss_payload.earth_rotation import EARTH_RATE_RAD_S
from hcss_payload.jitter import Jitter
from hcss_payload.rays import geographic
from hcss_payload.sections import AttitudeSection, OrbitSection
from hcss_payload.sun_synchronous import node_hours, shown_hours
from hcss_payload.trajectory import Circular
from hcss_payload.two_lines import Sgp4Orbit
from hcss_twin import Scenario

_LARGEST_DUT1_S, _LARGEST_POLE_ARCSEC = 0.9, 0.6
"""Bounds of UT1 - UTC and of either coordinate of the pole; G. Petit and B. Luzum, IERS Conventions (2010), and IERS
Bulletins A since 1973."""


def pass_notes(scenario: Scenario, payload: Payload, first_s: float) -> Iterator[str]:
    """Yield notes about orbit, attitude and jitter.

    Parameters
    ----------
    first_s : float
        Time of the first frame after the start.
    """
    yield f"orbit: {_orbit(scenario, payload, first_s)}"
    attitude = scenario.sections.get("attitude")
    yield f"attitude: {attitude.provider if isinstance(attitude, AttitudeSection) else 'nadir, by default'}"
    yield f"jitter: {_jitter(payload.jitter, payload.camera.pixel_rad)}"


def assumed(scenario: Scenario, payload: Payload) -> Iterator[tuple[str, str, str]]:
    """Yield the keys about the orientation of the Earth that mean elements need and the scenario omits."""
    orbit, trajectory = scenario.sections.get("orbit"), payload.trajectory
    if not isinstance(trajectory, Sgp4Orbit) or not isinstance(orbit, OrbitSection):
        return
    radius_m = float(np.linalg.norm(trajectory.at(0.0)))
    if orbit.dut1 is None:
        shift_m = _LARGEST_DUT1_S * EARTH_RATE_RAD_S * radius_m
        yield (
            "orbit.dut1",
            "0 s",
            f"UT1 - UTC is within {_LARGEST_DUT1_S:g} s: the orbit shifts by up to {shift_m:.0f} m",
        )
    if orbit.pole is None:
        shift_m = math.radians(_LARGEST_POLE_ARCSEC / 3600.0) * radius_m
        yield "orbit.pole", "0, 0 arc seconds", f"polar motion shifts the orbit by up to {shift_m:.0f} m"


def _orbit(scenario: Scenario, payload: Payload, first_s: float) -> str:
    trajectory, orbit = payload.trajectory, scenario.sections.get("orbit")
    latitude, longitude, height_m = (float(value) for value in geographic(trajectory.at(first_s)))
    above = f"{1e-3 * height_m:.1f} km above {latitude:.3f} N {longitude:.3f} E at the first frame"
    name = orbit.provider if isinstance(orbit, OrbitSection) else type(trajectory).__name__
    if isinstance(trajectory, Sgp4Orbit):
        days = (scenario.time.astimezone(UTC) - trajectory.epoch).total_seconds() / 86400.0
        age = f"{abs(days):.2f} days {'before' if days >= 0.0 else 'after'} the start"
        return f"{name}, {above}; its mean elements are of {trajectory.epoch.isoformat(timespec='minutes')}, {age}"
    if isinstance(trajectory, Circular):
        plane = f"inclination {trajectory.inclination_deg:.2f} deg"
        if trajectory.precesses:
            node = shown_hours(node_hours(trajectory, scenario.time.astimezone(UTC)))
            plane = f"{plane}, ascending node at {node} local mean solar time"
        return f"{name}, {above}; {plane}"
    return f"{name}, {above}"


def _jitter(jitter: Jitter | None, pixel_rad: float) -> str:
    if jitter is None:
        return "none; [jitter], or jitter of [instrument], adds it"
    micro = ", ".join(f"{1e6 * value:.3g}" for value in jitter.rms_rad)
    pixels = ", ".join(f"{value / pixel_rad:.2g}" for value in jitter.rms_rad[:2])
    lines = f"; {len(jitter.lines)} vibrations" if jitter.lines else ""
    return (
        f"rms {micro} urad around x, y, z ({pixels} pixels around x, y), from {jitter.lowest_hz:g} to "
        f"{jitter.highest_hz:g} Hz as f^-{jitter.exponent:g}{lines}"
    )
