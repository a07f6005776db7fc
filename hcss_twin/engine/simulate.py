"""Execution of a scenario: plan, compile, stream, write."""

from __future__ import annotations

import json
import logging
import tempfile
import warnings
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from hcss_twin.core.arguments import checked
from hcss_twin.core.catalog import used_paths
from hcss_twin.core.environment import announce_compilation
from hcss_twin.core.errors import CertificateWarning, CubeError
from hcss_twin.core.files import require_not_read
from hcss_twin.core.kernels import compiling_meanwhile, wait_for_kernels
from hcss_twin.core.memory import naming_memory
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.core.stages import stage
from hcss_twin.cube.header import BandInfo, CubeHeader, LayerInfo, WindowInfo
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.streamed_writer import BackgroundWriter, frame_bytes
from hcss_twin.cube.zarr_writer import cube_writer
from hcss_twin.engine.first_kernels import kernels_of
from hcss_twin.engine.parts import Part, Workers, parts_of, stream_parts, tile_shape
from hcss_twin.engine.provenance import leaves, provenance
from hcss_twin.engine.stages.stage import Frame
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from hcss_twin.engine.certificate.certificate import Certificate
    from hcss_twin.engine.tables.radiance_tables import RadianceTables

__all__ = ["run"]


def overlaps(plan: Plan) -> bool:
    """Return whether no provider reads NetCDF files during the computation of frames.

    The library is not thread safe, so no frame can be written while a provider reads. Providers of this package read
    their files at construction; for those of other packages this is unknown, so their frames are written in the main
    thread.
    """
    waves = (Kind.SEA,) if plan.waves.varies else ()
    kinds = (Kind.CLOUDS, Kind.ELEMENTS, Kind.SURFACES, Kind.VARIABLES, *waves)
    entries = plan.assembly.entries.values()
    return all(entry.distribution == OWN_DISTRIBUTION for entry in entries if entry.kind in kinds)


FOCAL_PLANE = (
    "Simulated, not observed. Rows and columns are those of the focal plane; each pixel has its own place and view."
)
"""Comment of a cube whose image is no grid on the ground."""

IN_MEMORY_BYTES = 512 * 2**20
"""Cubes up to this size are loaded into memory; larger ones stay in a temporary file."""

BATCH_BYTES = 2**16
"""Frames are collected until they exceed this size: writing 64 kB costs about as much as a call of the library."""

_T = TypeVar("_T")
Progress = Callable[[Iterable[_T], int], Iterable[_T]]


@naming_memory()
def run(
    plan: Plan,
    output: str | Path,
    progress: Progress[Any] | None = None,
    report: Callable[[Certificate], None] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    replace: bool = True,
    from_curves: bool = False,
) -> Path:
    """Compute a planned scene and write its cube with certificate and, with a sensor, the sensor cube.

    The sensor cube ``NAME.sensor.nc`` is computed from the finished clean cube ``NAME.nc`` and the surrounding scene.

    Parameters
    ----------
    output : path
        Final name; the file appears only when the cube is complete. A name that ends in ``.zarr`` creates a Zarr
        store.
    progress : callable, optional
        Wraps the iterable of frames, or of tiles of large frames, given their number, like ``tqdm``.
    report : callable, optional
        Called with the certificate, if there is one, when the cube is complete. By default a failed certificate
        causes a :class:`CertificateWarning`.
    workers : int
        Number of processes that compute frames, or tiles of large frames; the cube does not depend on it.
    scheduler : str, optional
        Address of a Dask cluster that computes them instead.
    replace : bool
        Whether to replace an existing cube, or one that another process writes in the meantime.
    from_curves : bool
        Whether the certificate may read its reference columns from curves (:func:`certify`).

    Returns
    -------
    Path
        Path of the cube.

    Raises
    ------
    ProviderError
        If a provider breaks its contract.
    CubeError
        If a cube cannot be written.
    """
    if plan.sensor.stages:
        from hcss_twin.engine.sense import require_netcdf

        require_netcdf(output)
    _require_no_input(plan, output)
    certificate, tables = _write_clean(plan, output, progress, workers, scheduler, replace, from_curves)
    if plan.sensor.stages:
        from hcss_twin.engine.sense import sense_run  # only for scenes with a sensor

        with stage("sensor"):
            sense_run(plan, tables, output, progress)
    if certificate is not None:
        (report or _warn)(certificate)
    return Path(output)


def _write_clean(
    plan: Plan,
    output: str | Path,
    progress: Progress[Any] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    replace: bool = True,
    from_curves: bool = False,
) -> tuple[Certificate | None, RadianceTables | None]:
    """Write the cube of a planned scene; return its certificate, if pixels were checked, and its tables, if any."""
    writer_of, compression = cube_writer(output), plan.scenario.output.compression or None
    tables: RadianceTables | None = None
    sample: PixelSample | None = None
    if plan.needs_radiance:
        from hcss_twin.engine.compile import tables_of  # a mask alone needs no radiance

        with stage("tables"):
            tables = tables_of(plan)
        if plan.scenario.output.certificate:
            from hcss_twin.engine.certificate.certificate_pixels import PixelSample

            sample = PixelSample(plan)
    certificate: Certificate | None = None
    header = cube_header(plan, tables)
    if workers > 1 or scheduler is not None:
        wait_for_kernels()  # others find what copies have compiled
    _require_no_input(plan, output)  # again, with the files read for the tables
    with (
        Workers.of(workers, scheduler) as pool,
        writer_of(output, header, compression=compression, tile=tile_shape(plan), replace=replace) as writer,
    ):
        parts: Iterable[Part] = stream_parts(plan, tables, sample, pool.executor, pool.count)
        if progress is not None:
            parts = progress(parts, parts_of(plan))
        with stage("frames"), BackgroundWriter(writer) if overlaps(plan) else nullcontext(writer) as sink:
            for first, window, frames in _batches(parts):
                if len(frames) > 1:
                    sink.write_frames(first, frames)
                else:
                    sink.write_tile(first, window, frames[0])
        if tables is not None and sample is not None:
            from hcss_twin.engine.certificate.certify import certify, with_verdict

            with stage("certificate"):
                certificate = with_verdict(plan, certify(plan, tables, sample.frames, from_curves))
            writer.set_attributes(certificate.attributes())
    return certificate, tables


def _batches(parts: Iterable[Part]) -> Iterator[tuple[int, Window | None, list[Frame]]]:
    """Yield consecutive small frames together, with the number of the first; other frames and tiles one by one."""
    frames: list[Frame] = []
    first, size = 0, 0
    for part in parts:
        if part.place is not None:
            yield part.frame, part.place, [part.arrays]
            continue
        first, size = part.frame - len(frames), size + frame_bytes(part.arrays)
        frames.append(part.arrays)
        if size > BATCH_BYTES:
            yield first, None, frames
            frames, size = [], 0
    if frames:
        yield first, None, frames


def _require_no_input(plan: Plan, output: str | Path) -> None:
    """Refuse to overwrite the scenario or a file that it reads, naming its key; also for the sensor cube."""
    scenario, outputs = plan.scenario, [Path(output)]
    if plan.sensor.stages:
        from hcss_twin.engine.sense import measured_path

        outputs.append(measured_path(Path(output)))
    for path in (Path(scenario.origin), *used_paths(plan.catalog)):
        try:
            for written in outputs:
                require_not_read(written, [path], CubeError)
        except CubeError as error:
            keys = {
                (scenario.base / text).resolve(): scenario.field_as_typed(key)
                for key, text in leaves(json.loads(scenario.to_json()))
                if isinstance(text, str) and len(text) < 255
            }
            key = keys.get(path.resolve())
            raise CubeError(f"{error} (scenario key {key})" if key else str(error)) from None


def _warn(certificate: Certificate) -> None:
    if not certificate.passed:
        warnings.warn("; ".join(certificate.summary), CertificateWarning, stacklevel=3)


@checked
@naming_memory()
def simulate(
    scenario: Scenario | str | Path | dict[str, Any],
    output: str | Path | None = None,
    *,
    overrides: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Compute the cube of a scenario and open it.

    Parameters
    ----------
    scenario : Scenario, str, Path or dict
        What to simulate: a scenario, the name of a shipped one, a scenario file, or its tables.
    output : path, optional
        File for the cube. By default the cube is in memory or, beyond 512 MiB, in a temporary file that is deleted
        with the dataset. The clean cube is returned; the sensor cube of a scenario with a sensor is written next to
        ``output``. For a cube in memory, use :func:`hcss_twin.sense`.
    overrides : mapping, optional
        Dotted key to value, for example ``{"frames.count": 1}``.

    The first call on a machine compiles kernels and logs a message.

    Returns
    -------
    xarray.Dataset
        Read lazily if it is backed by a file.

    Raises
    ------
    ScenarioError, ProviderError, CubeError
        As :func:`make_plan` and :func:`run`.
    """
    scenario = Scenario.of(scenario, overrides)
    with announce_compilation(logging.getLogger(__name__).warning), compiling_meanwhile(partial(kernels_of, scenario)):
        plan = make_plan(scenario)
        if output is not None:
            return open_cube(run(plan, output))
        return _in_memory(plan)


def _in_memory(plan: Plan) -> xr.Dataset:
    """Write a cube to a temporary folder and load it if it is not too large."""
    folder = tempfile.TemporaryDirectory(prefix="hcss-twin-")
    try:
        path = Path(folder.name) / "cube.nc"
        certificate, _ = _write_clean(plan, path)
        if certificate is not None:
            _warn(certificate)
        dataset = open_cube(path)
        if plan.uncompressed_bytes > IN_MEMORY_BYTES:
            weakref.finalize(dataset, folder.cleanup)
            return dataset
        with dataset:
            loaded = dataset.load()
    except BaseException:
        folder.cleanup()
        raise
    folder.cleanup()
    return loaded


def cube_header(plan: Plan, tables: RadianceTables | None) -> CubeHeader:
    """Return the header of the cube of a plan; call it after the tables are compiled."""
    scenario = plan.scenario
    return CubeHeader(
        start=scenario.time,
        frame_times_s=plan.frame_times_s.tolist(),
        bands=tuple(BandInfo(b.name, b.lower_um, b.upper_um, b.central_um) for b in plan.bands),
        rows=plan.pixels[0],
        columns=plan.pixels[1],
        pixel_size_m=plan.image.pixel_size_m,
        latitude=scenario.place.latitude,
        longitude=scenario.place.longitude,
        view_zenith_deg=plan.view.zenith_deg,
        view_azimuth_deg=plan.view.azimuth_deg,
        solar_zenith_deg=np.asarray(plan.sun_zenith_deg).tolist(),
        solar_azimuth_deg=np.asarray(plan.sun_azimuth_deg).tolist(),
        variables=tuple(spec for spec in plan.variables if not plan.is_grid or spec.kind != "geometry"),
        attributes=provenance(plan, tables) | ({} if plan.is_grid else {"comment": FOCAL_PLANE}),
        platform_speed_m_s=plan.assembly.motion.platform_speed_m_s,
        layers=tuple(LayerInfo(layer.name, layer.base_m, layer.top_m) for layer in plan.layers),
        window=_window(plan),
        geometry=tuple(spec for spec in plan.variables if plan.is_grid and spec.kind == "geometry"),
        sensor_altitude_m=scenario.platform.altitude,
        layout=plan.rays.layout(scenario),
    )


def _window(plan: Plan) -> WindowInfo | None:
    if not plan.is_window:
        return None
    rows, columns = plan.extent
    return WindowInfo(rows.start, columns.start, plan.grid.rows, plan.grid.columns)
