"""Cost of a sensor per pixel and band: the radiometer on one thread.

::

    python benchmarks/sensor.py

The last line is the whole measurement of a frame, with the checks of the engine.
"""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from hcss_author import sample_sensor_inputs

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.sensor.parameters import RadiometerParameters
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.plan.sensor import make_sensor
from hcss_twin.providers import Grid, SensorInputs
from hcss_twin.scenario.sensor import SensorSection

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


def _ns(call: Callable[[int], object]) -> float:
    """Return the shortest processor time of a call, in ns per pixel."""
    spent = []
    for repeat in range(REPEATS + 1):  # the first compiles
        start = time.process_time()
        call(repeat)
        spent.append(time.process_time() - start)
    return min(spent[1:]) / ROWS / COLUMNS * 1e9


def main() -> None:
    inputs = _inputs()
    image = np.random.default_rng(1).uniform(0.5, 2.0, (1, ROWS, COLUMNS)).astype(np.float32)
    print(f"{ROWS} x {COLUMNS} pixels; ns per pixel and band")
    for case, parameters in CASES.items():
        sensor = Radiometer(inputs, RadiometerParameters(**parameters))
        print(f"{case:34}{_ns(lambda frame, own=sensor: own.measure(image, frame, 0.0)):10.2f}")
    whole = make_sensor(SensorSection(parameters=CASES["blur, noise, digital numbers"], variables=("all",)), inputs)
    print(f"{'the same, checked and stored':34}{_ns(lambda frame: whole.measure(image, frame, 0.0)):10.2f}")


if __name__ == "__main__":
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    main()
