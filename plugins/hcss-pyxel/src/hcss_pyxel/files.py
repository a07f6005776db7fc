"""Reading of frame times from a cube, and writing of files that are complete or absent."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.providers import Array, CubeError

if TYPE_CHECKING:
    import xarray as xr


def frame_times_s(dataset: xr.Dataset) -> Array:
    """Return the time of each frame in seconds since the scenario's start, to the nanosecond.

    The units of the cube's time coordinate, "seconds since DATE", name the start.
    """
    start = np.datetime64(str(dataset["time"].encoding["units"]).removeprefix("seconds since ").strip(), "ns")
    seconds: Array = (dataset["time"].to_numpy().astype("datetime64[ns]") - start) / np.timedelta64(1, "s")
    return seconds


@contextmanager
def complete_or_absent(path: Path) -> Iterator[Path]:
    """Yield a draft beside ``path`` that gets its name at the end, and is removed after an error.

    Raises
    ------
    CubeError
        If the file cannot be written.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}.draft")
    try:
        yield draft
        draft.replace(path)
    except (OSError, RuntimeError) as error:
        raise CubeError(f"cannot write {path}: {error}") from error
    finally:
        draft.unlink(missing_ok=True)
