"""``hcss sense``: what a sensor measures of a cube."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.options import Stop, progress


def measured_beside(clean: Path, scenario: Any, force: bool) -> Path | None:
    """Return the measured cube that a run of a scenario writes beside its clean one, if it does.

    Raises
    ------
    click.ClickException
        If it is there already and may not be replaced.
    """
    if scenario.sensor is None:
        return None
    from hcss_twin.engine.sense import measured_path

    path = measured_path(clean)
    if path.exists() and not force:
        raise click.ClickException(f"{path} exists; give another name with -o, or --force")
    return path


@click.command()
@click.argument("cube", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--sensor", "name", required=True, metavar="NAME|FILE", help="A sensor of the catalog, or a TOML file.")
@click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="KEY=VALUE",
    help="A key of [sensor], for example variables='[\"all\"]' or parameters.psf_sigma=0.8.",
)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Cube to write; default: NAME.sensor.nc.")
@click.option("--force", is_flag=True, help="Replace an existing cube.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def sense(
    context: click.Context,
    cube: Path,
    name: str,
    assignments: tuple[str, ...],
    output: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Write what a sensor measures of CUBE, a clean one, with the same truth layers."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.cube.reader import open_cube
    from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
    from hcss_twin.engine.sense import measured_path, section_of, sense_file

    output = output or measured_path(cube)
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    # A file's name leads from where the user works, not from where the cube was made.
    named = str(Path(name).resolve()) if Path(name).is_file() else name
    section = section_of({"name": named, **_changes(assignments)})
    with announce_compilation(partial(click.echo, err=True)):
        sense_file(cube, section, output, progress=partial(progress, context.ensure_object(Stop)))
    with open_cube(output) as made:
        about = json.loads(made.attrs[SENSOR_ATTRIBUTE])
        variables = [str(each) for each in made.data_vars]
    if as_json:
        click.echo(json.dumps({"cube": str(output), "variables": variables, "sensor": about}))
        return
    click.echo(f"{output}  {output.stat().st_size / 1e6:.1f} MB: {about['title']}")
    click.echo(f"  variables   {', '.join(variables)}")
    for note in about["notes"]:
        click.echo(f"  note        {note}")


def _changes(assignments: tuple[str, ...]) -> dict[str, Any]:
    from hcss_twin.scenario.overrides import parse_assignment

    changes: dict[str, Any] = {}
    for text in assignments:
        try:
            key, value = parse_assignment(text)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--set") from error
        *path, last = key.split(".")
        table = changes
        for part in path:
            table = table.setdefault(part, {})
            if not isinstance(table, dict):
                raise click.BadParameter(f"{key}: '{part}' is no table", param_hint="--set")
        table[last] = value
    return changes
