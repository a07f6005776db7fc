"""Pictures of the README: stratocumulus as independent columns and with sides, at 0, 45 and 60 deg.

    python plugins/hcss-light/benchmarks/figures.py

Needs matplotlib and pillow. 128 x 128 pixels of 50 m, seen from north.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from hcss_twin import Scenario, simulate

FOLDER = Path(__file__).parent.parent / "figures"
CASES = {"night": ("2024-04-20T23:30:00+10:00", [10.3, 11.3]), "day": ("2024-04-20T15:30:00+10:00", [3.6, 3.9])}


def image(time: str, band: list[float], view: float, light: str) -> np.ndarray:
    """Return brightness temperature (y, x)."""
    scene = Scenario.from_dict(
        {
            "time": time,
            "place": {"latitude": 20.0, "longitude": 150.0},
            "view": {"zenith": view},
            "image": {"rows": 128, "columns": 128, "pixel_size": 50.0},
            "frames": {"count": 1},
            "accuracy": 0.01,
            "bands": [band],
            "clouds": {"type": "stratocumulus", "coverage": 0.5, "edge_taper": 0.5},
            "radiance": {"light": light},
            "output": {"variables": ["radiance", "brightness_temperature"], "certificate": 0},
        }
    )
    return simulate(scene).brightness_temperature.values[0, 0]


def main() -> None:
    """Draw both pictures."""
    warnings.simplefilter("ignore")
    for name, (time, band) in CASES.items():
        figure, axes = plt.subplots(2, 3, figsize=(7.2, 5.0))
        for column, view in zip(axes.T, (0.0, 45.0, 60.0), strict=True):
            both = [image(time, band, view, light) for light in ("columns", "source")]
            limits = {
                "vmin": min(np.min(each) for each in both),
                "vmax": max(np.percentile(each, 99.9) for each in both),
            }
            for axis, values, light in zip(column, both, ("columns", "source"), strict=True):
                axis.imshow(values, origin="lower", cmap="gray_r" if name == "night" else "gray", **limits)
                axis.set_title(f"{light}, {view:g} deg: {values.mean():.1f} K", fontsize=8)
                axis.axis("off")
        figure.tight_layout(pad=1.2)
        figure.savefig(FOLDER / f"{name}.png", dpi=70)
        plt.close(figure)
        Image.open(FOLDER / f"{name}.png").convert("L").quantize(24).save(FOLDER / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
