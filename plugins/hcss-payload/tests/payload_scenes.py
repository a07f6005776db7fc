"""Cameras and orbits of the tests."""

from datetime import UTC, datetime

import numpy as np
from hcss_payload import Camera

START = datetime(2024, 4, 20, 2, 30, tzinfo=UTC)

# An orbit like that of Landsat 8.
LIKE_LANDSAT = (
    "1 39084U 13008A   24110.50000000  .00000500  00000-0  12000-3 0  9990",
    "2 39084  98.2000 180.0000 0001300  90.0000 270.0000 14.57100000595000",
)


def with_checksum(line):
    """Replace the last character by the checksum of the others."""
    return line[:68] + str(sum(int(c) if c.isdigit() else c == "-" for c in line[:68]) % 10)


LINES = tuple(with_checksum(line) for line in LIKE_LANDSAT)


def camera(size=64, field_deg=10.0, **changes):
    """A square camera with a field of view."""
    focal = 0.5 * size * 15e-6 / np.tan(np.radians(0.5 * field_deg))
    return Camera(**{"rows": size, "columns": size, "focal_length_m": focal, "pitch_m": 15e-6} | changes)


RADIOMETER = {
    "model": "radiometer",
    "parameters": {
        "psf": "gaussian",
        "psf_sigma": 0.5,
        "noise": "photon",
        "aperture_diameter": 0.1,
        "pixel_angle": 1e-4,
        "integration_time": 1e-3,
        "transmission": 0.7,
        "quantum_efficiency": 0.6,
        "read_noise": 100.0,
        "well_depth": 1e8,
        "bits": 14,
    },
}


def radiometer_of(camera):
    """That sensor behind a camera: another aperture, so that it counts the same electrons."""
    optics = {"pixel_angle": camera.pixel_rad, "aperture_diameter": 1e-5 / camera.pixel_rad}
    return RADIOMETER | {"parameters": RADIOMETER["parameters"] | optics}
