"""``hcss sweep``: many scenes from one file."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.options import Stop, progress, set_option

if TYPE_CHECKING:
    from hcss_twin.sweeps.run import SweepResult


EXIT_FAILED = 1


@click.command("sweep")
@click.argument("sweep")
@set_option
@click.option(
    "--over",
    "swept",
    multiple=True,
    metavar="KEY=VALUES",
    help="Sweep a key as in [sweep], for example 'view.zenith=[0, 30, 60]'; repeat.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the cubes; default: SWEEP-sweep here. One that was begun is gone on with.",
)
@click.option("--workers", default=1, show_default=True, type=click.IntRange(min=1), help="Processes on this machine.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute, tcp://HOST:PORT.")
@click.option(
    "--dataset",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Also write one file with the swept keys as dimensions.",
)
@click.option("--force", is_flag=True, help="Remove what an earlier sweep left in the folder, and start anew.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def sweep_command(
    context: click.Context,
    sweep: str,
    assignments: tuple[str, ...],
    swept: tuple[str, ...],
    output: Path | None,
    workers: int,
    scheduler: str | None,
    dataset: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Compute all points of SWEEP: the name of a shipped sweep or scenario, or a TOML file.

    Points that the folder has are not computed again. One that fails is told, and does not stop the others.
    """
    if scheduler is not None and workers != 1:
        raise click.UsageError("--workers beside --scheduler, which has its own; allowed: one of both")
    overrides = _assigned(assignments, "--set")
    over = _assigned(swept, "--over")
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.sweeps.run import sweep as run_sweep

    with announce_compilation(partial(click.echo, err=True)):
        result = run_sweep(
            sweep,
            output or Path(f"{Path(sweep).stem}-sweep"),
            over=over,
            overrides=overrides,
            workers=workers,
            scheduler=scheduler,
            dataset=dataset,
            force=force,
            progress=partial(_progress, context.ensure_object(Stop)),
        )
    click.echo(json.dumps(result.as_dict()) if as_json else _told(result))
    if result.failed:
        click.echo(f"error: {len(result.failed)} of {len(result.points)} points failed", err=True)
        sys.exit(EXIT_FAILED)


def _assigned(texts: Iterable[str], option: str) -> dict[str, Any]:
    from hcss_twin.scenario.overrides import parse_assignment

    try:
        return dict(parse_assignment(text) for text in texts)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint=option) from error


def _progress(stop: Stop, points: Iterable[Any], count: int) -> Iterable[Any]:
    return progress(stop, points, count, "points")


def _told(result: SweepResult) -> str:
    size = sum(record.bytes or 0 for record in result.points)
    before = len(result.points) - len(result.computed)
    lines = [
        f"{result.folder}  {len(result.points)} points, {size / 1e6:.1f} MB",
        f"  computed {len(result.computed)}" + (f", had before {before}" if before else ""),
    ]
    lines += [f"  failed: point {record.point}, {_values(record.values)}: {record.error}" for record in result.failed]
    if result.dataset is not None:
        lines.append(f"{result.dataset}  {result.dataset.stat().st_size / 1e6:.1f} MB")
    return "\n".join(lines)


def _values(values: Any) -> str:
    return ", ".join(f"{key} = {value}" for key, value in values.items())
