"""A command that says how many clear pixels a cube has."""

import json
from pathlib import Path

import click


@click.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def command(cube: Path, as_json: bool) -> None:
    """Count the clear pixels of CUBE, frame by frame."""
    import xarray  # what takes long to import is imported when the command runs

    with xarray.open_dataset(cube) as dataset:
        if "cloud_mask" not in dataset:
            raise click.ClickException(f"{cube} has no cloud_mask; request it in output.variables")
        clear = [int(number) for number in (dataset["cloud_mask"] == 0).sum(("y", "x")).to_numpy()]
    click.echo(json.dumps({"clear": clear}) if as_json else "\n".join(map(str, clear)))
