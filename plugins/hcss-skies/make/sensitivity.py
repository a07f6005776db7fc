"""Change one thing of a simulation, print its statistics: ``python make/sensitivity.py forcings precision ...``.

``forcings``: the first research flight of DYCOMS-II without radiative cooling, and without subsidence. ``precision``:
BOMEX in single precision with two seeds, and in double precision. ``resolution``: BOMEX in one box with cells of
100 x 40 and 50 x 20 m. ``speed``: processor time per cell and step. Boxes are small: minutes to half an hour each.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from hcss_skies.les import statistics
from hcss_skies.les.case import Case, at_heights, read_case
from hcss_skies.les.forcings import falls_through
from hcss_skies.les.model import Model

RF01 = {"columns": [32, 32], "side_m": 35.0}
BOMEX = {"columns": [32, 32], "side_m": 100.0, "spacing_m": 40.0}
SMALL = {"columns": [24, 24], "side_m": 100.0, "spacing_m": 40.0}
FINE = {"columns": [48, 48], "side_m": 50.0, "spacing_m": 20.0}

RUNS: dict[str, dict[str, tuple[str, dict[str, Any]]]] = {
    "forcings": {
        "as published": ("dycoms-rf01", {"grid": RF01}),
        "without radiative cooling": ("dycoms-rf01", {"grid": RF01, "radiation": {"f_0_W_m2": 0.0, "f_1_W_m2": 0.0}}),
        "without subsidence": ("dycoms-rf01", {"grid": RF01, "forcing": {"subsidence_m_s": [[0, 0.0]]}}),
    },
    "precision": {
        "single": ("bomex", {"grid": BOMEX}),
        "single, another seed": ("bomex", {"grid": BOMEX, "seed": 2}),
        "double": ("bomex", {"grid": BOMEX, "precision": "double"}),
    },
    "resolution": {
        "100 x 40 m": ("bomex", {"grid": SMALL}),
        "50 x 20 m": ("bomex", {"grid": FINE}),
    },
}  # fmt: skip
HOURS = {"forcings": (2.0, 4.0), "precision": (1.5, 3.0), "resolution": (1.5, 3.0)}
"""By experiment: spin-up and end, h."""
EVERY_S, BLOCKS = 60.0, 6


def means(case: Case, begin_hours: float, end_hours: float) -> dict[str, tuple[float, float]]:
    """Return means after spin-up with their sampling error, from blocks of 15 to 20 min, which are nearly independent.

    Entrainment is the rise of the height where mean total water falls through 8 g/kg, less the subsidence there.
    """
    model = Model(case)
    z, times = model.mesh.centres_m, np.arange(3600.0 * begin_hours, 3600.0 * end_hours + 1.0, EVERY_S)
    found: dict[str, list[float]] = {}
    heights = []
    for until in times:
        model.run_until(float(until))
        series, profiles = statistics.series(model), statistics.profiles(model)
        heights.append(falls_through(z, profiles["total_water"], 8.0))
        now = {
            "cover": series["cloud_cover"], "water path, g m-2": series["mean_liquid_water_path"],
            "greatest fraction": profiles["cloud_fraction"].max(), "highest top, m": series["highest_top"],
            "lowest base, m": series["lowest_base"], "w variance, m2 s-2": profiles["w_variance"].max(),
        }  # fmt: skip
        for name, value in now.items():
            found.setdefault(name, []).append(float(value))
    result = {}
    for name, values in found.items():
        blocks = [block.mean() for block in np.array_split(np.array(values), BLOCKS)]
        result[name] = float(np.mean(blocks)), float(np.std(blocks, ddof=1) / np.sqrt(BLOCKS))
    sinking = float(at_heights(case.forcing.subsidence_m_s, np.array([np.mean(heights)]))[0])
    (rise, _), covariance = np.polyfit(times, heights, 1, cov=True)
    result["entrainment, cm/s"] = 100.0 * (float(rise) - sinking), 100.0 * float(np.sqrt(covariance[0, 0]))
    return result


def speed() -> None:
    """Print the processor time per cell and step (three stages, pressure, thermodynamics)."""
    for precision in ("single", "double"):
        model = Model(read_case("bomex", precision=precision))
        model.run_until(30.0)
        best = np.inf
        for _ in range(5):
            begun, steps = time.process_time(), model.steps
            model.run_until(model.time_s + 60.0)
            best = min(best, (time.process_time() - begun) / (model.steps - steps) / model.liquid.size)
        print(f"{precision}: {1e6 * best:.2f} us per cell and step ({model.liquid.size} cells)", flush=True)


def main(names: list[str]) -> None:
    """Run experiments."""
    for name in names:
        if name == "speed":
            speed()
            continue
        for what, (case, changed) in RUNS[name].items():
            begun = time.process_time()
            found = means(read_case(case, **changed), *HOURS[name])
            print(f"{name}: {what}")
            for quantity, (value, error) in found.items():
                print(f"  {quantity:20} {value:9.4g} +- {error:.2g}")
            print(f"  {time.process_time() - begun:.0f} s of processor time", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
