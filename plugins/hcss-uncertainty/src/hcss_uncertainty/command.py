"""``hcss propagate``: the spread of radiance due to uncertain inputs."""

from __future__ import annotations

import sys
import warnings
from functools import partial
from pathlib import Path

import click

from hcss_twin.cli.options import Existing, Output, Shared, Stop
from hcss_twin.core.errors import CertificateWarning

EXIT_FAILED = 1


@click.command("propagate")
@Shared.scenario
@Shared.changes
@click.option("--draws", type=int, default=200, help="Number of random draws of the inputs, each with two seeds.")
@click.option("--posterior", type=Existing(dir_okay=False), help="File of `hcss fit` for the cloud parameters.")
@click.option(
    "--uncertain",
    multiple=True,
    metavar="KEY=DISTRIBUTION",
    help="Vary a key, for example sea.temperature=normal:291:0.5; repeat.",
)
@click.option(
    "--shares",
    type=click.Choice(["regression", "pick-freeze"]),
    default="regression",
    help="Method of variance attribution; pick-freeze needs more scenes.",
)
@click.option(
    "--cube-of",
    "cubes_of",
    multiple=True,
    metavar="NUMBERS",
    help="Also write the cubes of these draws, for example 0,17.",
)
@click.option("--maps", is_flag=True, help="Also write mean and standard deviation of each pixel.")
@click.option("--layer", type=int, help="With --posterior: cloud layer it applies to, if there are two.")
@click.option("--workers", default=1, type=click.IntRange(1, 1024), help="Processes; the result is the same.")
@click.option(
    "-o", "--output", type=Output(dir_okay=False), help="File to write, NetCDF; default: NAME.propagation.nc."
)
@Shared.force
@Shared.json
@click.pass_context
def propagate_command(
    context: click.Context,
    /,
    scenario: str,
    assignments: tuple[str, ...],
    draws: int,
    posterior: Path | None,
    uncertain: tuple[str, ...],
    shares: str,
    cubes_of: tuple[str, ...],
    maps: bool,
    layer: int | None,
    workers: int,
    output: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Propagate uncertain inputs of SCENARIO to radiance and to what its sensor measures.

    The inputs are those of --uncertain, of a section [uncertain] in the file, and of a posterior.
    """
    from hcss_twin.core.environment import announce_compilation
    from hcss_uncertainty.propagation import cube_path, propagate
    from hcss_uncertainty.text import propagation_text, propagation_values

    output = output or Path(f"{Path(scenario).stem}.propagation.nc")
    numbers = _numbers(cubes_of)
    Output.require_writable((output, *(cube_path(output, number) for number in numbers)), force, form="NetCDF")
    with announce_compilation(partial(click.echo, err=True)), warnings.catch_warnings():
        warnings.simplefilter("ignore", CertificateWarning)  # reported as an error, with the exit code
        result = propagate(
            scenario,
            output,
            draws=draws,
            posterior=posterior,
            uncertain=Shared.assigned(uncertain, "--uncertain"),
            overrides=Shared.assigned(assignments),
            layer=layer,
            shares=shares,
            cubes_of=numbers,
            maps=maps,
            workers=workers,
            progress=partial(context.ensure_object(Stop).progress, label="draws"),
        )
    if as_json:
        Shared.write_json(propagation_values(result))
    else:
        click.echo(
            "\n".join(
                [propagation_text(result), *(f"{cube}  {cube.stat().st_size / 1e6:.1f} MB" for cube in result.cubes)]
            )
        )
    failed = [certificate for certificate in result.certificates if not certificate.passed]
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
