"""The scene of tests of light: stratocumulus at night, seen from the side."""

from hcss_twin import Scenario

NIGHT, DAY = "2024-04-20T23:30:00+10:00", "2024-04-20T14:30:00+10:00"


def scene(light="source", certificate=0, model=None, **changes):
    """Return a scenario; tables of columns of the model "as-printed" take a tenth of the physical model's time."""
    values = {
        "time": NIGHT,
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": 50.0, "azimuth": 30.0},
        "image": {"rows": 40, "columns": 30, "pixel_size": 100.0},
        "frames": {"count": 1},
        "accuracy": 0.02,
        "bands": [[10.5, 11.0]],
        "clouds": {"type": "stratocumulus", "generator": "fractal", "coverage": 0.5},
        "output": {"variables": ["radiance"], "certificate": certificate},
        "radiance": {"light": light} | ({"model": model} if model else {}),
    }
    return Scenario.from_dict(values | changes)
