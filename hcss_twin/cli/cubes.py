"""``hcss export``: a cube in the format of another program.

``hcss report``: one HTML file about a cube, a sweep, a posterior or a propagation.

``hcss verify``: whether a cube is what its own provenance makes today.

``hcss volume``: the cloud of a cube in three dimensions.

``hcss cache``: what is kept between runs.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path

import click

from hcss_twin.cli.options import Stop, progress

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
    from hcss_twin.cube.export.cube_export import export_cube

    done = export_cube(cube, to, output, variable=variable, bands=bands, frames=frames, limits=limits, replace=force)
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


@click.command("report")
@click.argument("source", metavar="CUBE|SWEEP|POSTERIOR|PROPAGATION", type=click.Path(exists=True, path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write; default: its name with .html, beside it.",
)
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def report_command(source: Path, output: Path | None, force: bool, as_json: bool) -> None:
    """Write one HTML file about a cube, a sweep (its folder or dataset), a posterior or a propagation.

    It needs no network and no other files, fits a phone, and can be printed.
    """
    from hcss_twin.report.report import report

    written = report(source, output, replace=force)
    size = written.stat().st_size
    click.echo(json.dumps({"report": str(written), "bytes": size}) if as_json else f"{written}  {size / 1e6:.1f} MB")


EXIT_DIFFERENT = 1


@click.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option("--frames", type=click.IntRange(min=1), help="Check so many frames, spread over the cube; default: all.")
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
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.engine.verification import verify_cube
    from hcss_twin.report.verification_text import verification_text

    if sys.stderr.isatty():
        click.echo("computing the radiance anew ...", err=True)
    with announce_compilation(partial(click.echo, err=True)):
        found = verify_cube(cube, base, frames, partial(progress, context.ensure_object(Stop)))
    click.echo(json.dumps(found.as_dict()) if as_json else verification_text(found))
    if not found.passed:
        sys.exit(EXIT_DIFFERENT)


@click.command()
@click.argument("cube", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--frame", default=0, show_default=True, type=click.IntRange(min=0), help="Number of the frame.")
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Picture; default: CUBE_volume.png."
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
    cube: Path, frame: int, output: Path | None, occupancy_file: Path | None, step_m: float, as_json: bool, force: bool
) -> None:
    """Draw the cloud of CUBE in three dimensions; the cube must hold the truth layers."""
    output = output or cube.with_name(f"{cube.stem}_volume.png")
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    if occupancy_file is not None and occupancy_file.exists() and not force:
        raise click.ClickException(f"{occupancy_file} exists; give another name with --occupancy, or --force")
    from hcss_twin.report.cloud_columns import read_columns
    from hcss_twin.report.cloud_volume import draw_volume
    from hcss_twin.report.occupancy_file import write_occupancy

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


KINDS = {"tables": ".npz", "plans": ".npz", "references": ".npz", "optics": ".nc"}
"""As in core.cache, which imports numpy: the command line answers without it."""


@click.group(invoke_without_command=True)
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
@click.pass_context
def cache(context: click.Context, as_json: bool) -> None:
    """Say what is kept between runs, where, and how large it is.

    Compiled tables of scenes and computed cloud optics come out the same in every run, so that they are kept in
    HCSS_CACHE_DIR, or in the user's cache folder. HCSS_CACHE_MB limits the tables (1000 MB; 0 keeps none).
    """
    if context.invoked_subcommand is not None:
        return
    from hcss_twin.core.cache import Store, cache_root, limit_bytes

    root, limit = cache_root(), limit_bytes()
    found = {kind: Store(kind, suffix).kept() for kind, suffix in KINDS.items()}
    if as_json:
        sizes = {
            kind: {"files": len(files), "bytes": sum(each.size for each in files)} for kind, files in found.items()
        }
        click.echo(json.dumps({"folder": None if root is None else str(root), "limit_bytes": limit, "kinds": sizes}))
        return
    click.echo(f"{'no folder to keep anything in' if root is None else root}")
    for kind, files in found.items():
        most = f" of at most {limit / 1e6:g} MB" if kind == "tables" else ""
        click.echo(f"  {kind:<11}{len(files):5} files {sum(each.size for each in files) / 1e6:9.2f} MB{most}")


@cache.command()
@click.argument("kinds", nargs=-1, type=click.Choice(sorted(KINDS)))
def clear(kinds: tuple[str, ...]) -> None:
    """Remove what is kept: all of it, or the KINDS named."""
    from hcss_twin.core.cache import Store

    for kind in kinds or KINDS:
        removed = Store(kind, KINDS[kind]).clear()
        click.echo(f"{kind}: {len(removed)} files removed, {sum(each.size for each in removed) / 1e6:.1f} MB")
