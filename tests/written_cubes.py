"""Reading of cubes that a test has written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from hcss_twin.cube.reader import open_cube
from hcss_twin.plan.windows import Window


def loaded(path: Path) -> xr.Dataset:
    """Return a cube in memory; its file is closed."""
    with open_cube(path) as cube:
        return cube.load()


def measured_and_clean(path: Path) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the measured cube of a run, and its clean one."""
    return loaded(path.with_name(f"{path.stem}.sensor.nc")), loaded(path)


def assert_same_bits(one: Path, other: Path, window: Window | tuple[()] = ()) -> None:
    """Compare all variables of a cube, or of a window of it, with those of another cube."""
    with open_cube(one) as first, open_cube(other) as second:
        assert set(first.data_vars) == set(second.data_vars)
        for name in first.data_vars:
            np.testing.assert_array_equal(first[name].to_numpy()[..., *window], second[name].to_numpy(), str(name))
