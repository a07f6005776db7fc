"""Pictures of the README and the page on clouds with sides: independent columns and sides, at 0, 45 and 60 deg.

    python plugins/hcss-light/benchmarks/figures.py [night day relief-night relief-day]

Needs matplotlib and pillow. Seen from north, 120 x 120 pixels: stratocumulus, 50 m; cumulus, 25 m, as columns, and
with sides of the generators fractal and fractal-relief.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from hcss_twin import Scenario, simulate

FOLDER = Path(__file__).parent.parent / "figures"
RELIEF = Path(__file__).parents[3] / "docs" / "images"
NIGHT, DAY = "2024-04-20T23:30:00+10:00", "2024-04-20T15:30:00+10:00"
STRATOCUMULUS = {"type": "stratocumulus", "coverage": 0.5, "edge_taper": 0.5}
CUMULUS = {"type": "cumulus", "coverage": 0.45, "coverage_mode": "field"}
FLAT = (("columns", STRATOCUMULUS), ("source", STRATOCUMULUS))
ROUND = (("columns", CUMULUS), ("source", CUMULUS), ("source", CUMULUS | {"generator": "fractal-relief"}))
CASES = {
    "night": (NIGHT, [10.3, 11.3], 50.0, FLAT),
    "day": (DAY, [3.6, 3.9], 50.0, FLAT),
    "relief-night": (NIGHT, [8.0, 14.0], 25.0, ROUND),
    "relief-day": (DAY, [3.0, 5.0], 25.0, ROUND),
}


def image(time: str, band: list[float], pixel_m: float, view: float, light: str, clouds: dict[str, Any]) -> np.ndarray:
    """Return brightness temperature (y, x)."""
    scene = Scenario.from_dict(
        {
            "time": time,
            "place": {"latitude": 20.0, "longitude": 150.0},
            "view": {"zenith": view},
            "image": {"rows": 120, "columns": 120, "pixel_size": pixel_m},
            "frames": {"count": 1},
            "accuracy": 0.01,
            "bands": [band],
            "clouds": clouds,
            "radiance": {"light": light},
            "output": {"variables": ["radiance", "brightness_temperature"], "certificate": 0},
        }
    )
    return simulate(scene).brightness_temperature.values[0, 0]


def main() -> None:
    """Draw the pictures that are named, or all."""
    warnings.simplefilter("ignore")
    for name in sys.argv[1:] or CASES:
        time, band, pixel_m, rows = CASES[name]
        figure, axes = plt.subplots(len(rows), 3, figsize=(7.2, 2.5 * len(rows)))
        for column, view in zip(axes.T, (0.0, 45.0, 60.0), strict=True):
            images = [image(time, band, pixel_m, view, *each) for each in rows]
            low = min(np.percentile(each, 0.1) for each in images)
            high = max(np.percentile(each, 99.9) for each in images)
            for axis, values, (light, clouds) in zip(column, images, rows, strict=True):
                axis.imshow(values, origin="lower", cmap="gray_r" if "night" in name else "gray", vmin=low, vmax=high)
                what = "relief" if "generator" in clouds else light
                axis.set_title(f"{what}, {view:g} deg: {values.mean():.1f} K", fontsize=8)
                axis.axis("off")
        path = (RELIEF if name.startswith("relief") else FOLDER) / f"{name}.png"
        figure.tight_layout(pad=1.2)
        figure.savefig(path, dpi=70)
        plt.close(figure)
        Image.open(path).convert("L").quantize(24).save(path, optimize=True)


if __name__ == "__main__":
    main()
