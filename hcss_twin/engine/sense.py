"""Application of a sensor to a clean cube, alone or with the surrounding scene of its run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hcss_twin.core.arguments import checked
from hcss_twin.core.catalog import Catalog, used_paths
from hcss_twin.core.errors import CubeError, Problem, ScenarioError
from hcss_twin.core.files import Writing, require_not_read
from hcss_twin.core.reading import Reading
from hcss_twin.cube.coordinates import with_plane_axes
from hcss_twin.cube.reader import open_cube, stored_arrays
from hcss_twin.cube.requested_variables import INPUTS
from hcss_twin.cube.sensor_cube import RADIANCE, is_replaced, measured_cube
from hcss_twin.cube.writer import variable_attributes
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.engine.cube_sensor import CleanCube, Read, points_apart, read_clean, sensor_attributes
from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor import BuiltSensor, make_sensor
from hcss_twin.plan.sensor_geometry import examine_geometry
from hcss_twin.plan.sensor_margin import alone
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.sensor import SensorSection

if TYPE_CHECKING:
    import xarray as xr


BLIND = 0.05
"""Distance from the range of the scene, relative to its ends, that rounding to numbers does not explain."""

Progress = Callable[[Iterable[Any], int], Iterable[Any]]


def measured_path(clean: Path) -> Path:
    """Return the name of the sensor cube for a clean cube: ``NAME.sensor.nc`` for ``NAME.nc``."""
    return clean.with_name(f"{clean.stem}.sensor{clean.suffix or '.nc'}")


def require_netcdf(clean: str | os.PathLike[str]) -> None:
    """Reject a Zarr store as clean cube for a sensor.

    Raises
    ------
    CubeError
        If the name denotes a Zarr store.
    """
    if is_zarr(clean):
        raise CubeError(
            f"{os.fspath(clean)}: sensors measure NetCDF cubes; allowed: a name that ends in .nc, or no sensor"
        )


def sense_run(
    plan: Plan, tables: RadianceTables | None, clean_path: str | os.PathLike[str], progress: Progress | None = None
) -> Path:
    """Write the sensor cube of a run, ``NAME.sensor.nc``, from its clean cube, frame by frame.

    The plan's sensor measures the clean frames together with the surrounding scene, which is computed here.

    Parameters
    ----------
    plan : Plan
        A plan with a sensor.
    tables : RadianceTables or None
        Tables of the clean cube.
    clean_path : path
        The finished clean cube of the plan.
    progress : callable, optional
        Wraps the iterable of frames, given their number.

    Raises
    ------
    CubeError
        If a cube cannot be read or written.
    ProviderError
        If a provider violates its contract.
    """
    clean_path, sensor = Path(clean_path), plan.sensor
    if not sensor.stages:
        raise ValueError("the plan has no sensor")
    path = measured_path(clean_path)
    around, first = SceneAround(plan, tables, sensor), plan.scenario.frames.first
    is_written = any(spec.name == RADIANCE for spec in plan.variables)

    def measure(index: int, read: Read) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
        scene, points = around.frame(index, read(RADIANCE) if is_written else None)
        return scene, around.sensor.measure(scene, first + index, float(plan.frame_times_s[index]), points)

    _write_measured(clean_path, path, sensor, plan.catalog, measure, progress)
    return path


def _write_measured(
    clean_path: Path,
    path: Path,
    sensor: BuiltSensor,
    catalog: Catalog,
    measure: Callable[[int, Read], tuple[NDArray[Any], dict[str, NDArray[Any]]]],
    progress: Progress | None,
) -> None:
    with stored_arrays(clean_path) as stored:  # not by xarray, whose import takes as long as 30 frames
        clean = {name: stored.getncattr(name) for name in stored.ncattrs()}
    attributes = sensor_attributes(clean, sensor, catalog, clean_path.name)
    with measured_cube(clean_path, path, sensor.variables, attributes) as pair:
        frames: Iterable[int] = range(pair.frames)
        if progress is not None:
            frames = progress(frames, pair.frames)
        for index in frames:
            scene, measured = measure(index, partial(pair.values, index))
            if index == 0:
                _require_contrast(clean_path.name, sensor, scene, measured[RADIANCE])
            pair.write_frame(index, measured)


def _require_contrast(name: str, sensor: BuiltSensor, radiance: NDArray[Any], measured: NDArray[Any]) -> None:
    """Refuse a sensor that measures one value far outside the scene's in every band: nobody could use such a cube."""
    seen = []
    for clean, of_band in zip(radiance, measured, strict=True):
        value, low, high = float(of_band.flat[0]), float(clean.min()), float(clean.max())
        outside = value < (1.0 - BLIND) * low or value > (1.0 + BLIND) * high
        seen.append(f"{value:.4g}, of {low:.4g} to {high:.4g} in the scene")
        if not outside or low == high or np.any(of_band != of_band.flat[0]):
            return
    bands = ", ".join(f"'{band.name}' {text}" for band, text in zip(sensor.inputs.bands, seen, strict=True))
    raise CubeError(
        f"{name}: every pixel of the first frame measures the same radiance, W m-2 sr-1: band {bands}: the sensor "
        f"{_names(sensor)} ({sensor.title}) saturates or is "
        "made for other bands; allowed: one whose range holds the scene"
    )


@checked
@Reading.argument(CubeError)
def sense_file(
    clean_path: str | os.PathLike[str],
    section: SensorSection,
    output: str | os.PathLike[str] | None = None,
    base: Path | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write the sensor cube of a finished clean cube, frame by frame.

    Only the cube is used: beyond its edges the sensor sees the mirror image.

    Parameters
    ----------
    clean_path : path
        A finished clean cube.
    section : SensorSection
        The sensor.
    output : path, optional
        By default ``NAME.sensor.nc`` in the same folder. The file appears only when it is complete.
    base : Path, optional
        Base folder of relative paths of the sensor and of band files. By default sensor paths are relative to the
        working folder, and band paths to the original folder of the scenario, if its files still exist.
    progress : callable, optional
        Wraps the iterable of frames, given their number.

    Returns
    -------
    Path
        Path of the sensor cube.

    Raises
    ------
    CubeError
        If the cube is not a clean cube or cannot be read, or the sensor cube cannot be written.
    ScenarioError
        If the section is inconsistent with the sensor or the cube.
    ProviderError
        If the sensor violates its contract.
    """
    clean_path = Path(clean_path)
    require_netcdf(clean_path)
    path = measured_path(clean_path) if output is None else Path(output)
    with open_cube(clean_path) as dataset:
        cube = read_clean(with_plane_axes(dataset), str(clean_path), base)
    sensor = _build(section, cube, str(clean_path))
    files = cube.inputs.catalog
    require_not_read(path, used_paths(files), CubeError)
    Writing(path, CubeError, "NetCDF").check()
    _write_measured(clean_path, path, sensor, files, partial(_measure, sensor, cube, str(clean_path)), progress)
    return path


@checked
@Reading.argument(CubeError)
def sense(
    cube: str | os.PathLike[str] | xr.Dataset,
    sensor: str | os.PathLike[str] | Mapping[str, Any] | SensorSection | Scenario,
    output: str | os.PathLike[str] | None = None,
) -> xr.Dataset:
    """Return the measurement of a clean cube by a sensor.

    Blur beyond the edges of the cube uses its mirror image; a run of a scenario with a sensor computes the
    surroundings instead.

    Parameters
    ----------
    cube : path or Dataset
        A finished clean cube: file, open dataset, or dataset in memory.
    sensor : str, path, mapping, SensorSection or Scenario
        Name of a catalog sensor (``modis``), a TOML file of the same form, the keys of a scenario's ``[sensor]``
        (``{"parameters": {"noise": "nedt", "nedt": 0.05}}``), or a scenario with a sensor, whose folder is the base
        of relative paths.
    output : path, optional
        File for the sensor cube, if ``cube`` is a path; by default it stays in memory.

    Returns
    -------
    Dataset
        Measured radiance, further requested variables, and the truth variables of the clean cube.

    Raises
    ------
    CubeError, ScenarioError, ProviderError
        As :func:`sense_file`.
    """
    base = sensor.base if isinstance(sensor, Scenario) else None
    section = section_of(sensor)
    if isinstance(cube, str | os.PathLike):
        if output is not None:
            return open_cube(sense_file(cube, section, output, base))
        with open_cube(cube) as opened:
            return _in_memory(opened, section, os.fspath(cube), base).load()
    if output is not None:
        raise CubeError("output is for cubes given as a path; write this one with Dataset.to_netcdf")
    return _in_memory(cube, section, "the dataset", base)


def section_of(sensor: Any) -> SensorSection:
    """Return the sensor section for a name, path, mapping, section or scenario; raises :class:`ScenarioError`."""
    raw = sensor
    match sensor:
        case Scenario(sensor=None):
            raise ScenarioError([Problem("sensor", "is missing; a scenario with a sensor is needed")], sensor.origin)
        case Scenario(sensor=SensorSection() as section) | (SensorSection() as section):
            return section
        case str() | os.PathLike():
            raw = {"name": os.fspath(sensor)}
    try:
        return SensorSection.model_validate(raw)
    except ValidationError as error:
        raise ScenarioError(problems_from(error, SensorSection, prefix="sensor", raw=raw)) from error


def _build(section: SensorSection, cube: CleanCube, name: str) -> BuiltSensor:
    sensor = alone(make_sensor(section, cube.inputs, scene=cube.scene))
    examine_geometry(cube.scenario, sensor.stages, cube.binned)
    for stage in sensor.stages:
        if stage.instants is not None:
            raise CubeError(
                f"{name}: {stage.field}: '{stage.entry.name}' asks for the scene at other instants, and a cube holds "
                "only its frames; allowed: a run of its scenario with this sensor"
            )
    if sensor.remembers and np.any(np.diff(cube.frame_numbers) != 1):
        raise CubeError(
            f"{name}: frames are missing or out of order, and the sensor {_names(sensor)} needs earlier ones; "
            "allowed: each frame after the one before it"
        )
    return sensor


def _names(sensor: BuiltSensor) -> str:
    return ", ".join(f"'{stage.entry.name}'" for stage in sensor.stages)


def _measure(
    sensor: BuiltSensor, cube: CleanCube, name: str, index: int, read: Read
) -> tuple[NDArray[Any], dict[str, Any]]:
    """Return the radiance of a frame, and its measurements."""
    radiance, points = _sound(read(RADIANCE), cube, name), None
    if cube.has_elements:
        radiance, points = points_apart(read, cube.inputs.corner, name)
    return radiance, sensor.measure(radiance, int(cube.frame_numbers[index]), float(cube.times_s[index]), points)


def _sound(radiance: Any, cube: CleanCube, name: str) -> Any:
    """Return the radiance of a frame; raises CubeError if it is none."""
    grid = cube.inputs.grid
    wanted = len(cube.inputs.bands), grid.rows, grid.columns
    if np.shape(radiance) != wanted:
        raise CubeError(f"{name}: {RADIANCE}: a frame of shape {np.shape(radiance)}; allowed: (band, y, x) {wanted}")
    missing = int(np.count_nonzero(~np.isfinite(radiance)))
    if missing:
        raise CubeError(f"{name}: {RADIANCE}: {missing} of {radiance.size} values of a frame are not finite")
    return radiance


def _in_memory(dataset: xr.Dataset, section: SensorSection, name: str, base: Path | None) -> xr.Dataset:
    import xarray as xr

    dataset = with_plane_axes(dataset)
    cube = read_clean(dataset, name, base)
    sensor = _build(section, cube, name)
    clean = dataset["radiance"].transpose("time", "band", "y", "x")

    def read(index: int, variable: str) -> NDArray[Any]:
        values: NDArray[Any] = dataset[variable].transpose("time", ..., "y", "x").isel(time=index).to_numpy()
        return values

    frames = [_measure(sensor, cube, name, index, partial(read, index))[1] for index in range(clean.sizes["time"])]
    _require_contrast(name, sensor, read(0, RADIANCE), frames[0][RADIANCE])
    measured = dataset.drop_vars(
        [name for name, array in dataset.data_vars.items() if is_replaced(str(name), array.attrs.get(INPUTS, ""))]
    )
    # as in open_cube, where CF attributes for coordinates are part of the encoding
    for spec in sensor.variables:
        values = np.stack([frame[spec.name] for frame in frames])
        variable = xr.Variable(spec.dims, values, variable_attributes(spec))
        variable.encoding.update({key: value for key, value in clean.encoding.items() if key in _CF_ENCODING})
        measured[spec.name] = variable
    clean_name = Path(name).name if os.path.isfile(name) else ""
    changed = sensor_attributes(dataset.attrs, sensor, cube.inputs.catalog, clean_name)
    attributes = {**dataset.attrs, **changed}
    measured.attrs = {key: value for key, value in attributes.items() if value is not None}
    return measured


_CF_ENCODING = ("coordinates", "grid_mapping")
