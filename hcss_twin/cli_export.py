"""``hcss export``: a cube in the format of another program."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

FORMATS = ("fits", "envi", "geotiff", "png")
LISTED = 8
"""Files that are named on screen; more are counted."""


@click.command("export")
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option("--to", required=True, type=click.Choice(FORMATS), help="Format.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Name or folder; default: CUBE_VARIABLE beside CUBE. Several files get bands and numbers in their names.",
)
@click.option("--variable", help="What to write; default: radiance, or the only image there is.")
@click.option("--band", "bands", multiple=True, help="Name of a band; can be given again. Default: all.")
@click.option(
    "--frame",
    "frames",
    multiple=True,
    type=click.IntRange(min=0),
    help="Number of a frame; can be given again. Default: all.",
)
@click.option(
    "--limits",
    nargs=2,
    type=float,
    metavar="LOW HIGH",
    help="png: values of black and white; default: those of each band.",
)
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def export_command(
    cube: Path,
    to: str,
    output: Path | None,
    variable: str | None,
    bands: tuple[str, ...],
    frames: tuple[int, ...],
    limits: tuple[float, float] | None,
    force: bool,
    as_json: bool,
) -> None:
    """Write a variable of CUBE as FITS, ENVI, GeoTIFF or 16-bit PNG."""
    from hcss_twin.export.cube_export import export_cube

    done = export_cube(
        cube,
        to,
        output,
        variable=variable,
        bands=bands,
        frames=frames,
        limits=limits,
        replace=force,
    )
    if as_json:
        click.echo(json.dumps({**asdict(done), "files": [str(path) for path in done.files]}))
        return
    for path in done.files[:LISTED]:
        click.echo(str(path))
    if len(done.files) > LISTED:
        click.echo(f"... and {len(done.files) - LISTED} more, the last {done.files[-1]}")
    size = f"{done.frames} x {done.planes} x {done.rows} x {done.columns}"
    click.echo(f"  {done.variable}: {size} values (frames, bands or layers, rows, columns)")
    if done.missing:
        how = "sample 0" if to == "png" else "NaN"
        click.echo(f"  {done.missing} of them do not exist: {how}")
