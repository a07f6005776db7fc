"""Commands on a cube: ``hcss report``, ``sense``, ``verify`` and ``volume``; and ``hcss cache``."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.options import Existing, Number, Output, Shared, Stop, with_size

EXIT_DIFFERENT = 1
POSITIVE = Number(min=0, min_open=True)

KINDS = {"tables": ".npz", "plans": ".npz", "references": ".npz", "optics": ".nc"}
"""Cache folders and file suffixes; a copy of those in ``core.cache``, which imports numpy. A test compares them."""


@click.command("report")
@click.argument("source", metavar="CUBE|SWEEP|POSTERIOR|PROPAGATION", type=Existing())
@click.option(
    "-o", "--output", type=Output(dir_okay=False), help="Page to write; default: NAME.html beside the source."
)
@click.option(
    "--evidence",
    is_flag=True,
    help="Of a cube: comparisons of its models with references; default page: NAME.evidence.html.",
)
@Shared.force
@Shared.json
def report_command(source: Path, output: Path | None, evidence: bool, force: bool, as_json: bool) -> None:
    """Write one HTML page about a cube, a sweep (folder or dataset), a posterior or a propagation.

    The page needs no other files and no network.
    """
    from hcss_twin.reports.report import report

    page = report(source, output, replace=force, evidence=evidence)
    if as_json:
        answer: dict[str, Any] = {"report": str(page), "bytes": page.stat().st_size}
        if evidence:
            from hcss_twin.reports.evidence import Evidence

            answer["evidence"] = Evidence.of(source).as_dict()
        Shared.write_json(answer)
    else:
        click.echo(with_size(page))


@click.command()
@click.argument("cube", type=Existing())
@click.option("--sensor", "name", required=True, metavar="NAME|FILE", help="Sensor of the catalog, or a TOML file.")
@click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of [sensor], for example parameters.psf_sigma=0.8; repeat.",
)
@click.option("-o", "--output", type=Output(dir_okay=False), help="Cube to write; default: NAME.sensor.nc.")
@Shared.force
@Shared.json
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
    """Apply a sensor to CUBE and write the measured cube, with the same truth layers."""
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.cube.reader import open_cube
    from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
    from hcss_twin.engine.sense import measured_path, section_of, sense_file

    output = output or measured_path(cube)
    Output.require_writable([output], force, form="NetCDF")
    # A file name is relative to the working folder, not to the folder of the cube.
    named = str(Path(name).resolve()) if Path(name).is_file() else name
    section = section_of({"name": named, **_nested(Shared.assigned(assignments))})
    with announce_compilation(partial(click.echo, err=True)):
        sense_file(cube, section, output, progress=partial(context.ensure_object(Stop).progress))
    with open_cube(output) as measured:
        about = json.loads(measured.attrs[SENSOR_ATTRIBUTE])
        variables = [str(data_var) for data_var in measured.data_vars]
    if as_json:
        Shared.write_json({"cube": str(output), "variables": variables, "sensor": about})
        return
    click.echo(f"{with_size(output)}: {about['title']}")
    click.echo(f"  variables   {', '.join(variables)}")
    for note in about["notes"]:
        click.echo(f"  note        {note}")


def measured_beside(clean: Path, scenario: Any, force: bool) -> Path | None:
    """Return the path of the measured cube that a run also writes, or None; rejects an existing file."""
    if scenario.sensor is None:
        return None
    from hcss_twin.engine.sense import measured_path

    path = measured_path(clean)
    Output.require_writable([path], force, form="NetCDF")
    return path


def _nested(assignments: dict[str, Any]) -> dict[str, Any]:
    """Return dotted keys as nested tables."""
    root: dict[str, Any] = {}
    for key, value in assignments.items():
        *path, last = key.split(".")
        table = root
        for part in path:
            table = table.setdefault(part, {})
            if not isinstance(table, dict):
                raise click.BadParameter(f"{key}: '{part}' is not a table", param_hint="--set")
        table[last] = value
    return root


@click.command()
@click.argument("cube", type=Existing())
@click.option("--frames", type=click.IntRange(min=1), help="Number of frames to check, spread evenly; default: all.")
@click.option(
    "--base", type=Existing(file_okay=False), help="Base folder of relative scenario paths; default: as recorded."
)
@click.option("--data", multiple=True, type=Existing(), help="File or folder outside CUBE's that may be read; repeat.")
@Shared.json
@click.pass_context
def verify(
    context: click.Context, cube: Path, frames: int | None, base: Path | None, data: tuple[Path, ...], as_json: bool
) -> None:
    """Recompute CUBE from its provenance, all afresh without the cache, and compare.

    Exit code 0: identical bits, or equal within 1e-6. 1: different (where, and the likely cause), or not computable.
    """
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.engine.verification import verify_cube
    from hcss_twin.reports.verification_text import verification_text

    if sys.stderr.isatty():
        click.echo("recomputing the radiance ...", err=True)
    with announce_compilation(partial(click.echo, err=True)):
        result = verify_cube(cube, base, frames, partial(context.ensure_object(Stop).progress), data)
    if as_json:
        Shared.write_json(result.as_dict())
    else:
        click.echo(verification_text(result))
    if not result.passed:
        sys.exit(EXIT_DIFFERENT)


@click.command()
@click.argument("cube", type=Existing())
@click.option("--frame", default=0, type=click.IntRange(min=0), help="Number of the frame.")
@click.option("-o", "--output", type=Output(dir_okay=False), help="Picture; default: CUBE_volume.png.")
@click.option("--occupancy", type=Output(dir_okay=False), help="Also write the cloudy fraction of every voxel (.nc).")
@click.option("--step-m", default=50.0, type=POSITIVE, help="Voxel height, m.")
@Shared.json
@Shared.force
def volume(
    cube: Path, frame: int, output: Path | None, occupancy: Path | None, step_m: float, as_json: bool, force: bool
) -> None:
    """Draw the clouds of CUBE in three dimensions; the cube must have truth layers."""
    output = output or cube.with_name(f"{cube.stem}_volume.png")
    Output.require_different({"-o": output, "--occupancy": occupancy})
    Output.require_writable([output], force, form="picture")
    Output.require_writable([occupancy], force, "give another name with --occupancy", form="NetCDF")
    from hcss_twin.reports.cloud_columns import read_columns, write_occupancy
    from hcss_twin.reports.cloud_volume import draw_volume

    columns = read_columns(cube, frame)
    voxels = None if occupancy is None else write_occupancy(columns, occupancy, step_m)
    picture = draw_volume(columns, output)
    if as_json:
        named = None if occupancy is None else str(occupancy)
        Shared.write_json({"picture": str(picture), "occupancy": named, "voxels": voxels})
        return
    click.echo(str(picture))
    if occupancy is not None and voxels is not None:
        name, size = with_size(occupancy).rsplit("  ", 1)
        click.echo(f"{name}  {voxels[0]} x {voxels[1]} x {voxels[2]} voxels, {size}")


@click.group(invoke_without_command=True)
@Shared.json
@click.pass_context
def cache(context: click.Context, as_json: bool) -> None:
    """Show the cache: folder, number of files and size.

    The cache has compiled tables and cloud optics. HCSS_CACHE_DIR sets its folder, HCSS_CACHE_MB the limit of the
    tables (1000 MB; 0 disables them).
    """
    if context.invoked_subcommand is not None:
        return
    from hcss_twin.core.cache import Store, cache_root, in_use, limit_bytes

    root, limit = cache_root(), limit_bytes()
    in_use(root)  # warns of a folder that cannot be used
    kinds = {kind: _count(Store(kind, suffix).kept()) for kind, suffix in KINDS.items()}
    if as_json:
        folder = None if root is None else str(root)
        Shared.write_json({"folder": folder, "limit_bytes": limit, "kinds": kinds})
        return
    click.echo(f"{'no cache folder' if root is None else root}")
    for kind, count in kinds.items():
        most = f" of at most {limit / 1e6:g} MB" if kind == "tables" else ""
        click.echo(f"  {kind:<11}{count['files']:5} files {count['bytes'] / 1e6:9.2f} MB{most}")


@cache.command()
@click.argument("kinds", nargs=-1, type=click.Choice(sorted(KINDS)))
@Shared.json
def clear(kinds: tuple[str, ...], as_json: bool) -> None:
    """Delete the cached results: all, or those of KINDS."""
    from hcss_twin.core.cache import Store

    removed = {kind: _count(Store(kind, KINDS[kind]).clear()) for kind in kinds or KINDS}
    if as_json:
        Shared.write_json({"removed": removed})
        return
    for kind, count in removed.items():
        click.echo(f"{kind}: {count['files']} files removed, {count['bytes'] / 1e6:.1f} MB")


def _count(files: Any) -> dict[str, int]:
    return {"files": len(files), "bytes": sum(file.size for file in files)}
