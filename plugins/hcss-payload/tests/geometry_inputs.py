"""Scenarios that state one quantity of camera, orbit or sensor twice: 100 that agree, and 100 with a contradiction.

What keys imply is computed here from triangles on the sphere of 6371 km and Kepler's third law. Every scenario is
determined by its number.
"""

import copy
import math
from dataclasses import dataclass

import numpy as np

RADIUS_M, MU = 6_371_008.8, 3.986004418e14

SCENE = {
    "seed": 3,
    "time": "2024-04-20T14:30:00Z",
    "bands": ["mwir"],
    "place": {"latitude": 30.0, "longitude": 150.0},
    "image": {"rows": 8, "columns": 8, "pixel_size": 100.0},
    "frames": {"count": 2, "interval": 10.0},
    "motion": {"wind_speed": 0.0},
    "output": {"certificate": 0},
    "radiance": {"model": "as-printed"},
    "sea": {"model": "cox-munk", "wind_speed": 10.0, "temperature": 295.0},
}
PHOTONS = {
    "noise": "photon", "aperture_diameter": 0.1, "pixel_angle": 4e-5, "integration_time": 1e-3, "smear": False,
    "well_depth": 1e8, "bits": 14,
}  # fmt: skip
CAMERA = {
    "camera": {"rows": 8, "columns": 8, "focal_length": 0.5, "detector_pitch": 2e-5, "points": 1},
    "orbit": {"altitude": 7e5, "inclination": 98.2, "above": [30.0, 150.0], "above_time": 5.0},
    "attitude": {"provider": "track"},
    "image": {"rows": 64, "columns": 64, "pixel_size": 28.0},
}


@dataclass(frozen=True)
class Geometry:
    """A scenario; ``names`` are the keys of which an answer must name every one, if it is bad."""

    name: str
    scenario: dict
    names: tuple = ()


def merged(*parts):
    raw = {}
    for part in parts:
        for key, value in copy.deepcopy(part).items():
            known = raw.get(key)
            both = isinstance(value, dict) and isinstance(known, dict)
            raw[key] = merged(known, value) if both else value
    return raw


def range_m(zenith_deg, altitude_m):
    """Law of cosines in the triangle of the Earth's centre, the place and the sensor."""
    cosine, outer = math.cos(math.radians(zenith_deg)), RADIUS_M + altitude_m
    return math.sqrt(outer**2 - (RADIUS_M * math.sin(math.radians(zenith_deg))) ** 2) - RADIUS_M * cosine


def zenith_deg(off_nadir_deg, altitude_m):
    return math.degrees(math.asin((1.0 + altitude_m / RADIUS_M) * math.sin(math.radians(off_nadir_deg))))


def ground_speed(altitude_m):
    return math.sqrt(MU / (RADIUS_M + altitude_m)) * RADIUS_M / (RADIUS_M + altitude_m)


def rounded(value, digits):
    return float(f"{value:.{digits}g}")


def sensor(**changes):
    return {"sensor": {"parameters": PHOTONS | changes}}


def _pairs(factor, rng):
    """Scenarios by kind: with factor 1 both keys agree, otherwise one is off by it."""
    altitude = float(rng.choice([4e5, 5e5, 7.05e5, 8.2e5, 2e6]))
    size = float(rng.choice([20.0, 40.0, 100.0, 375.0, 1000.0]))
    zenith = float(rng.choice([0.0, 15.0, 40.0, 60.0]))
    digits = int(rng.choice([2, 3, 6])) if factor == 1.0 else 6
    image = {"rows": 8, "columns": 8, "pixel_size": size}
    platform = {"altitude": altitude}
    angle = size / range_m(zenith, altitude)
    look = 20.0
    from_look = size / range_m(zenith_deg(look, altitude), altitude)
    optics = {"focal_length": 0.5, "detector_pitch": 2e-5}
    pixel_rad = 2e-5 / 0.5
    speed = ground_speed(altitude)
    moving = {"platform": {**platform, "mode": "push-broom"}, "image": image}
    dwell = size / speed
    yield (
        "pixel size, altitude, zenith, pixel angle",
        [
            {"image": image, "platform": platform, "view": {"zenith": zenith}},
            sensor(pixel_angle=rounded(factor * angle, digits)),
        ],
        ("sensor.parameters.pixel_angle", "image.pixel_size", "platform.altitude"),
    )
    yield (
        "pixel size, altitude, off-nadir, pixel angle",
        [
            {"image": image, "platform": {**platform, "off_nadir": look}},
            sensor(pixel_angle=rounded(factor * from_look, digits)),
        ],
        ("sensor.parameters.pixel_angle", "image.pixel_size", "platform.altitude"),
    )
    yield (
        "focal length and pitch of the platform, pixel angle",
        [{"image": {"pixel_size": None}, "platform": {**platform, **optics}}, sensor(pixel_angle=factor * pixel_rad)],
        ("sensor.parameters.pixel_angle", "platform.detector_pitch", "platform.focal_length"),
    )
    yield (
        "focal length and pitch of the camera, pixel angle",
        [CAMERA, sensor(pixel_angle=rounded(factor * pixel_rad, digits))],
        ("sensor.parameters.pixel_angle", "camera.detector_pitch", "camera.focal_length"),
    )
    yield (
        "integration time of camera and sensor",
        [CAMERA, {"camera": {"integration_time": 1e-3}}, sensor(integration_time=factor * 1e-3)],
        ("sensor.parameters.integration_time", "camera.integration_time"),
    )
    yield (
        "named sensor",
        [
            {
                "image": {"rows": 8, "columns": 8, "pixel_size": 20.0 * factor},
                "platform": {"altitude": 5e5},
                "sensor": {"name": "generic-mwir"},
            }
        ],
        ("sensor.parameters.pixel_angle", "image.pixel_size", "platform.altitude"),
    )
    yield (
        "named sensor and override",
        [
            {
                "image": image,
                "platform": platform,
                "sensor": {"name": "generic-mwir", "parameters": {"pixel_angle": factor * size / altitude}},
            }
        ],
        ("sensor.parameters.pixel_angle", "image.pixel_size", "platform.altitude"),
    )
    chain = [
        {"parameters": {"psf": "airy", "aperture_diameter": 0.1, "pixel_angle": 4e-5}},
        {"parameters": PHOTONS | {"pixel_angle": 4e-5 * factor}},
    ]
    yield (
        "stages of one sensor",
        [{"sensor": {"stages": chain}}],
        ("sensor.stages[1].parameters.pixel_angle", "sensor.stages[0].parameters.pixel_angle"),
    )
    times = [
        {"model": "integration", "parameters": {"integration_time": 1e-3}},
        {"parameters": PHOTONS | {"integration_time": 1e-3 * factor}},
    ]
    yield (
        "integration times of stages",
        [{"sensor": {"stages": times}}],
        ("sensor.stages[1].parameters.integration_time", "sensor.stages[0].parameters.integration_time"),
    )
    yield (
        "geostationary altitude",
        [
            {
                "place": {"latitude": 10.0, "longitude": 140.0},
                "platform": {
                    "longitude": 140.7,
                    "altitude": 35_786e3 * (1.0 if factor == 1.0 else min(factor, 1.15 if factor > 1.0 else factor)),
                },
            }
        ],
        ("platform.longitude", "platform.altitude"),
    )
    yield (
        "off-nadir angle and zenith",
        [
            {
                "platform": {**platform, "off_nadir": look},
                "view": {"zenith": rounded(zenith_deg(look, altitude), 5) if factor == 1.0 else 10.0},
            }
        ],
        ("platform.off_nadir", "view.zenith"),
    )
    yield (
        "focal length, pitch and pixel size",
        [
            {
                "image": {"rows": 8, "columns": 8, "pixel_size": rounded(factor * altitude * pixel_rad, digits)},
                "platform": {**platform, **optics},
            }
        ],
        ("platform.detector_pitch", "image.pixel_size"),
    )
    yield (
        "line time and ground speed",
        [
            moving,
            {
                "sensor": {
                    "stages": [
                        {
                            "model": "integration",
                            "parameters": {"integration_time": 1e-4, "stages": 8, "line_time": dwell * factor},
                        }
                    ]
                }
            },
        ],
        ("line_time", "pixel_size|platform_speed"),
    )
    yield (
        "integration time and frame interval",
        [
            {"frames": {"count": 3, "interval": 0.5}},
            sensor(integration_time=0.5 * (0.99 if factor == 1.0 else max(factor, 1.0 / factor))),
        ],
        ("sensor.parameters.integration_time", "frames.interval"),
    )
    yield (
        "lines of a camera and frame interval",
        [
            CAMERA,
            {
                "frames": {"count": 3, "interval": 1.0},
                "camera": {"line_time": 0.1 if factor == 1.0 else 0.13 * max(factor, 1.0 / factor)},
            },
        ],
        ("camera.line_time", "frames.interval"),
    )
    yield (
        "mode and speed",
        [
            {
                "platform": {**platform, "mode": "push-broom"},
                "motion": {
                    "platform_speed": rounded(speed, 4) * (1.0 if factor == 1.0 else 1e-3 if factor < 1.0 else 3.0)
                },
            }
        ],
        ("motion.platform_speed", "platform.altitude"),
    )
    yield (
        "aperture and focal length",
        [
            CAMERA,
            {"camera": {"focal_length": 0.5}},
            sensor(pixel_angle=pixel_rad, aperture_diameter=0.1 if factor == 1.0 else 2.0 * max(factor, 1.0 / factor)),
        ],
        ("sensor.parameters.aperture_diameter", "camera.focal_length"),
    )


def _scenarios(factors, seed):
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < 100:
        factor = float(rng.choice(factors))
        for kind, parts, names in _pairs(factor, rng):
            raw = merged(SCENE, *parts)
            if raw["image"].get("pixel_size", 0) is None:
                raw["image"] = {"rows": 8, "columns": 8}
            found.append(Geometry(f"{len(found)} {kind}, factor {factor:g}", raw, names))
    return found[:100]


def good():
    """Return 100 scenarios whose keys agree, numbers rounded to 2 to 6 digits."""
    return _scenarios([1.0], 1)


def bad():
    """Return 100 scenarios with a key that is off by a factor."""
    return _scenarios([0.25, 0.5, 0.8, 1.25, 2.0, 4.0, 1000.0, 1e-3], 2)
