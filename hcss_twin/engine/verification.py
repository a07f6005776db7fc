"""Verification of a cube by recomputation from its provenance, frame by frame, large frames tile by tile."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CubeError, HcssError, ScenarioError
from hcss_twin.core.json_numbers import json_number, json_value
from hcss_twin.core.reading import Reading
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.cube.coordinates import with_plane_axes
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.metadata import window_attribute
from hcss_twin.cube.reader import open_cube, stored_arrays
from hcss_twin.cube.requested_variables import INPUTS
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE, is_replaced
from hcss_twin.cube.variables import LAYER
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.cube_comparison import TOLERANCE, CubeComparison, VariableCheck
from hcss_twin.engine.cube_sensor import sensor_attributes
from hcss_twin.engine.parts import Part, stream_parts, tiles
from hcss_twin.engine.provenance import Change, FileChange, Recorded
from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.simulate import cube_header
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays, planned_rays
from hcss_twin.plan.sensor import BuiltSensor
from hcss_twin.plan.sensor_margin import alone
from hcss_twin.scenario.scenario import Scenario

Progress = Callable[[Iterable[Any], int], Iterable[Any]]


class Verdict(StrEnum):
    """Outcome of a verification."""

    IDENTICAL = "identical"
    EQUAL = "equal"
    DIFFERENT = "different"
    NOT_RECOMPUTED = "not recomputed"


@dataclass(frozen=True)
class Verification:
    """Comparison of a cube with its recomputation from its provenance.

    Attributes
    ----------
    cube, base : str
        The file, and the base folder of relative paths of its scenario.
    frames, frames_checked : int
        Number of frames of the cube, and of recomputed frames.
    problems : tuple of str
        Reasons why it could not be recomputed; empty on success.
    layout : tuple of Change
        Dimensions, variables and types that differ from those the scenario defines.
    versions, providers, attributes : tuple of Change
        Possible causes of differences; by themselves they do not count as differences.
    variables : tuple of VariableCheck
        Checks by variable, coordinates first.
    """

    cube: str
    base: str
    frames: int
    frames_checked: int = 0
    problems: tuple[str, ...] = ()
    layout: tuple[Change, ...] = ()
    files: tuple[FileChange, ...] = ()
    versions: tuple[Change, ...] = ()
    providers: tuple[Change, ...] = ()
    attributes: tuple[Change, ...] = ()
    variables: tuple[VariableCheck, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Outcome."""
        if self.problems:
            return Verdict.NOT_RECOMPUTED
        if self.layout or any(variable.beyond for variable in self.variables):
            return Verdict.DIFFERENT
        return Verdict.EQUAL if any(variable.unequal for variable in self.variables) else Verdict.IDENTICAL

    @property
    def passed(self) -> bool:
        """Whether the cube is identical, or equal within the tolerance."""
        return self.verdict in (Verdict.IDENTICAL, Verdict.EQUAL)

    @property
    def largest(self) -> float:
        """Largest relative difference in any variable."""
        return max((variable.largest for variable in self.variables), default=0.0)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for ``hcss verify --json``; non-finite numbers are None."""
        return {
            "verdict": str(self.verdict),
            "passed": self.passed,
            "tolerance": TOLERANCE,
            "largest_difference": json_number(self.largest),
            **json_value(asdict(self)),
        }


@checked
@Reading.argument(CubeError)
def verify_cube(
    path: str | os.PathLike[str],
    base: Path | None = None,
    frames: int | None = None,
    progress: Progress | None = None,
    data: Iterable[Path] = (),
) -> Verification:
    """Recompute a cube from its scenario alone, and compare.

    A sensor cube is recomputed together with its clean cube. Cached results of earlier runs, such as tables or cloud
    optics, are not used, and nothing is written.

    The cube may come from an unknown source, so its scenario can read only files in the cube's folder, ``base`` and
    ``data``, and in place of files that are not there those that the cube stores; messages do not quote the contents of
    others. Rows and columns are compared before anything is computed.

    Parameters
    ----------
    path : path
        A finished cube.
    base : Path, optional
        Base folder of relative paths of its scenario. By default the first of the cube's folder, the working folder,
        ``data`` and the only one in them that has one of the recorded files, otherwise the working folder.
    frames : int, optional
        Number of frames to check, spread from the first to the last; by default all.
    progress : callable, optional
        Wraps the iterable of frames, given their number.
    data : iterable of Path, optional
        Other files or folders that the scenario may read, besides the cube's folder and ``base``.

    Returns
    -------
    Verification
        Also if the cube cannot be recomputed, with the reasons.

    Raises
    ------
    CubeError
        If the file is not a finished cube, has no provenance, or cannot be read.
    """
    data = [*data]
    with open_cube(path) as dataset:
        recorded = Recorded.of(dict(dataset.attrs), os.fspath(path), base, data)
        axes = {name: dataset[name].to_numpy() for name in ("time", "band", LAYER) if name in dataset.coords}
        plane = with_plane_axes(dataset).sizes
        size = plane.get("y", 0), plane.get("x", 0)
    if axes.get("time", np.empty(0)).dtype.kind != "M":
        raise CubeError(f"cannot read {os.fspath(path)}: it has no frame times (coordinate time)")
    shelf = ResultCache(within=[Path(path).absolute().parent, *([] if base is None else [base]), *data])
    outcome = Verification(os.fspath(path), str(recorded.base), axes["time"].size, versions=recorded.version_changes())
    plan: Plan | None = None
    with recorded.stored_files(os.fspath(path)) as shelf.stored:
        try:
            scenario = Scenario.from_dict(recorded.scenario, base=recorded.base, origin=os.fspath(path), shelf=shelf)
            if not scenario.sections:  # the size of other rays is compared with their cube
                outcome = replace(outcome, layout=_other_size(size, scenario))
            if not outcome.layout:
                rays = partial(_rays_then, recorded.attributes)
                plan = make_plan(scenario, keeps_results=False, shelf=shelf, rays=rays)
                if SENSOR_ATTRIBUTE in recorded.attributes:
                    plan = replace(plan, sensor=_sensor_then(plan, recorded.attributes))
                outcome = _compare(outcome, plan, recorded, axes, frames, progress)
        except CubeError:
            raise
        except ScenarioError as error:
            problems = (replace(problem, message=_unquoted(problem.message, shelf)) for problem in error.problems)
            outcome = replace(outcome, problems=tuple(map(str, problems)))
        except HcssError as error:
            outcome = replace(outcome, problems=(_unquoted(str(error), shelf),))
    # Files are read on demand, so a failed plan may not have read all of them.
    return replace(
        outcome,
        files=recorded.file_changes(None if plan is None or outcome.problems else plan.catalog.used, shelf),
        providers=recorded.provider_changes(None if plan is None else plan.assembly.entries),
    )


def _other_size(size: tuple[int, int], scenario: Scenario) -> tuple[Change, ...]:
    """Return the image dimensions in which the cube differs from its scenario."""
    image = scenario.image
    shape = (image.rows, image.columns)
    if image.window is not None:
        shape = tuple(span.stop - span.start for span in image.window.slices(*shape))
    pairs = zip(("rows", "columns"), size, shape, strict=True)
    return tuple(Change(name, str(cube), str(ours)) for name, cube, ours in pairs if cube != ours)


def _unquoted(message: str, shelf: ResultCache) -> str:
    """Return a message without quotations from the user's files, any of which it could concern."""
    if not shelf.own_files:
        return message
    files = ", ".join(sorted(map(str, shelf.own_files)))
    return f"a problem with a file of the scenario, which is not quoted here; `hcss validate` says more ({files})"


def _compare(
    outcome: Verification,
    plan: Plan,
    recorded: Recorded,
    axes: Mapping[str, NDArray[Any]],
    wanted: int | None,
    progress: Progress | None,
) -> Verification:
    tables = compile_tables(plan) if plan.needs_radiance else None
    header = cube_header(plan, tables)
    measured = SENSOR_ATTRIBUTE in recorded.attributes
    if measured and plan.sensor.stages:
        header = _measured_header(plan, plan.sensor, header)
    with stored_arrays(outcome.cube) as file:
        comparison = CubeComparison(outcome.cube, file, axes, header)
        pairs = comparison.frames
        if wanted is not None and pairs:
            pairs = [pairs[index] for index in np.unique(np.linspace(0, len(pairs) - 1, wanted).round().astype(int))]
        numbers = [ours for _, ours in pairs]
        count = 1 if measured else len(tiles(plan))
        parts: Iterable[Part] = (
            _measured_parts(plan, tables, numbers) if measured else stream_parts(plan, tables, frames=numbers)
        )
        if progress is not None:
            parts = progress(parts, len(pairs) * count)
        for position, part in enumerate(parts):
            comparison.add_part(*pairs[position // count], part.place, part.arrays)
    return replace(
        outcome,
        frames_checked=len(pairs),
        layout=tuple(comparison.changes),
        attributes=recorded.attribute_changes({**header.attributes, **window_attribute(header)}),
        variables=tuple(comparison.checks.values()),
    )


def _sensor_then(plan: Plan, attributes: Mapping[str, Any]) -> BuiltSensor:
    """Return the sensor of a sensor cube's plan, with the surrounding scene if the original measurement had it."""
    from_scene = _from_scene(attributes)
    if not plan.sensor.stages:
        raise CubeError("it was measured by a sensor, but its scenario has none")
    return plan.sensor if from_scene else alone(plan.sensor)


def _from_scene(attributes: Mapping[str, Any]) -> bool:
    """Return whether a sensor cube is of a run, not of a finished clean cube."""
    try:
        return bool(json.loads(attributes[SENSOR_ATTRIBUTE]).get("measured_from") == "scene")
    except (ValueError, TypeError, AttributeError) as error:
        raise CubeError(f"the global attribute {SENSOR_ATTRIBUTE} is malformed: {error}") from error


def _rays_then(attributes: Mapping[str, Any], scenario: Scenario, catalog: Catalog) -> Rays | None:
    """Return the rays of a cube; those of a finished clean cube knew nothing of a sensor that measured it later."""
    later = SENSOR_ATTRIBUTE in attributes and not _from_scene(attributes)
    if later and ".integration_time" not in str(attributes.get("hcss_filled_in", "")):
        scenario = scenario.model_copy(update={"sensor": None})
    return planned_rays(scenario, catalog)


def _measured_header(plan: Plan, sensor: BuiltSensor, clean: CubeHeader) -> CubeHeader:
    changed = sensor_attributes(clean.attributes, sensor, plan.catalog, "")
    kept = (
        variable
        for variable in clean.variables
        if not is_replaced(variable.name, str(variable.attributes.get(INPUTS, "")))
    )
    return replace(
        clean,
        variables=(*kept, *sensor.variables),
        attributes={name: value for name, value in {**clean.attributes, **changed}.items() if value is not None},
    )


def _measured_parts(plan: Plan, tables: RadianceTables | None, numbers: Sequence[int]) -> Iterator[Part]:
    """Compute frames of a sensor cube, including all earlier ones if the sensor remembers them."""
    sensor = plan.sensor
    computed = range(max(numbers, default=-1) + 1) if sensor.remembers else numbers
    around, first, wanted = SceneAround(plan, tables, sensor), plan.scenario.frames.first, set(numbers)
    for number, clean in zip(computed, stream(plan, tables, frames=computed), strict=True):
        radiance, points = around.frame(number, clean.get("radiance"))
        measured = around.sensor.measure(radiance, first + number, float(plan.frame_times_s[number]), points)
        if number in wanted:
            yield Part(number, None, {**clean, **measured})
