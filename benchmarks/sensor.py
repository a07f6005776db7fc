"""Cost of a sensor per pixel and band: the two methods of the radiometer, interleaved, on one thread.

::

    python benchmarks/sensor.py

``frames`` is the code of version 0.1. The last line is the whole measurement of a frame, with the checks of the engine.
"""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.plan.sensor import make_sensor
from hcss_twin.providers import Grid, SensorInputs
from hcss_twin.scenario.sensor import SensorSection
from hcss_twin.testing import sample_sensor_inputs

ROWS, COLUMNS, REPEATS = 512, 640, 25
BLUR = {"psf": "gaussian", "psf_sigma": 1.0}
NOISE = {
    "noise": "photon",
    "aperture_diameter": 0.1,
    "pixel_angle": 4e-5,
    "integration_time": 1e-3,
    "smear": False,
    "read_noise": 50.0,
}
NUMBERS = {"bits": 14, "well_depth": 1e6}
CASES: Mapping[str, Mapping[str, Any]] = {
    "nothing": {},
    "blur (Gaussian, 1 pixel)": BLUR,
    "blur (Airy)": {"psf": "airy", "aperture_diameter": 0.15, "pixel_angle": 4e-5},
    "noise": NOISE,
    "noise, digital numbers": {**NOISE, **NUMBERS},
    "blur, noise, digital numbers": {**BLUR, **NOISE, **NUMBERS},
    "few electrons (20)": {**NOISE, "aperture_diameter": 3e-4},
}


def _inputs() -> SensorInputs:
    inputs = sample_sensor_inputs()
    grid = Grid(ROWS, COLUMNS, inputs.grid.pixel_size_m)
    return dataclasses.replace(inputs, bands=inputs.bands[:1], grid=grid, catalog=Catalog())


def _ns(calls: Mapping[str, Callable[[int], object]]) -> dict[str, float]:
    """Return the shortest processor time of each call, taken in turn, in ns per pixel."""
    spent: dict[str, list[float]] = {name: [] for name in calls}
    for repeat in range(REPEATS + 1):  # the first compiles
        for name, call in calls.items():
            start = time.process_time()
            call(repeat)
            spent[name].append(time.process_time() - start)
    return {name: min(each[1:]) / ROWS / COLUMNS * 1e9 for name, each in spent.items()}


def main() -> None:
    inputs = _inputs()
    image = np.random.default_rng(1).uniform(0.5, 2.0, (1, ROWS, COLUMNS)).astype(np.float32)
    doubles = image.astype(np.float64)
    print(f"{ROWS} x {COLUMNS} pixels; ns per pixel and band\n{'':34}{'frames':>10}{'rows':>10}{'ratio':>8}")
    for case, parameters in CASES.items():
        sensors = {
            name: Radiometer(inputs, RadiometerParameters(**parameters, method=name)) for name in ("frames", "rows")
        }
        ns = _ns(
            {
                "frames": lambda frame, own=sensors["frames"]: own.measure(doubles, frame, 0.0),
                "rows": lambda frame, own=sensors["rows"]: own.measure(image, frame, 0.0),
            }
        )
        print(f"{case:34}{ns['frames']:10.1f}{ns['rows']:10.2f}{ns['frames'] / ns['rows']:8.0f}")
    whole = {
        name: make_sensor(
            SensorSection(parameters={**CASES["blur, noise, digital numbers"], "method": name}, variables=("all",)),
            inputs,
        )
        for name in ("frames", "rows")
    }
    ns = _ns({name: lambda frame, own=each: own.measure(image, frame, 0.0) for name, each in whole.items()})
    print(f"{'the same, checked and stored':34}{ns['frames']:10.1f}{ns['rows']:10.2f}{ns['frames'] / ns['rows']:8.0f}")


if __name__ == "__main__":
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    main()
