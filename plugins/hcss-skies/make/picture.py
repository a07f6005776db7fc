"""Draw the picture of the README: ``python make/picture.py``, a sky of anvils at three times, one scale for all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import hcss_twin

SCENARIO = {
    "title": "Anvils over the tropical Atlantic",
    "seed": 3,
    "time": "2024-04-20T22:30:00Z",
    "place": {"latitude": 15.0, "longitude": -30.0},
    "image": {"rows": 256, "columns": 256, "pixel_size": "3 km"},
    "frames": {"count": 3, "interval": "1 h"},
    "motion": {"platform_speed": 0.0, "wind_speed": 0.0},
    "bands": ["lwir-10.8"],
    "clouds": {
        "type": "deep-convection",
        "base": 200.0,
        "top": 14_000.0,
        "thickness_min": 0.01,
        "generator": "example",
        "parameters": {"example": "anvils-1", "clear_sky": "example"},
    },
    "output": {"variables": ["brightness_temperature"]},
}


def main() -> None:
    """Simulate and write skies.png beside the README, in 64 grey levels."""
    from PIL import Image

    kelvin = np.asarray(hcss_twin.simulate(hcss_twin.Scenario.from_dict(SCENARIO)).brightness_temperature[:, 0])
    figure = Figure(figsize=(11.0, 3.9), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(kelvin), sharey=True)
    side = 0.5 * 3.0 * kelvin.shape[1]
    for number, (axis, frame) in enumerate(zip(axes, kelvin, strict=True)):
        shown = axis.imshow(
            frame, origin="lower", extent=(-side, side, -side, side), cmap="gray_r", vmin=205.0, vmax=297.0,
            interpolation="nearest",
        )  # fmt: skip
        axis.set_title(f"10.8 um, {number} h" if number else "10.8 um", fontsize=10)
        axis.tick_params(labelsize=7)
    axes[0].set_ylabel("north, km", fontsize=8)
    axes[0].set_xlabel("east, km", fontsize=8)
    bar = figure.colorbar(shown, ax=axes, shrink=0.85, pad=0.01)
    bar.set_label("K", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    path = Path(__file__).parents[1] / "skies.png"
    figure.savefig(path, dpi=90)
    Image.open(path).convert("L").quantize(64).save(path, optimize=True)


if __name__ == "__main__":
    main()
