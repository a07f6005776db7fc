"""``hcss dataset``: labelled frames with targets."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from hcss_twin.cli.options import Shared, Stop

_FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command("dataset")
@click.argument("distribution", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=_FOLDER, help="Folder; default: the name of the file. Missing shards are made.")
@click.option("--frames", default=100, show_default=True, type=click.IntRange(min=1), help="Of the whole set.")
@click.option("--workers", default=1, type=click.IntRange(min=1), help="Processes on this machine.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute, tcp://HOST:PORT.")
@click.option("--shard", type=click.IntRange(min=0), help="Make only this shard, for example one of a job array.")
@click.option("--show", type=click.IntRange(min=0), metavar="DRAW", help="Print the scenario of a draw, for hcss run.")
@Shared.json
@click.pass_context
def dataset_command(
    context: click.Context,
    distribution: Path,
    output: Path | None,
    frames: int,
    workers: int,
    scheduler: str | None,
    shard: int | None,
    show: int | None,
    as_json: bool,
) -> None:
    """Make a set of labelled frames with small targets from the file DISTRIBUTION.

    Whole shards are not made again; any shard has the same bytes wherever it is made.
    """
    if scheduler is not None and workers != 1:
        raise click.UsageError("--workers with --scheduler, which has its own; allowed: one of the two")
    from hcss_dataset.distribution import Distribution
    from hcss_dataset.make import make_dataset
    from hcss_dataset.rendering import Studio
    from hcss_twin.core.environment import announce_compilation

    with announce_compilation(partial(click.echo, err=True)):
        if show is not None:
            click.echo(Studio(Distribution.load(distribution)).sequence(show).scenario.to_json())
            return
        made = make_dataset(
            distribution,
            output or Path(distribution.stem),
            frames,
            workers,
            shard,
            scheduler,
            partial(context.ensure_object(Stop).progress, label="shards"),
        )
    if as_json:
        Shared.write_json(made.as_dict())
        return
    rate = f", {made.frames / made.seconds:.1f} frames/s" if made.frames else ""
    click.echo(f"{made.folder}  {made.frames} frames{rate}, {made.processor_s:.1f} s of processor time")
    if made.missing:
        click.echo(f"  {made.missing} shards are missing; the same command makes them")
    elif made.refused:
        click.echo(f"  {made.refused} unphysical draws were drawn again")
