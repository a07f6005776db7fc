"""``hcss doctor``: what a run depends on, on this machine, and the time of a small scene."""

from __future__ import annotations

import os
import platform
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.options import Announcement, Shared, Stop

SMALL = {"image.rows": 64, "image.columns": 64, "frames.count": 1, "bands": ["lwir-10.8"]}
"""Changes of the scenario of README, which make a scene of seconds."""


_LABEL = 13


@click.command()
@Shared.json
@click.pass_context
def doctor(context: click.Context, as_json: bool) -> None:
    """Show versions, plugins, cache, kernels and processors, and time a small scene.

    Include what it prints in reports of problems. The small scene is also what predictions of `hcss plan` learn from.
    """
    from hcss_twin.reports.tables import Table

    facts = dict[str, str]()
    for label, text in _facts(context):
        facts[label] = text
        if not as_json:
            click.echo(Table.labelled(label, text, _LABEL))
    if as_json:
        Shared.write_json(facts)


def _facts(context: click.Context) -> Iterator[tuple[str, str]]:
    from hcss_twin.core.cache import cache_root, in_use, limit_bytes
    from hcss_twin.core.environment import versions
    from hcss_twin.core.kernels import kernels_folder
    from hcss_twin.core.memory import available
    from hcss_twin.providers.registry.registry import Registry

    loaded = versions()
    yield "hcss_twin", f"{loaded.pop('hcss-twin')}, in {Path(__file__).parents[1]}"
    yield "system", f"Python {loaded.pop('python')}, {platform.platform()}"
    yield "libraries", ", ".join(f"{name} {version}" for name, version in loaded.items())
    registry = Registry.discover()
    packages = {entry.distribution: entry.version for entry in registry.entries() if not entry.is_own}
    commands, broken, _ = getattr(context.find_root().command, "plugin_commands", lambda: ({}, [], []))()
    packages |= {command.origin.distribution: command.origin.version for command in commands.values()}
    yield "plugins", ", ".join(f"{name} {version}" for name, version in sorted(packages.items())) or "none"
    if unusable := [*registry.broken, *broken]:
        yield "broken", "; ".join(map(str, unusable))
    root = cache_root()
    usable = "not used" if in_use(root) is None else f"at most {limit_bytes() / 1e6:g} MB of each kind"
    yield "cache", f"{root or 'no folder'}, {usable}; hcss cache shows what is in it"
    folder = kernels_folder()
    yield "kernels", f"compiled once into {folder}" if folder else "compiled by each process: set NUMBA_CACHE_DIR"
    usable_processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield "processors", f"{usable_processors} of {os.cpu_count()}; a run uses one, or as many as --workers says"
    if there := "; ".join(available()):
        yield "memory", there
    yield "small scene", _small_scene(context.ensure_object(Stop))


def _small_scene(stop: Stop) -> str:
    """Compute a small scene and say what it took."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.core.stages import StageTimes, watched
    from hcss_twin.engine.predicted_time import learn, predict
    from hcss_twin.engine.simulate import run
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.scenario.scenario import Scenario

    compiled = Announcement()
    found: list[Any] = []
    times = StageTimes()

    def shown(frames: Iterable[Any], _: int) -> Iterator[Any]:
        for frame in frames:
            stop.check()
            yield frame

    with announce_compilation(compiled), watched(times), tempfile.TemporaryDirectory(prefix="hcss-twin-") as folder:
        plan = make_plan(Scenario.load("trade-cumulus", SMALL))
        prediction = predict(plan)
        run(plan, Path(folder) / "small.nc", shown, found.append)
    if not compiled.made:
        learn(plan, prediction.is_kept, stop.comparable(times))
    parts = ", ".join(f"{name} {seconds:.2g}" for name, seconds in times.seconds.items())
    with_kernels = ", with the compilation of kernels: run again to see without" if compiled.made else ""
    return f"{sum(times.seconds.values()):.1f} s of processor time ({parts}){with_kernels}; {found[0].verdict}"
