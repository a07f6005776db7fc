"""Draw the degraded image of Fig. 17 of the HCSS paper: cirrus in 2.7-3.0 um, clean and as measured.

::

    python docs/figures/degraded_cirrus.py [docs/images/degraded_cirrus.png]

Runs the shipped scenario ``degraded-cirrus``. Needs matplotlib.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from hcss_twin import Scenario, sense, simulate

PICTURE = Path(__file__).parents[1] / "images" / "degraded_cirrus.png"
CUT = slice(330, 430), slice(360, 460)
"""Rows and columns of the part that is drawn enlarged."""


def draw(scenario: Scenario, path: Path) -> Path:
    """Draw the whole image and a part of it, clean above and measured below."""
    clean = simulate(scenario)
    measured = sense(clean, scenario)
    figure, axes = plt.subplots(2, 2, figsize=(9.2, 8.2), layout="constrained")
    frames = [1e3 * cube.radiance.isel(time=0, band=0).to_numpy() for cube in (clean, measured)]
    low, high = np.percentile(frames[0], (0.5, 99.5))
    margin = 0.1 * (high - low)
    x, y = (clean[name].to_numpy() / 1e3 for name in ("x", "y"))
    names = ("clean", "blurred (Gaussian, 1.5 pixels) and noisy (0.7 mW m$^{-2}$ sr$^{-1}$)")
    for (whole, part), frame, name in zip(axes, frames, names, strict=True):
        for axis, (rows, columns) in ((whole, (slice(None), slice(None))), (part, CUT)):
            extent = (x[columns][0], x[columns][-1], y[rows][0], y[rows][-1])
            drawn = axis.imshow(
                frame[rows, columns],
                origin="lower",
                extent=extent,
                cmap="gray",
                vmin=low - margin,
                vmax=high + margin,
                interpolation="nearest",
            )
            axis.set_xlabel("x (km, east)")
            axis.set_ylabel("y (km, north)")
        whole.set_title(name, fontsize=10)
        part.set_title("2 km of it", fontsize=10)
    bar = figure.colorbar(drawn, ax=axes.ravel().tolist(), shrink=0.7, extend="both")
    bar.set_label("radiance, 2.7-3.0 um (mW m$^{-2}$ sr$^{-1}$)")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    plt.close(figure)
    return path


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    sys.stdout.write(f"{draw(Scenario.load('degraded-cirrus'), target)}\n")
