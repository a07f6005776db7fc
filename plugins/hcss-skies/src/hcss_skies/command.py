"""``hcss skies``: examples of skies, made from satellite images; simulations of clouds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from hcss_twin.cli.options import Existing, Number, Output, Shared, Stop

if TYPE_CHECKING:
    from hcss_skies.missing import Missing


@click.group()
def skies() -> None:
    """List skies, make an example from an image, simulate clouds, or pack a simulation as a film or a volume."""


@skies.command(name="list")
def list_examples() -> None:
    """List the shipped examples, films and volumes: name, kind, pixel size, cloud cover, heights, and size."""
    from hcss_skies.example import read_example
    from hcss_skies.film import described
    from hcss_skies.library import shipped, shipped_films, shipped_volumes
    from hcss_skies.volume import read_volume

    for name, path in shipped().items():
        of = read_example(path)
        heights = f"{of.opaque_m[0] / 1e3:.1f} to {of.opaque_m[-1] / 1e3:.1f} km"
        click.echo(f"{name:22} {of.kind:15} {of.pixel_size_m:g} m, cover {of.coverage:.2f}, heights {heights}")
    for name, path in shipped_films().items():
        click.echo(f"{name:22} {described(path)}")
    for name, path in shipped_volumes().items():
        click.echo(f"{name:22} {read_volume(path).described()}")


@skies.command(name="import")
@click.argument("image", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("-o", "--output", required=True, type=Output(dir_okay=False), help="Example (.nc).")
@click.option(
    "--variable",
    help="Brightness temperature near 10.8 um in a file with several images; default: the one named like IR_108 "
    "of SEVIRI or C13 of ABI.",
)
@click.option(
    "--second",
    help="Brightness temperature at 12.0 um in the same file: heights of thin clouds; default: without --variable, the "
    "one named like IR_120 or C15.",
)
@Shared.at
@click.option(
    "--missing",
    default="auto",
    type=click.Choice(["auto", "fill", "crop"]),
    help="Missing pixels. fill: up to 5 %, by interpolation; crop: largest part without them; auto: crop if that costs "
    "a tenth or less of the pixels, else fill, else crop.",
)
@Shared.length("--pixel-size", "pixel_size_m", help="Pixel size on the ground, for example '3 km'; overrides the file.")
@click.option("--lapse", default=6.5, type=Number(1.0, 12.0), help="Lapse rate of the air, K/km.")
@click.option("--clear", type=Number(180.0, 330.0), help="Clear sky, K; default: the 99th percentile.")
@click.option("--kind", default="imported", help="Kind of clouds.")
@click.option("--licence", default="", help="Terms of use of the image; default: those in the file.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
def import_image(
    image: Path,
    output: Path,
    variable: str | None,
    second: str | None,
    at: dict[str, int],
    missing: Missing,
    pixel_size_m: float | None,
    lapse: float,
    clear: float | None,
    kind: str,
    licence: str,
    force: bool,
) -> None:
    """Make an example of IMAGE: brightness temperature, or radiance of GOES ABI, near 10.8 um over sea.

    The example belongs into the folder skies/ beside a scenario, which then names it without .nc.
    """
    from hcss_skies.detail_of_image import described
    from hcss_skies.example import write_example
    from hcss_skies.importing import import_example
    from hcss_twin.providers import CatalogError

    if output.parent.is_dir():
        Output.require_writable([output], force, form="NetCDF")
    done = import_example(
        image,
        variable=variable,
        second=second,
        at=at,
        missing=missing,
        pixel_size_m=pixel_size_m,
        lapse_K_km=lapse,
        clear_K=clear,
        kind=kind,
        licence=licence,
    )
    example = done.example
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CatalogError(f"cannot make the folder {output.parent}: {error.strerror}") from error
    write_example(output, example)
    channels = " and ".join(channel for channel in (done.variable, done.second) if channel)
    click.echo(
        f"{output}: {' x '.join(map(str, example.opaque.shape))} pixels of {example.pixel_size_m:g} m"
        + (f" from {channels}" if channels else "")
        + f", cloud cover {example.coverage:.2f}, heights {example.opaque_m[0] / 1e3:.1f} to "
        + f"{example.opaque_m[-1] / 1e3:.1f} km above that of clear sky ({lapse:g} K/km)."
        + ("" if done.second else " One channel: cloud tops above the opaque height are not known.")
    )
    click.echo(described(example.detail))
    for note in done.notes:
        click.echo(f"note: {note}")


@skies.command()
@click.argument("case", required=False)
@click.option("-o", "--output", type=Output(dir_okay=False), help="NetCDF file; default: the case's name with .nc.")
@click.option("--profile", type=Existing(dir_okay=False), help="A sounding (CSV) in the place of a case; needs --sea.")
@click.option("--sea", type=Number(260.0, 320.0), metavar="K", help="Temperature of the sea below the sounding.")
@click.option("--wind", type=float, nargs=2, metavar="U V", help="Wind of all heights, m/s; default: the sounding's.")
@click.option("--pressure", type=Number(900.0, 1100.0), default=1013.25, help="Of the sounding at the sea, hPa.")
@click.option("--latitude", type=Number(-90.0, 90.0), default=25.0, help="Of the sounding.")
@click.option(
    "--cooling", type=Number(0.0, 20.0), metavar="K", help="Of the sounding's clear air in a day; default: 2."
)
@click.option("--subsidence", type=Number(0.0, 0.03), metavar="M/S", help="Above the inversion; default: estimated.")
@click.option("--columns", type=int, nargs=2, metavar="NX NY", help="Cells along x and y in the place of the case's.")
@Shared.length("--side", help="Side of a cell in the place of the case's.")
@click.option("--hours", type=Number(0.0, 240.0, min_open=True), help="Duration in the place of the case's.")
@click.option("--spin-up", type=Number(0.0, 240.0), metavar="HOURS", help="Before the first picture.")
@click.option("--volumes", type=Number(1.0), metavar="SECONDS", help="Keep volumes of extinction so often, too.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), help="Of the noise at the start.")
@click.option("--precision", type=click.Choice(["single", "double"]), help="Of the fields; default: the case's.")
@click.option("--restart", is_flag=True, help="Begin again where an interrupted run would be continued.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.pass_context
def simulate(
    context: click.Context,
    case: str | None,
    output: Path | None,
    profile: Path | None,
    sea: float | None,
    wind: tuple[float, float] | None,
    pressure: float,
    latitude: float,
    cooling: float | None,
    subsidence: float | None,
    columns: tuple[int, int] | None,
    side: float | None,
    hours: float | None,
    spin_up: float | None,
    volumes: float | None,
    seed: int | None,
    precision: str | None,
    restart: bool,
    force: bool,
) -> None:
    """Compute the clouds of CASE by large-eddy simulation: a shipped case, a TOML file, or the case of a --profile.

    An interrupted run is continued by the same command, with the same bits. The file has pictures of water path,
    optical thickness, top and base, and statistics. hcss skies cases lists the shipped cases.
    """
    from functools import partial

    from hcss_skies.les.case import read_case
    from hcss_skies.les.run import remarks, simulate_case
    from hcss_skies.les.sounding import case_of_sounding, read_sounding

    if (case is None) == (profile is None):
        raise click.UsageError("allowed: either CASE or --profile")
    if (sea is None) != (profile is None):
        raise click.UsageError("--profile and --sea: allowed: both or neither")
    sections: dict[str, dict[str, object]] = {
        "grid": {"columns": list(columns) if columns else None, "side_m": side},
        "output": {"hours": hours, "spin_up_hours": spin_up, "volume_s": volumes},
    }
    changed = {name: {key: v for key, v in fields.items() if v is not None} for name, fields in sections.items()}
    if profile is not None and sea is not None:
        sounding = read_sounding(profile, 100.0 * pressure, wind or None)
        read, notes = case_of_sounding(
            sounding, sea, latitude_deg=latitude, cooling_K_day=cooling, subsidence_m_s=subsidence, changed=changed
        )
        for note in notes:
            click.echo(f"estimated: {note}", err=True)
    else:
        read = read_case(str(case), **changed)
    single = {"seed": seed, "precision": precision}
    read = read.model_copy(update={name: value for name, value in single.items() if value is not None})
    path = output or Path(f"{Path(str(case or profile)).stem}.nc")
    Output.require_writable([path], force, form="NetCDF")
    progress = partial(context.ensure_object(Stop).progress, label="simulating")
    model = simulate_case(read, path, progress, restart)
    click.echo(f"{path}: {read.title}; {model.steps} steps to {model.time_s / 3600:g} h, {model.liquid.size} cells")
    for remark in remarks(model):
        click.echo(f"note: {remark}", err=True)


@skies.command(name="pack")
@click.argument("run", type=Existing(dir_okay=False))
@click.option("-o", "--output", required=True, type=Output(dir_okay=False), help="Film or volume (.nc).")
@click.option(
    "--start",
    "starts",
    multiple=True,
    type=Number(0.0),
    metavar="HOURS",
    help="Time of the run at which a piece starts; repeat for several; default: the first picture, and 90 min later or "
    "as late as there are pictures.",
)
@click.option("--snapshots", type=click.IntRange(2, 1000), default=30, show_default=True, help="Pictures of a piece.")
@click.option(
    "--volume",
    is_flag=True,
    help="Pack a volume that `hcss skies simulate --volumes` kept, instead of a film: the last, or that at --start.",
)
@click.option("--kind", help="Kind of clouds; default: the title of the run.")
@click.option("--licence", default="own computation", show_default=True, help="Terms of use.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.pass_context
def pack_run(
    context: click.Context,
    run: Path,
    output: Path,
    starts: tuple[float, ...],
    snapshots: int,
    volume: bool,
    kind: str | None,
    licence: str,
    force: bool,
) -> None:
    """Pack pictures of RUN, a file of hcss skies simulate, as a film of clouds that move, or a volume of their cells.

    The file belongs into the folder skies/ beside a scenario, which then names it without .nc.
    """
    from hcss_skies.film import described, write_film
    from hcss_skies.packing import pack
    from hcss_skies.volume import volume_of_run, write_volume

    if volume and len(starts) > 1:
        raise click.UsageError(f"--start: {len(starts)} given; allowed with --volume: one")
    if volume and context.get_parameter_source("snapshots") is not click.core.ParameterSource.DEFAULT:
        raise click.UsageError("--snapshots: given; allowed with --volume: without")
    Output.require_writable([output], force, form="NetCDF")
    if volume:
        packed = volume_of_run(run, *starts, kind=kind, licence=licence)
        write_volume(output, packed)
        click.echo(f"{output}: {packed.described()}")
        return
    film = pack(run, starts, snapshots=snapshots, kind=kind, licence=licence)
    write_film(output, film)
    pieces, _, rows, columns = film.ranks.shape
    click.echo(f"{output}: {described(output)}; {pieces} x {snapshots} snapshots of {rows} x {columns} cells")


@skies.command()
def cases() -> None:
    """List the shipped cases of simulations."""
    from hcss_skies.les.case import read_case, shipped

    for name in shipped():
        case = read_case(name)
        side = " x ".join(f"{n * case.grid.side_m / 1e3:g}" for n in case.grid.columns)
        click.echo(f"{name:16} {case.title}: {side} km, {case.grid.side_m:g} m, {case.output.hours:g} h")
