"""``hcss volume``: the cloud of a cube in three dimensions."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command()
@click.argument("cube", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--frame", default=0, show_default=True, type=click.IntRange(min=0), help="Number of the frame."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Picture; default: CUBE_volume.png.",
)
@click.option(
    "--occupancy",
    "occupancy_file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Also write the filled share of every voxel (.nc).",
)
@click.option(
    "--step-m",
    default=50.0,
    show_default=True,
    type=click.FloatRange(min=0, min_open=True),
    help="Height of a voxel in m.",
)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.option("--force", is_flag=True, help="Replace existing files.")
def volume(
    cube: Path,
    frame: int,
    output: Path | None,
    occupancy_file: Path | None,
    step_m: float,
    as_json: bool,
    force: bool,
) -> None:
    """Draw the cloud of CUBE in three dimensions; the cube must hold the truth layers."""
    output = output or cube.with_name(f"{cube.stem}_volume.png")
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    if occupancy_file is not None and occupancy_file.exists() and not force:
        raise click.ClickException(f"{occupancy_file} exists; give another name with --occupancy, or --force")
    from hcss_twin.reporting.cloud_columns import read_columns
    from hcss_twin.reporting.cloud_volume import draw_volume
    from hcss_twin.reporting.occupancy_file import write_occupancy

    columns = read_columns(cube, frame)
    picture = draw_volume(columns, output)
    voxels = None if occupancy_file is None else write_occupancy(columns, occupancy_file, step_m)
    if as_json:
        named = None if occupancy_file is None else str(occupancy_file)
        click.echo(json.dumps({"picture": str(picture), "occupancy": named, "voxels": voxels}))
        return
    click.echo(str(picture))
    if occupancy_file is not None and voxels is not None:
        size = f"{occupancy_file.stat().st_size / 1e6:.1f} MB"
        click.echo(f"{occupancy_file}  {voxels[0]} x {voxels[1]} x {voxels[2]} voxels, {size}")
