"""Commands that compute many scenes: ``hcss sweep``, and ``hcss run --draws``, which propagates uncertainty."""

from __future__ import annotations

import json
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.options import (
    EXISTING_FILE,
    FOLDER,
    NEW_FILE,
    Stop,
    assigned,
    json_option,
    progress,
    require_writable,
    set_option,
    with_size,
)
from hcss_twin.core.errors import CertificateWarning

if TYPE_CHECKING:
    from hcss_twin.sweeps.run import SweepResult

EXIT_FAILED = 1


@click.command("sweep")
@click.argument("sweep")
@set_option
@click.option(
    "--over", "swept", multiple=True, metavar="KEY=VALUES", help="Sweep a key: 'view.zenith=[0, 30]'; repeat."
)
@click.option("-o", "--output", type=FOLDER, help="Folder; default: SWEEP-sweep. An unfinished sweep continues.")
@click.option("--workers", default=1, type=click.IntRange(min=1), help="Processes on this machine.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute, tcp://HOST:PORT.")
@click.option(
    "--wait-workers",
    type=click.FloatRange(min=0),
    metavar="SECONDS",
    help="With --scheduler: end when it has had no workers for so long; default: wait.",
)
@click.option("--dataset", type=NEW_FILE, help="Also write one file with the swept keys as dimensions.")
@click.option("--force", is_flag=True, help="Delete the results in the folder and start again.")
@json_option
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
    overrides, over = assigned(assignments), assigned(swept, "--over")
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
            wait_workers_s=wait_workers,
            dataset=dataset,
            force=force,
            progress=partial(progress, context.ensure_object(Stop), label="points"),
        )
    click.echo(json.dumps(result.as_dict()) if as_json else _sweep_text(result))
    if result.failed:
        click.echo(f"error: {len(result.failed)} of {len(result.points)} points failed", err=True)
        sys.exit(EXIT_FAILED)


def _sweep_text(result: SweepResult) -> str:
    size = sum(record.bytes or 0 for record in result.points)
    before = len(result.points) - len(result.computed)
    lines = [
        f"{result.folder}  {len(result.points)} points, {size / 1e6:.1f} MB",
        f"  computed {len(result.computed)}" + (f", already computed {before}" if before else ""),
    ]
    for record in result.failed:
        values = ", ".join(f"{key} = {value}" for key, value in record.values.items())
        lines.append(f"  failed: point {record.point}, {values}: {record.error}")
    return "\n".join([*lines, *([] if result.dataset is None else [with_size(result.dataset)])])


_DRAW_OPTIONS = (
    click.option("--draws", type=int, help="Propagate uncertain inputs: number of random draws, each with two seeds."),
    click.option("--posterior", type=EXISTING_FILE, help="With --draws: file of `hcss fit` for the cloud parameters."),
    click.option(
        "--uncertain",
        multiple=True,
        metavar="KEY=DISTRIBUTION",
        help="With --draws: vary a key, for example sea.temperature=normal:291:0.5; repeat.",
    ),
    click.option(
        "--shares",
        type=click.Choice(["regression", "pick-freeze"]),
        default="regression",
        help="With --draws: method of variance attribution; pick-freeze needs more scenes.",
    ),
    click.option(
        "--cube-of",
        "cubes_of",
        multiple=True,
        metavar="NUMBERS",
        help="With --draws: also write the cubes of these draws, for example 0,17.",
    ),
    click.option("--maps", is_flag=True, help="With --draws: also write mean and standard deviation of each pixel."),
    click.option("--layer", type=int, help="With --posterior: cloud layer it applies to, if there are two."),
)


def propagation_options(command: Any) -> Any:
    """Add the options of a propagation."""
    for option in reversed(_DRAW_OPTIONS):
        command = option(command)
    return command


def is_propagation(given: dict[str, Any]) -> bool:
    """Return whether the options request a propagation; raises UsageError if an option requires ``--draws``."""
    if given["draws"] is not None:
        return True
    names = {"posterior": "--posterior", "uncertain": "--uncertain", "cubes_of": "--cube-of", "layer": "--layer"}
    names |= {"maps": "--maps"}
    needy = [option for name, option in names.items() if given[name] not in (None, (), False)]
    needy += ["--shares"] if given["shares"] != "regression" else []
    if needy:
        raise click.UsageError(f"{needy[0]} needs the number of draws: --draws N, for example 200")
    return False


def run_propagation(
    context: click.Context,
    scenario: str,
    assignments: tuple[str, ...],
    output: Path | None,
    force: bool,
    as_json: bool,
    given: dict[str, Any],
) -> None:
    """Propagate uncertain inputs and print the result."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.reports.propagation_text import propagation_text, propagation_values
    from hcss_twin.sweeps.propagation.propagate import cube_path, propagate

    output = output or Path(f"{Path(scenario).stem}.propagation.nc")
    numbers = _numbers(given["cubes_of"])
    require_writable((output, *(cube_path(output, number) for number in numbers)), force, form="NetCDF")
    with announce_compilation(partial(click.echo, err=True)), warnings.catch_warnings():
        warnings.simplefilter("ignore", CertificateWarning)  # reported as an error, with the exit code
        result = propagate(
            scenario,
            output,
            draws=given["draws"],
            posterior=given["posterior"],
            uncertain=assigned(given["uncertain"], "--uncertain"),
            overrides=assigned(assignments),
            layer=given["layer"],
            shares=given["shares"],
            cubes_of=numbers,
            maps=given["maps"],
            workers=given["workers"],
            progress=partial(progress, context.ensure_object(Stop), label="draws"),
        )
    if as_json:
        click.echo(json.dumps(propagation_values(result)))
    else:
        click.echo("\n".join([propagation_text(result), *map(with_size, result.cubes)]))
    failed = [each for each in result.certificates if not each.passed]
    for certificate in failed:
        click.echo(f"error: certificate {certificate.lines[0]}", err=True)
    if failed:
        sys.exit(EXIT_FAILED)


def _numbers(texts: tuple[str, ...]) -> list[int]:
    parts = [part for text in texts for part in text.replace(",", " ").split()]
    for part in parts:
        if not part.isdecimal():
            raise click.BadParameter(f"'{part}': allowed: numbers of draws, for example 0,17", param_hint="--cube-of")
    return list(dict.fromkeys(map(int, parts)))
