"""Times of the stages of one run, each measured apart through the functions a run is made of."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from hcss_twin.benchmarking.raw_write import write_raw
from hcss_twin.benchmarking.rounds import Rounds
from hcss_twin.benchmarking.timed_clouds import Clock, with_timed_clouds
from hcss_twin.cache.kinds import TABLES
from hcss_twin.cache.store import Store
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.certificate.certificate import Certificate
from hcss_twin.scene.certificate.certificate_pixels import PixelSample
from hcss_twin.scene.certificate.certify import certify
from hcss_twin.scene.make_plan import make_plan
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.simulate import cube_header, run
from hcss_twin.scene.stream import Frame, stream
from hcss_twin.scene.tables.kept_tables import table_key, tables_of
from hcss_twin.scene.tables.radiance_tables import RadianceTables
from hcss_twin.scene.views.tables_over_views import plans_over_views

PLAN, COMPILE, KEPT = "plan", "compile tables", "tables kept earlier"
CLOUDS, LOOK_UP, WRITE = "clouds", "look-up", "write"
CERTIFICATE = "certificate"
STAGES = (PLAN, COMPILE, KEPT, CLOUDS, LOOK_UP, WRITE)
KEPT_RUN, NEW_RUN = "whole run, kept tables", "whole run, new tables"
RUNS = (NEW_RUN, KEPT_RUN)
RAW = "raw write of the same bytes"


def time_stages(rounds: Rounds, prefix: str, scenario: Scenario, folder: Path, compiled: bool) -> None:
    """Add one round of all stages of a scenario, of its whole run, and of writing its bytes raw.

    The whole run has its tables from an earlier one and makes no certificate; one with new tables takes longer by what
    compiling them takes beyond finding them.

    Parameters
    ----------
    prefix : str
        Put before the names of the stages.
    folder : Path
        Where cubes are written.
    compiled : bool
        Whether its tables are compiled, whatever was kept; else they are kept already.
    """
    output = folder / "cube.nc"
    plan = rounds.time(prefix + PLAN, lambda: make_plan(scenario))
    if compiled:
        for toward in plans_over_views(plan):
            Store(*TABLES).forget(table_key(toward))
        rounds.time(prefix + COMPILE, lambda: tables_of(plan))
    tables = rounds.time(prefix + KEPT, lambda: tables_of(plan))
    frame = _time_frames(rounds, prefix, plan, tables)
    rounds.time(prefix + WRITE, lambda: _write(plan, tables, frame, output))
    rounds.time(prefix + KEPT_RUN, lambda: run(make_plan(scenario), output))
    if compiled:
        instead = rounds.last(prefix + COMPILE) - rounds.last(prefix + KEPT)
        rounds.add(prefix + NEW_RUN, rounds.last(prefix + KEPT_RUN) + instead)
    planes = np.concatenate([np.ravel(each).view(np.uint8) for each in frame.values()])
    rounds.time(prefix + RAW, lambda: write_raw(folder / "raw.bin", planes, plan.frame_times_s.size))


def time_certificate(rounds: Rounds, prefix: str, scenario: Scenario) -> Certificate:
    """Make the frames that a certificate checks, add the time of checking them, and return what it found.

    Parameters
    ----------
    scenario : Scenario
        Its ``output.certificate`` is the number of pixels.
    """
    plan = make_plan(scenario)
    tables, sample = tables_of(plan), PixelSample(plan)
    drawn = [frame for frame in range(plan.frame_times_s.size) if sample.of_frame(frame) is not None]
    for _ in stream(plan, tables, sample, drawn):
        pass
    return rounds.time(prefix + CERTIFICATE, lambda: certify(plan, tables, sample.frames))


def _time_frames(rounds: Rounds, prefix: str, plan: Plan, tables: RadianceTables) -> Frame:
    """Make all frames; what is not spent on clouds counts as look-up. Returns the last frame."""
    clock, frame = Clock(), Frame()
    start = time.perf_counter()
    for each in stream(with_timed_clouds(plan, clock), tables):
        frame = each
    whole = time.perf_counter() - start
    rounds.add(prefix + CLOUDS, clock.seconds)
    rounds.add(prefix + LOOK_UP, whole - clock.seconds)
    return frame


def _write(plan: Plan, tables: RadianceTables, frame: Frame, output: Path) -> None:
    compression = plan.scenario.output.compression or None
    with CubeWriter(output, cube_header(plan, tables), compression=compression) as writer:
        for index in range(plan.frame_times_s.size):
            writer.write_frame(index, frame)
