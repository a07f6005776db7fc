"""The command ``hcss export``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from hcss_export.file_names import SUFFIXES, unknown_format
from hcss_twin.cli.options import Existing, Number, Output, Shared

LISTED = 8
"""Maximum number of files listed on screen; the rest are counted."""


class _Format(click.Choice):  # type: ignore[type-arg]  # click 8.1 has no type argument
    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Name the closest format, which click does not."""
        if value not in SUFFIXES:
            self.fail(unknown_format(str(value)), param, ctx)
        return super().convert(value, param, ctx)


@click.command("export")
@click.argument("cube", type=Existing())
@click.option("--to", required=True, type=_Format(list(SUFFIXES)), help="Format.")
@click.option("-o", "--output", type=Output(), help="Name or folder; default: CUBE_VARIABLE beside CUBE.")
@click.option("--variable", help="Variable to write; default: radiance, or the only image.")
@click.option("--band", "bands", multiple=True, help="Name of a band; repeat. Default: all.")
@click.option("--frame", "frames", multiple=True, type=click.IntRange(min=0), help="Number of a frame; repeat.")
@click.option("--limits", nargs=2, type=Number(), metavar="LOW HIGH", help="png: values of black and white.")
@Shared.force
@Shared.json
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
    from hcss_export.cube_export import export_cube

    done = export_cube(cube, to, output, variable=variable, bands=bands, frames=frames, limits=limits, replace=force)
    if as_json:
        Shared.write_json({**asdict(done), "files": [str(path) for path in done.files]})
        return
    for path in done.files[:LISTED]:
        click.echo(str(path))
    if len(done.files) > LISTED:
        click.echo(f"... and {len(done.files) - LISTED} more, the last {done.files[-1]}")
    size = f"{done.frames} x {done.planes} x {done.rows} x {done.columns}"
    click.echo(f"  {done.variable}: {size} values (frames, bands or layers, rows, columns)")
    if done.missing:
        click.echo(f"  {done.missing} of them are missing: {'sample 0' if to == 'png' else 'NaN'}")
