"""Clouds of examples with a shape in height: brightness temperature of columns, of sides, and of relief; Monte Carlo.

    python plugins/hcss-skies/make/relief.py [--pixels 24]

Needs hcss-light. 8-14 um by night, light ``source``, 96 x 96 pixels of 100 m, 300 m and 1 km, at 0 and 45 deg. Then, at
100 m and 45 deg, bias and rms without noise of 10.5-11 um by night and 3.6-3.9 um by day in some pixels.
"""

from __future__ import annotations

import argparse
import warnings
from typing import Any

import numpy as np
from hcss_light.comparison import compare

from hcss_twin import Scenario, simulate

CASES = (
    ("stratocumulus", "closed-cells-1", 0),
    ("stratocumulus", "open-cells-1", 0),
    ("cumulus", "trade-cumulus-1", 1),
)


def scene(case: tuple[str, str, int], light: str, shape: str, view: float, pixel_m: float, **changes: Any) -> Scenario:
    """Return a scenario."""
    kind, example, seed = case
    values: dict[str, Any] = {
        "time": "2024-04-20T23:30:00+10:00",
        "seed": seed,
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": view},
        "image": {"rows": 96, "columns": 96, "pixel_size": pixel_m},
        "frames": {"count": 1},
        "accuracy": 0.01,
        "bands": [[8.0, 14.0]],
        "clouds": {"type": kind, "generator": "example", "parameters": {"example": example, "shape": shape}},
        "radiance": {"light": light},
        "output": {"variables": ["radiance", "brightness_temperature"], "certificate": 0},
    }
    return Scenario.from_dict(values | changes)


def main() -> None:
    """Print all figures."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--pixels", type=int, default=24)
    pixels = options.parse_args().pixels
    warnings.simplefilter("ignore")
    print("example, pixel (m), view (deg), shape: mean, standard deviation, and rms difference from columns, K")
    for case in CASES:
        for pixel_m in (100.0, 300.0, 1000.0):
            for view in (0.0, 45.0):
                plain = simulate(scene(case, "columns", "columns", view, pixel_m)).brightness_temperature.values[0, 0]
                print(f"{case[1]} {pixel_m:g} {view:g} columns: {plain.mean():.3f} {plain.std():.3f}")
                for shape in ("columns", "relief"):
                    own = simulate(scene(case, "source", shape, view, pixel_m)).brightness_temperature.values[0, 0]
                    rms = np.sqrt(np.mean((own - plain) ** 2))
                    print(f"{case[1]} {pixel_m:g} {view:g} {shape}, source: {own.mean():.3f} {own.std():.3f} {rms:.3f}")
    print("Monte Carlo, relative: bias and rms of source, of columns, and noise")
    day = {"time": "2024-04-20T14:30:00+10:00", "bands": [[3.6, 3.9]]}
    for case in CASES:
        for name, changes, photons in (("night", {"bands": [[10.5, 11.0]]}, 300), ("day", day, 600)):
            given = scene(case, "source", "relief", 45.0, 100.0, **changes)
            (band,) = compare(given, pixels, photons, 0, 1)["bands"]
            cube, columns = (band["errors"][each] for each in ("cube", "columns"))
            print(
                f"{case[1]}, {name}: {cube['bias']:+.4f} / {cube['rms']:.4f}, {columns['bias']:+.4f} / "
                f"{columns['rms']:.4f}, {band['noise']:.4f}"
            )


if __name__ == "__main__":
    main()
