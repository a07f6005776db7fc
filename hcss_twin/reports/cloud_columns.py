"""The cloud of one frame of a cube as columns, and as three-dimensional occupancy (cloud fraction of each voxel).

Each column holds one slab of cloud between its base and its top (eq 7 and Fig 5 of the HCSS paper). The fraction of a
voxel is the length of slab within it divided by its height, so that the sum of fractions times heights is the
thickness, for any altitude edges.
"""

from __future__ import annotations

import json
import math
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CubeError, HcssError
from hcss_twin.core.files import Writing
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.reading import Reading
from hcss_twin.cube.header import SCENARIO_ATTRIBUTE
from hcss_twin.cube.metadata import creation_time
from hcss_twin.cube.reader import open_cube
from hcss_twin.version import __version__

if TYPE_CHECKING:
    import xarray as xr


NEEDED = ("cloud_thickness", "cloud_top_altitude")
FRACTION = "cloud_fraction"

# A cube stores altitudes in single precision: below 16 km, top and thickness are each rounded by up to 1 mm.
_ROUNDING_M = 0.01
_MAX_LEVELS = 100_000
_EPOCH = np.datetime64("1970-01-01T00:00:00", "ms")


@dataclass(frozen=True)
class CloudColumns:
    """Extent of the cloud in one frame.

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
        Cloud fraction of the pixel: 0 or 1 if pixels are points, a multiple of 1 / (n x n) if they are means over n x n
        points.
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


_LARGEST_M, _HIGHEST_M = 1e9, 1e6
"""Largest scene, and the greatest altitude of cloud."""


@Reading.argument(CubeError)
def read_columns(cube: str | Path | xr.Dataset, frame: int = 0) -> CloudColumns:
    """Read base and top of the cloud in every pixel of a frame.

    Raises
    ------
    CubeError
        If the cube cannot be read, lacks thickness or top altitude, holds more than one of them per pixel, has no such
        frame, or has cloud below the sea.
    """
    with open_cube(cube) if isinstance(cube, str | Path) else nullcontext(cube) as dataset:
        points, layers = _scene(dataset)
        if layers > 1:
            raise CubeError(f"the scene has {layers} cloud layers; this needs a cube with one")
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
                    f"{name} has the dimensions {dataset[name].dims}; clouds are drawn on a grid on the ground (time, "
                    "y, x); allowed: a cube without [camera] or other rays"
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
        scenario = str(dataset.attrs.get(SCENARIO_ATTRIBUTE, ""))
    base = np.where(cloudy, top - thickness / np.where(cloudy, fraction, 1.0), np.nan)
    if points == 1 and '"generator": "' in scenario:
        base, top = _shape(scenario, frame, thickness, base, top)
    _require_measurable(x, y, base[cloudy], top[cloudy], fraction)
    base[(base < 0.0) & (base > -_ROUNDING_M)] = 0.0
    if np.any(base < 0.0):
        raise CubeError(f"the cloud's base is at {np.nanmin(base):g} m, below the sea")
    return CloudColumns(title, moment, frame, x, y, base, np.where(cloudy, top, np.nan), fraction)


def _require_measurable(x_m: Array, y_m: Array, base_m: Array, top_m: Array, fraction: Array) -> None:
    """Raise CubeError unless coordinates ascend and altitudes of cloud and fractions are in their ranges."""
    for name, values in (("x", x_m), ("y", y_m)):
        if not (np.all(np.isfinite(values)) and np.all(np.diff(values) > 0.0) and np.ptp(values) <= _LARGEST_M):
            raise CubeError(f"{name}: {values[0]:g} to {values[-1]:g} m; allowed: ascending, up to {_LARGEST_M:g} m")
    for name, values in (("cloud base", base_m), (NEEDED[1], top_m)):
        if not np.all(np.abs(values) <= _HIGHEST_M):
            raise CubeError(f"{name}: not finite, or beyond {_HIGHEST_M:g} m; the cube is damaged")
    if not np.all((fraction >= 0.0) & (fraction <= 1.0)):
        raise CubeError(f"{FRACTION}: values outside 0 to 1; the cube is damaged")


def _shape(scenario: str, frame: int, thickness_m: Array, base_m: Array, top_m: Array) -> tuple[Array, Array]:
    """Return base and top (Y, X) of clouds whose generator spreads them over heights, to a hundredth of the layer."""
    from hcss_twin.plan.make_plan import make_plan  # not for columns
    from hcss_twin.scenario.scenario import Scenario

    shares: Any = None
    with suppress(HcssError):  # files that are elsewhere
        plan = make_plan(Scenario.from_dict(json.loads(scenario)))
        shares = getattr(plan.assembly.generators[0], "height_shares", None)
    if shares is None:
        return base_m, top_m
    edges = np.linspace(plan.layers[0].base_m, plan.layers[0].top_m, 101)
    has_cloud = shares(plan.frame_times_s[frame], *plan.extent, thickness_m.astype(np.float32), edges) > 0.0
    base = np.where(thickness_m > 0.0, edges[np.argmax(has_cloud, axis=0)], np.nan)
    return base, edges[100 - np.argmax(has_cloud[::-1], axis=0)]


def _scene(dataset: xr.Dataset) -> tuple[int, int]:
    """Return the points per pixel side and the number of cloud layers from the scenario in the cube."""
    try:
        scenario = json.loads(str(dataset.attrs.get(SCENARIO_ATTRIBUTE, "")))
    except json.JSONDecodeError:
        # Cubes that this package did not simulate need not carry one.
        scenario = {}
    image, clouds = (scenario.get(key, {}) for key in ("image", "clouds"))
    return int(image.get("samples_per_pixel", 1)), max(1, len(clouds.get("layers", ())))


def altitude_edges(base_m: float, top_m: float, step_m: float) -> NDArray[np.float64]:
    """Return the multiples of ``step_m`` (Z + 1,) that enclose the altitudes from ``base_m`` to ``top_m``.

    Parameters
    ----------
    base_m, top_m : float
        Lowest base and highest top, metres above the sea, ``base_m <= top_m``.
    step_m : float
        Height of a voxel in metres, greater than 0.

    Raises
    ------
    ValueError
        If an argument is out of its range, or there would be more than 100 000 levels.
    """
    if not (math.isfinite(base_m) and math.isfinite(top_m) and base_m <= top_m):
        raise ValueError(f"altitudes: {base_m} to {top_m} m given, allowed: finite, base at or below top")
    if not 0.0 < step_m < math.inf:
        raise ValueError(f"step_m: {step_m} given, allowed: greater than 0 and finite")
    if (top_m - base_m) / step_m > 2 * _MAX_LEVELS:  # more than can be counted, with the smallest steps
        closest = (top_m - base_m) / (_MAX_LEVELS - 2)
        raise ValueError(f"step_m: {step_m} given; allowed: up to {_MAX_LEVELS} levels, closest is {closest:g}")
    first, last = math.floor(base_m / step_m), math.ceil(top_m / step_m)
    # Rounding may have moved the quotient across a whole number.
    first -= first * step_m > base_m
    last += last * step_m < top_m
    last = max(last, first + 1)
    if last - first > _MAX_LEVELS:
        raise ValueError(
            f"step_m: {step_m} given, which makes {last - first} levels; allowed: up to {_MAX_LEVELS}, "
            f"closest is {(top_m - base_m) / (_MAX_LEVELS - 2):g}"
        )
    return np.arange(first, last + 1, dtype=np.float64) * step_m


def occupancy(
    base_m: NDArray[np.floating], top_m: NDArray[np.floating], altitude_edges_m: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the fraction of each voxel that lies between base and top of its column.

    Parameters
    ----------
    base_m, top_m : ndarray (Y, X)
        Altitudes of the cloud's base and top in metres, base at or below top. NaN in both: clear sky.
    altitude_edges_m : ndarray of float64 (Z + 1,)
        Altitudes of the voxels' lower and upper faces, ascending.

    Returns
    -------
    ndarray of float32 (Z, Y, X)
        Fractions in [0, 1]; ``(fractions * diff(edges)).sum(axis=0)`` is ``top_m - base_m`` to single precision.

    Raises
    ------
    ValueError
        If shapes do not match, the edges do not ascend, a base lies above its top, or cloud extends beyond the edges,
        where cropping would silently lose volume.
    """
    edges = np.asarray(altitude_edges_m, dtype=np.float64)
    if edges.ndim != 1 or edges.size < 2 or not np.all(np.diff(edges) > 0.0):
        raise ValueError(
            "altitude_edges_m: allowed are at least 2 ascending altitudes, "
            f"{edges.size if edges.ndim == 1 else edges.shape} given{_not_ascending(edges)}"
        )
    low, high = np.asarray(base_m, dtype=np.float64), np.asarray(top_m, dtype=np.float64)
    if low.ndim != 2 or low.shape != high.shape:
        raise ValueError(f"base_m, top_m: shapes {low.shape} and {high.shape} given, allowed: one shape (Y, X)")
    cloudy = ~(np.isnan(low) & np.isnan(high))
    if np.any(cloudy):
        # Comparisons with NaN are false: a column where only one of the two is missing is caught too.
        if not np.all(low[cloudy] <= high[cloudy]):
            raise ValueError("base_m: a base lies above its top, or only one of the two is missing")
        lowest, highest = float(low[cloudy].min()), float(high[cloudy].max())
        if not (edges[0] <= lowest and highest <= edges[-1]):
            raise ValueError(
                f"altitude_edges_m: {edges[0]:g} to {edges[-1]:g} m given, but cloud reaches from {lowest:g} "
                f"to {highest:g} m; allowed: edges that enclose it"
            )
    shares = np.zeros((edges.size - 1, *low.shape), dtype=np.float32)
    # Clear columns become slabs of zero height.
    low, high = np.where(cloudy, low, edges[0]), np.where(cloudy, high, edges[0])
    for level, (lower, upper) in enumerate(pairwise(edges)):
        cut = np.minimum(high, upper) - np.maximum(low, lower)
        shares[level] = np.maximum(cut, 0.0) / (upper - lower)
    return shares


def _not_ascending(edges: NDArray[np.float64]) -> str:
    if edges.ndim != 1 or edges.size < 2:
        return ""
    index = int(np.argmin(np.diff(edges) > 0.0))
    return f", where {edges[index + 1]:g} m follows {edges[index]:g} m"


def write_occupancy(columns: CloudColumns, path: Path, step_m: float) -> tuple[int, int, int]:
    """Write the cloud fraction of each voxel (CF-1.11), in levels of ``step_m``.

    The file is written atomically; an older file is kept until then.

    Parameters
    ----------
    columns : CloudColumns
        One frame; with cloud in at least one pixel.
    path : Path
        File to write; its folder must exist.
    step_m : float
        Height of a voxel in metres.

    Returns
    -------
    tuple of int
        Levels, rows and columns.

    Raises
    ------
    CubeError
        If the frame is clear, the step is out of its range, or the file cannot be written.
    """
    if columns.is_clear:
        raise CubeError(f"frame {columns.frame} has no cloud: there is no volume to write")
    try:
        edges = altitude_edges(float(np.nanmin(columns.base_m)), float(np.nanmax(columns.top_m)), step_m)
    except ValueError as error:
        raise CubeError(str(error)) from error
    shares = occupancy(columns.base_m, columns.top_m, edges)
    shares *= columns.fraction.astype(np.float32)
    with Writing(path, CubeError, "NetCDF") as draft:
        _write(draft, columns, edges, shares)
    levels, rows, width = shares.shape
    return levels, rows, width


def _write(path: Path, columns: CloudColumns, edges: NDArray[np.float64], shares: NDArray[np.float32]) -> None:
    with NetcdfFile(path, "w") as file:

        def add(name: str, kind: str, dimensions: tuple[str, ...], values: Any, **attributes: str) -> None:
            # most voxels are 0 or 1, so the fastest level makes the file many times smaller
            packed: dict[str, Any] = (
                {"compression": "zlib", "complevel": 1, "shuffle": True} if len(dimensions) == 3 else {}
            )
            variable = file.createVariable(name, kind, dimensions, fill_value=False, **packed)
            variable.setncatts(attributes)
            variable[...] = values

        file.setncatts(
            {
                "Conventions": "CF-1.11",
                "title": f"Cloud occupancy of: {columns.title}",
                "source": f"hcss_twin {__version__}, from cloud thickness and top altitude of a simulated cube",
                "comment": "Simulated, not observed. One slab of cloud per column, over the cloudy part of "
                "the pixel; volume in a column divided by the area of the pixel is the cube's thickness.",
                "history": f"{creation_time():%Y-%m-%dT%H:%M:%SZ} created by hcss_twin",
                "frame": np.int32(columns.frame),
            }
        )
        file.createDimension("bound", 2)
        for name, values in (("altitude", 0.5 * (edges[:-1] + edges[1:])), ("y", columns.y_m), ("x", columns.x_m)):
            file.createDimension(name, values.size)
            add(name, "f8", (name,), values, units="m", **_COORDINATES[name])
        add("altitude_bounds", "f8", ("altitude", "bound"), np.stack((edges[:-1], edges[1:]), axis=1))
        add(
            "time",
            "f8",
            (),
            (columns.time - _EPOCH) / np.timedelta64(1, "s"),
            units="seconds since 1970-01-01 00:00:00",
            calendar="standard",
            units_metadata="leap_seconds: none",
            standard_name="time",
            long_name="time of the frame",
            axis="T",
        )
        add(
            "cloud_occupancy",
            "f4",
            ("altitude", "y", "x"),
            shares,
            units="1",
            long_name="fraction of the voxel filled with cloud",
            coordinates="time",
            cell_methods="altitude: y: x: mean",
            comment="Volume fraction between the bounds of altitude and over the pixel.",
        )


_COORDINATES = {
    "altitude": {
        "long_name": "altitude of the voxel's centre above the sea",
        "standard_name": "altitude",
        "positive": "up",
        "axis": "Z",
        "bounds": "altitude_bounds",
    },
    "y": {"long_name": "distance north of the image centre", "standard_name": "projection_y_coordinate", "axis": "Y"},
    "x": {"long_name": "distance east of the image centre", "standard_name": "projection_x_coordinate", "axis": "X"},
}
