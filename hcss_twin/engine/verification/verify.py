"""Recompute a cube from its own provenance and compare it, frame by frame, large frames tile by tile."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.core.errors import CubeError, HcssError, ScenarioError
from hcss_twin.cube.metadata import window_attribute
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.parts import Part, stream_parts, tiles
from hcss_twin.engine.recorded import Recorded, Verification
from hcss_twin.engine.simulate import cube_header
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.engine.verification.cube_layout import CubeLayout
from hcss_twin.engine.verification.recomputed_sensor import (
    as_measured,
    measured_frames,
    measured_header,
    needs_all_frames,
)
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.scenario.scenario import Scenario

Progress = Callable[[Iterable[Any], int], Iterable[Any]]


def verify_cube(
    path: str | os.PathLike[str], base: Path | None = None, frames: int | None = None, progress: Progress | None = None
) -> Verification:
    """Make the scene of a cube anew, from its scenario alone, and compare what comes out.

    A cube that a sensor measured is made anew with the clean one it was made of.
    Nothing that earlier runs kept is used, neither tables nor cloud optics, and nothing is written. Frames are
    made and read one by one.

    Parameters
    ----------
    path : path
        A finished cube.
    base : Path, optional
        Where relative paths of its scenario lead. By default where they led when it was made, if its files are
        still there, otherwise the working folder.
    frames : int, optional
        How many frames to check, spread from the first to the last; by default all.
    progress : callable, optional
        Wraps the iterable of frames, given their number.

    Returns
    -------
    Verification
        Also where the cube cannot be recomputed, with the reasons.

    Raises
    ------
    CubeError
        If the file is no finished cube, carries no provenance, or cannot be read.
    """
    with open_cube(path) as dataset:
        recorded = Recorded.of(dict(dataset.attrs), os.fspath(path))
        layout = CubeLayout(path, dataset)
        measured = SENSOR_ATTRIBUTE in dataset.attrs
    if base is None:
        known = recorded.bases()
        base = known[0] if len(known) == 1 else Path.cwd()
    found = Verification(
        cube=os.fspath(path), base=str(base), frames=layout.frames, versions=recorded.version_changes()
    )
    plan: Plan | None = None
    try:
        plan = make_plan(Scenario.from_dict(recorded.scenario, base=base, origin=os.fspath(path)), keeps_results=False)
        plan = as_measured(plan, recorded.attributes) if measured else plan
        found = _compared(found, plan, recorded, layout, frames, progress, measured)
    except CubeError:
        raise
    except ScenarioError as error:
        found = replace(found, problems=tuple(map(str, error.problems)))
    except HcssError as error:
        found = replace(found, problems=(str(error),))
    # Files are read when they are needed: of a plan that failed, those it read need not be all.
    complete = plan is not None and not found.problems
    return replace(
        found,
        files=recorded.file_changes(plan.catalog.used if plan is not None and complete else None),
        providers=recorded.provider_changes(None if plan is None else plan.assembly.entries),
    )


def _compared(
    found: Verification,
    plan: Plan,
    recorded: Recorded,
    layout: CubeLayout,
    wanted: int | None,
    progress: Progress | None,
    measured: bool,
) -> Verification:
    tables = compile_tables(plan) if plan.needs_radiance else None
    header = cube_header(plan, tables)
    if measured:
        header = measured_header(plan, header)
    with layout.matched(header) as matched:
        pairs = matched.frames
        if wanted is not None and pairs:
            pairs = [pairs[each] for each in np.unique(np.linspace(0, len(pairs) - 1, wanted).round().astype(int))]
        numbers = [ours for _, ours in pairs]
        made: Iterable[Any] = (
            _measured(plan, tables, numbers) if measured else stream_parts(plan, tables, frames=numbers)
        )
        count = 1 if measured else len(tiles(plan))
        if progress is not None:
            made = progress(made, len(pairs) * count)
        for position, part in enumerate(made):
            matched.compare_part(pairs[position // count][0], part.place, part.arrays)
        return replace(
            found,
            frames_checked=len(pairs),
            layout=matched.changes,
            attributes=recorded.attribute_changes({**header.attributes, **window_attribute(header)}),
            variables=matched.results(),
        )


def _measured(plan: Plan, tables: RadianceTables | None, numbers: Sequence[int]) -> Iterator[Part]:
    """Make frames of a measured cube, with all before them where the sensor remembers those."""
    made = range(max(numbers, default=-1) + 1) if needs_all_frames(plan) else numbers
    wanted = set(numbers)
    for number, frame in zip(made, measured_frames(plan, tables, made, stream(plan, tables, frames=made)), strict=True):
        if number in wanted:
            yield Part(number, None, frame)
