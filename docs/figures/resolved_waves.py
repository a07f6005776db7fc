"""Draw the waves of the sea: 3-5 um toward the glint and 8-14 um away from it, with pixels of 2 and 20 m.

::

    python docs/figures/resolved_waves.py [docs/images/resolved_waves.png]

Needs matplotlib. Beside the picture it prints the spread of the pixels and the estimate that the plan gives where
waves are averaged over.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine.compile import compile_tables

PICTURE = Path(__file__).parents[1] / "images" / "resolved_waves.png"
SCENE: dict[str, Any] = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 200, "columns": 300, "pixel_size": 2.0},
    "frames": {"count": 1},
    "view": {"zenith": 50.0},
    "atmosphere": {"profile": "us-standard-1976"},
    "sea": {"temperature": 291.4, "wind_speed": 10.0, "wind_from": 250.0, "model": "rough-sea"},
    "radiance": {"model": "physical"},
    "output": {"variables": ["radiance"]},
    "seed": 4,
}
PANELS = (("mwir", 20.0, "3-5 um, toward the glint"), ("lwir", 200.0, "8-14 um, away from the sun"))
"""Band, bearing toward the sensor (the sun is at 199 degrees), title."""


def scene(band: str, azimuth: float, **overrides: Any) -> Scenario:
    return Scenario.from_dict(SCENE, {"bands": [band], "view.azimuth": azimuth, "sea.waves": "on", **overrides})


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    figure, axes = plt.subplots(2, 2, figsize=(10, 7), constrained_layout=True)
    print("| band | pixel, m | relative spread | 98.9 % of the pixels change at most by | estimate in the plan |")
    print("|---|---|---|---|---|")
    for row, (band, azimuth, title) in zip(axes, PANELS, strict=True):
        limits: dict[str, float] = {}
        for axis, size in zip(row, (2.0, 20.0), strict=True):
            pixel = {"image.pixel_size": size}
            values = simulate(scene(band, azimuth, **pixel)).radiance.values[0, 0].astype(float)
            plan = make_plan(scene(band, azimuth, **pixel, **{"sea.waves": "off"}))
            told = next(item.estimate for item in plan.omissions if item.what == "waves as shapes")
            change = np.abs(values / values.mean() - 1.0)
            spread, most = values.std() / values.mean(), np.quantile(change, 0.989)
            print(f"| {band} | {size:g} | {spread:.1e} | {most:.1e} | {told:.1e} |")
            limits = limits or {"vmin": np.quantile(values, 0.002), "vmax": np.quantile(values, 0.998)}
            extent = (0.0, size * values.shape[1], 0.0, size * values.shape[0])
            image = axis.imshow(values, origin="lower", cmap="gray", extent=extent, **limits)
            axis.set_title(f"{title}, pixels of {size:g} m", fontsize=10)
            axis.set_xlabel("m")
        figure.colorbar(image, ax=row, label="W m-2 sr-1", shrink=0.9)
    figure.savefig(target, dpi=110)
    print("factors that bring the mean over the waves to the mean sea, by term:")
    for band, azimuth, _ in PANELS:
        for size in (2.0, 20.0):
            plan = make_plan(scene(band, azimuth, **{"image.pixel_size": size}))
            started = time.perf_counter()
            tables = compile_tables(plan)
            took = time.perf_counter() - started
            assert tables.waves is not None
            factors = zip(plan.assembly.model.terms, tables.waves.level[0][:, 0], strict=True)
            changed = ", ".join(f"{name} {factor:.4f}" for name, factor in factors if abs(factor - 1.0) > 5e-5)
            print(f"{band} {size:g} m, compiled in {took:.0f} s, {tables.estimated_error:.0e} off: {changed}")


if __name__ == "__main__":
    main()
