"""The cloud columns of one frame of a cube: base, top and thickness of every pixel."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.cube.reader import open_cube
from hcss_twin.errors import CubeError

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

NEEDED = ("cloud_thickness", "cloud_top_altitude")
FRACTION = "cloud_fraction"

# A cube holds altitudes in single precision: up to 1 mm is lost below 16 km, of both top and thickness.
_ROUNDING_M = 0.01


@dataclass(frozen=True)
class CloudColumns:
    """What one frame says about where its cloud is.

    Attributes
    ----------
    title : str
        Title of the cube.
    time : numpy.datetime64
        Instant of the frame, UTC.
    frame : int
        Number of the frame.
    x_m, y_m : ndarray (X,), (Y,)
        Pixel centres, as in the cube.
    base_m, top_m : ndarray (Y, X)
        Altitudes of base and top over the cloudy part of the pixel; NaN where clear.
    fraction : ndarray (Y, X)
        Cloudy part of the pixel: 0 or 1 where pixels are points, as small as one point in n x n where they are means.
    """

    title: str
    time: np.datetime64
    frame: int
    x_m: Array
    y_m: Array
    base_m: Array
    top_m: Array
    fraction: Array

    @property
    def thickness_m(self) -> Array:
        """Thickness (Y, X) of the cloudy part in metres; NaN where clear."""
        return self.top_m - self.base_m

    @property
    def is_clear(self) -> bool:
        """Whether the frame holds no cloud at all."""
        return bool(np.all(np.isnan(self.top_m)))


def read_columns(cube: str | Path, frame: int = 0) -> CloudColumns:
    """Read base and top of the cloud in every pixel of a frame.

    Raises
    ------
    CubeError
        If the cube cannot be read, lacks thickness or top altitude, holds more than one of them per
        pixel, has no such frame, or tells of cloud below the sea.
    """
    with open_cube(cube) as dataset:
        points, layers = _scene(dataset)
        if layers > 1:
            raise CubeError(f"the scene has {layers} cloud layers; this needs a cube of one")
        # Thickness is a mean over the whole pixel, top altitude over its cloudy part: the fraction links them.
        needed = (*NEEDED, FRACTION) if points > 1 else NEEDED
        missing = [name for name in needed if name not in dataset]
        if missing:
            raise CubeError(
                f"the cube lacks {' and '.join(missing)}; run the scenario with "
                '--set \'output.variables=["radiance", "truth"]\''
            )
        frames = int(dataset.sizes["time"])
        if not 0 <= frame < frames:
            closest = min(max(frame, 0), frames - 1)
            raise CubeError(f"frame {frame}: the cube has 0 to {frames - 1}; closest is {closest}")
        for name in NEEDED:
            if dataset[name].dims != ("time", "y", "x"):
                raise CubeError(
                    f"{name} has the dimensions {dataset[name].dims}; ('time', 'y', 'x') is needed"
                )
        # As numbers before any arithmetic: single precision would lose the base of thin high clouds.
        thickness, top = (dataset[name].isel(time=frame).to_numpy().astype(np.float64) for name in NEEDED)
        cloudy = thickness > 0.0
        fraction = cloudy.astype(np.float64)
        if FRACTION in dataset:
            fraction[cloudy] = dataset[FRACTION].isel(time=frame).to_numpy()[cloudy]
        x, y = (dataset[name].to_numpy().astype(np.float64) for name in ("x", "y"))
        moment = np.datetime64(dataset["time"].to_numpy()[frame], "ms")
        title = str(dataset.attrs.get("title", ""))
    base = np.where(cloudy, top - thickness / np.where(cloudy, fraction, 1.0), np.nan)
    base[(base < 0.0) & (base > -_ROUNDING_M)] = 0.0
    if np.any(base < 0.0):
        raise CubeError(f"the cloud's base is at {np.nanmin(base):g} m, below the sea")
    return CloudColumns(title, moment, frame, x, y, base, np.where(cloudy, top, np.nan), fraction)


def _scene(dataset: xr.Dataset) -> tuple[int, int]:
    """Return points per side of a pixel, and the number of cloud layers, from the scenario in the cube."""
    try:
        scenario = json.loads(str(dataset.attrs.get(SCENARIO_ATTRIBUTE, "")))
    except json.JSONDecodeError:
        # Cubes that this package did not simulate need not carry one.
        scenario = {}
    image, clouds = (scenario.get(key, {}) for key in ("image", "clouds"))
    return int(image.get("samples_per_pixel", 1)), max(1, len(clouds.get("layers", ())))
