"""``hcss verify``: whether a cube is what its own provenance makes today."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

import click

from hcss_twin.cli_progress import Stop, progress

EXIT_DIFFERENT = 1


@click.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option(
    "--frames", type=click.IntRange(min=1), help="Check so many frames, spread over the cube; default: all."
)
@click.option(
    "--base",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder from which relative paths of the scenario lead; default: where they led when CUBE was made.",
)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def verify(context: click.Context, cube: Path, frames: int | None, base: Path | None, as_json: bool) -> None:
    """Recompute CUBE from its own provenance and say whether it is the same.

    Nothing kept from earlier runs is used, and nothing is written. Exit code 0: identical to the bit, or equal within
    1e-6; 1: different, or it cannot be recomputed, with the place and what may be why.
    """
    from hcss_twin.compilation_notice import told_of_compilation
    from hcss_twin.reporting.verification_text import verification_text
    from hcss_twin.scene.verification.verify import verify_cube

    if sys.stderr.isatty():
        click.echo("computing the radiance anew ...", err=True)
    with told_of_compilation(partial(click.echo, err=True)):
        found = verify_cube(cube, base, frames, partial(progress, context.ensure_object(Stop)))
    click.echo(json.dumps(found.as_dict()) if as_json else verification_text(found))
    if not found.passed:
        sys.exit(EXIT_DIFFERENT)
