"""Scenarios with a camera, with the models of the paper, which compile quickly."""

import copy

import hcss_twin

CHEAP = {"radiance": {"model": "as-printed"}, "sea": {"model": "cox-munk", "wind_speed": 10.0, "temperature": 295.0}}

LWIR, MWIR = {"name": "lwir", "limits": [10.5, 11.0]}, {"name": "mwir", "limits": [3.6, 3.8]}
"""Narrow bands under the names of wide ones: the time of a scene grows with its wavenumbers."""

GEOSTATIONARY_M = 35_786_034.0

SCENE = {
    "seed": 3,
    "time": "2024-04-20T14:30:00Z",
    "bands": [LWIR],
    "place": {"latitude": 0.0, "longitude": 140.7},
    "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
    "frames": {"count": 2, "interval": 10.0},
    "clouds": {"type": "paper-stratus", "coverage": 0.5, "coverage_mode": "field"},
    "optics": {"provider": "mie"},
    "output": {"certificate": 8},
    **CHEAP,
}

STARING = {
    "camera": {"rows": 64, "columns": 64, "focal_length": 1.0, "detector_pitch": 100.0 / GEOSTATIONARY_M, "points": 1},
    "orbit": {"provider": "geostationary", "longitude": 140.7},
}

PASS = {
    "place": {"latitude": 30.0, "longitude": 150.0},
    "camera": {"rows": 40, "columns": 48, "focal_length": 0.15, "detector_pitch": 1.5e-5},
    "orbit": {"altitude": 7e5, "inclination": 98.2, "above": [30.0, 153.0], "above_time": 60.0},
    "attitude": {"provider": "track"},
    "frames": {"count": 3, "interval": 60.0},
}


def merged(*parts):
    """A scenario from parts; later ones replace keys of earlier ones."""
    raw = {}
    for part in parts:
        for key, value in copy.deepcopy(part).items():
            known = raw.get(key)
            raw[key] = known | value if isinstance(value, dict) and isinstance(known, dict) else value
    return raw


def scenario(*parts):
    """The scene with parts."""
    return hcss_twin.Scenario.from_dict(merged(SCENE, *parts))
