"""The clock of a cube: seconds since the scenario's start."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import CubeError

if TYPE_CHECKING:
    import xarray as xr

_UNITS = "seconds since "


def start_of(dataset: xr.Dataset) -> np.datetime64:
    """Return the scenario's start (UTC) of an open cube, from which its file counts seconds.

    Raises
    ------
    CubeError
        If the file counts time in another way.
    """
    units = str(dataset["time"].encoding.get("units", ""))
    try:
        if units.startswith(_UNITS):
            return np.datetime64(units.removeprefix(_UNITS).strip(), "ns")
    except ValueError:
        pass
    raise CubeError(f"time is in '{units}'; a cube has '{_UNITS}' and a date")


def frame_times_s(dataset: xr.Dataset) -> NDArray[np.float64]:
    """Return the time of each frame in seconds since the scenario's start, to the nanosecond.

    Raises
    ------
    CubeError
        If the file counts time in another way.
    """
    since = dataset["time"].to_numpy().astype("datetime64[ns]") - start_of(dataset)
    seconds: NDArray[np.float64] = since / np.timedelta64(1, "s")
    return seconds
