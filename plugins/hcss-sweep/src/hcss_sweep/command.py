"""``hcss sweep``: many scenes."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hcss_sweep.sensors import SENSORS
from hcss_twin.cli.options import Output, Shared, Stop

_FOLDER = click.Path(file_okay=False, path_type=Path)

if TYPE_CHECKING:
    from hcss_sweep.run import SweepResult

EXIT_FAILED = 1

LISTED = 20
"""Most cubes of sensors that are named; the index has all."""


@click.command("sweep")
@click.argument("sweep")
@Shared.changes
@click.option(
    "--over", "swept", multiple=True, metavar="KEY=VALUES", help="Sweep a key: 'view.zenith=[0, 30]'; repeat."
)
@click.option("-o", "--output", type=_FOLDER, help="Folder; default: SWEEP-sweep. An unfinished sweep continues.")
@click.option("--workers", default=1, type=click.IntRange(min=1), help="Processes on this machine.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute, tcp://HOST:PORT.")
@click.option(
    "--wait-workers",
    type=click.FloatRange(min=0),
    metavar="SECONDS",
    help="With --scheduler: end when it has had no workers for so long; default: wait.",
)
@click.option("--dataset", type=Output(dir_okay=False), help="Also write one file with the swept keys as dimensions.")
@click.option("--force", is_flag=True, help="Delete the results in the folder and start again.")
@Shared.json
@click.pass_context
def sweep_command(
    context: click.Context,
    sweep: str,
    assignments: tuple[str, ...],
    swept: tuple[str, ...],
    output: Path | None,
    workers: int,
    scheduler: str | None,
    wait_workers: float | None,
    dataset: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Simulate all points of SWEEP: a shipped sweep, a scenario, or a TOML file.

    Finished points are not computed again. A point that fails is reported and does not stop the others.
    """
    if scheduler is not None and workers != 1:
        raise click.UsageError("--workers with --scheduler, which has its own; allowed: one of the two")
    if wait_workers is not None and scheduler is None:
        raise click.UsageError("--wait-workers without --scheduler; allowed: with it")
    overrides, over = Shared.assigned(assignments), Shared.assigned(swept, "--over")
    from hcss_sweep.run import sweep as run_sweep
    from hcss_twin.core.environment import announce_compilation

    with announce_compilation(partial(click.echo, err=True)):
        result = run_sweep(
            sweep,
            output or Path(f"{Path(sweep).stem}-sweep"),
            over=over,
            overrides=overrides,
            workers=workers,
            scheduler=scheduler,
            wait_workers_s=wait_workers,
            dataset=dataset,
            force=force,
            progress=partial(context.ensure_object(Stop).progress, label="points"),
        )
    if as_json:
        Shared.write_json(result.as_dict())
    else:
        click.echo(_sweep_text(result))
    if result.failed:
        click.echo(f"error: {len(result.failed)} of {len(result.points)} points failed", err=True)
        sys.exit(EXIT_FAILED)


def _certificates(result: SweepResult) -> list[str]:
    """Return one line about the certificates of all points, with the worst."""
    cubes = [record for record in result.points if record.file is not None]
    checked = [record for record in cubes if record.certified is not None]
    if not checked:
        return ["  no certificate: no pixel was checked"] if cubes else []
    worst = max(checked, key=lambda record: record.certified or 0.0)
    within = sum((record.certified or 0.0) <= 1.0 for record in checked)
    unchecked = f", {len(cubes) - len(checked)} not checked" if len(checked) < len(cubes) else ""
    values = ", ".join(f"{key} = {value}" for key, value in worst.values.items())
    return [
        f"  computed as specified: {within} of {len(cubes)} points{unchecked}; the largest error is "
        f"{worst.certified:.2g} of the accuracy (point {worst.point}, {values})"
    ]


def _sweep_text(result: SweepResult) -> str:
    size = sum(record.bytes or 0 for record in result.points)
    before = len(result.points) - len(result.computed)
    lines = [
        f"{result.folder}  {len(result.points)} points, {size / 1e6:.1f} MB",
        f"  computed {len(result.computed)}" + (f", already computed {before}" if before else ""),
    ]
    lines += _certificates(result)
    named = [record for record in result.points if SENSORS in record.values and record.file is not None]
    lines += [f"  {record.values[SENSORS]}: {result.folder / record.file}" for record in named[:LISTED] if record.file]
    for record in result.failed:
        values = ", ".join(f"{key} = {value}" for key, value in record.values.items())
        lines.append(f"  failed: point {record.point}, {values}: {record.error}")
    return "\n".join(
        [
            *lines,
            *([] if result.dataset is None else [f"{result.dataset}  {result.dataset.stat().st_size / 1e6:.1f} MB"]),
        ]
    )
