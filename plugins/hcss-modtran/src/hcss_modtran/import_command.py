"""``hcss atmosphere import``: output of other radiative-transfer codes becomes a table for the provider ``table``."""

from __future__ import annotations

from pathlib import Path

import click

from hcss_twin.cli.options import Existing, Number, Output, Shared


@click.command("import")
@click.argument("files", nargs=-1, required=True, type=Existing(dir_okay=False))
@click.option("-o", "--output", required=True, type=Output(dir_okay=False), help="Table to write (.nc).")
@click.option(
    "--format",
    "file_format",
    default="auto",
    type=click.Choice(["auto", "modtran-tape7", "modtran6-json", "modtran6-csv", "libradtran"]),
    help="Format of FILES.",
)
@click.option("--profile", help="Atmosphere of the runs: catalog name or CSV file.")
@click.option("--resolution", type=Number(min=0), help="Spectral resolution, cm-1.")
@click.option(
    "--geometry",
    multiple=True,
    metavar="[FILE=]H1,H2,ANGLE",
    help="Line of sight in km, km, deg where a file does not contain it; above 90 deg the observer looks down.",
)
@click.option("--output-user", help="uvspec: the output_user line, for example 'lambda edir uu'.")
@click.option("--setting", multiple=True, metavar="LINE", help="uvspec: a line of its input, for example 'sza 20'.")
@click.option("--title", help="Title of the table.")
@Shared.force
@Shared.json
def atmosphere_import(
    files: tuple[Path, ...],
    output: Path,
    file_format: str,
    profile: str | None,
    resolution: float | None,
    geometry: tuple[str, ...],
    output_user: str | None,
    setting: tuple[str, ...],
    title: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Combine FILES of MODTRAN or libRadtran into one atmosphere table."""
    from hcss_modtran.importing import ReadOptions, import_files, parse_geometry

    Output.require_writable([output], force, form="NetCDF")
    try:
        sights = dict(parse_geometry(text) for text in geometry)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--geometry") from error
    settings = (*setting, f"output_user {output_user}") if output_user else setting
    options = ReadOptions(file_format, sights, settings)
    checks = import_files(files, output, options, profile=profile, resolution_cm1=resolution, title=title)
    if as_json:
        Shared.write_json({"table": str(output), "bytes": output.stat().st_size, "checks": checks})
    else:
        click.echo("\n".join([*(f"  {line}" for line in checks), f"{output}  {output.stat().st_size / 1e6:.1f} MB"]))
