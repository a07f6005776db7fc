"""``hcss import`` and ``hcss clouds``: the database of clouds cut from satellite images."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import click

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.json_numbers import json_value


def metres(_context: click.Context, _option: click.Parameter, text: str | None) -> float | None:
    """Read a length such as ``1 km``; a plain number is metres."""
    if text is None:
        return None
    from pydantic_core import PydanticCustomError

    from hcss_twin.scenario.units import parse_quantity

    try:
        size = parse_quantity(text, "length")
    except PydanticCustomError as error:
        raise click.BadParameter(error.message()) from error
    if not isinstance(size, float) or not 0.0 < size < math.inf:
        raise click.BadParameter(f"{text} given, allowed: greater than 0")
    return size


def _odd(_context: click.Context, _option: click.Parameter, value: int) -> int:
    if value % 2 == 0:
        raise click.BadParameter(f"{value} given, allowed: odd diameters; closest is {value + 1}")
    return value


@click.command("import")
@click.argument("image", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--name", help="Name of the entry; default: that of the file.")
@click.option("--variable", help="Variable of a NetCDF or .npz file, or number of a GeoTIFF's band.")
@click.option(
    "--method",
    default="otsu",
    show_default=True,
    type=click.Choice(["otsu", "local", "coverage", "valid"]),
    help="Threshold: splits the histogram; follows the surroundings; takes the cloudiest until --coverage; "
    "takes every pixel that has a value.",
)
@click.option("--window", type=click.IntRange(3, 16384), help="Side of the surroundings of method local, pixels.")
@click.option("--coverage", type=click.FloatRange(0, 1), help="Cloudy fraction of method coverage.")
@click.option(
    "--cloud-is",
    default="auto",
    show_default=True,
    type=click.Choice(["auto", "bright", "dark"]),
    help="Which values are cloud; auto: small ones of temperatures and thermal radiances.",
)
@click.option(
    "--close",
    "closing",
    default=3,
    show_default=True,
    type=click.IntRange(1, 99),
    callback=_odd,
    help="Diameter of the closing, pixels; 1: none.",
)
@click.option(
    "--open",
    "opening",
    default=1,
    show_default=True,
    type=click.IntRange(1, 99),
    callback=_odd,
    help="Diameter of the opening, pixels; 1: none.",
)
@click.option("--fill-holes/--no-fill-holes", default=True, show_default=True, help="Fill holes in clouds.")
@click.option(
    "--largest-hole",
    default=100,
    show_default=True,
    type=click.IntRange(1),
    help="Largest hole that is filled, pixels.",
)
@click.option("--min-area", default=9, show_default=True, type=click.IntRange(1), help="Smallest cloud, pixels.")
@click.option(
    "--pixel-size",
    "pixel_size_m",
    metavar="LENGTH",
    callback=metres,
    help="Side of a pixel on the ground, for example '1 km'; needed where the file does not tell.",
)
@click.option("--band", help="Spectral band, for people; default: what the file says.")
@click.option("--source", help="Where the image is from.")
@click.option("--licence", help="Terms under which the image may be used; default: what the file says.")
@click.option(
    "--to",
    "folder",
    default="clouds",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the entries; made if missing.",
)
@click.option("--force", is_flag=True, help="Replace an existing entry.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def import_command(
    image: Path,
    name: str | None,
    closing: int,
    opening: int,
    fill_holes: bool,
    largest_hole: int,
    min_area: int,
    folder: Path,
    force: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Cut the clouds out of IMAGE and put them into the cloud database.

    IMAGE is NetCDF (GOES ABI among them), GeoTIFF, PNG, JPEG or NumPy. Written are NAME.nc and a picture,
    NAME.png: look at it before using the entry.
    """
    from hcss_twin.analysis.cloud_import import ImportOptions, import_image
    from hcss_twin.models.clouds.database import SUFFIX, valid_entry_name, write_entry
    from hcss_twin.models.clouds.segmentation import Cleaning
    from hcss_twin.report.image_preview import draw_entry

    if options["coverage"] is None and options["method"] == "coverage":
        raise click.UsageError("--method coverage needs --coverage, the fraction of cloudy pixels")
    if options["coverage"] is not None and options["method"] != "coverage":
        raise click.UsageError("--coverage goes with --method coverage only")
    if options["window"] is not None and options["method"] != "local":
        raise click.UsageError("--window goes with --method local only")
    try:
        name = valid_entry_name(name or image.stem)
    except CatalogError as error:
        raise click.BadParameter(str(error), param_hint="--name") from error
    path = folder / f"{name}{SUFFIX}"
    picture = folder / f"{name}.png"
    for file in (path, picture):
        if file.exists() and not force:
            raise click.ClickException(f"{file} exists; give another --name, or --force")
    cleaning = Cleaning(closing, opening, largest_hole if fill_holes else 0, min_area)
    entry = import_image(image, ImportOptions(cleaning=cleaning, **options))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.ClickException(f"cannot make the folder {folder}: {error.strerror}") from error
    write_entry(path, entry)
    draw_entry(entry, name, picture)
    if as_json:
        answer = {"name": name, "entry": str(path), "preview": str(picture), **_as_dict(entry.facts)}
        click.echo(json.dumps(answer))
        return
    click.echo("\n".join([*_described(entry.facts, entry.grey.shape), f"{path}  {picture}"]))


@click.group(invoke_without_command=True)
@click.pass_context
def clouds(context: click.Context) -> None:
    """Show the cloud database; without a command, list it."""
    if context.invoked_subcommand is None:
        context.invoke(clouds_list)


def _folder_option(command: Any) -> Any:
    return click.option(
        "--from",
        "folder",
        default="clouds",
        show_default=True,
        type=click.Path(file_okay=False, path_type=Path),
        help="Folder of the entries.",
    )(command)


@clouds.command("list")
@_folder_option
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def clouds_list(folder: Path = Path("clouds"), as_json: bool = False) -> None:
    """List the entries of a folder."""
    from hcss_twin.models.clouds.database import list_entries

    listed = list_entries(folder)
    if as_json:
        answer = [
            {
                "name": each.name,
                "entry": str(each.path),
                **({"trouble": each.trouble} if each.facts is None else _as_dict(each.facts)),
                "rows": each.shape[0],
                "columns": each.shape[1],
            }
            for each in listed
        ]
        click.echo(json.dumps(answer))
        return
    if not listed:
        click.echo(f"no entries in {folder}; make one with: hcss import IMAGE --to {folder}")
        return
    width = max(len(each.name) for each in listed)
    click.echo(f"{'name':<{width}}  {'cover':>6} {'clouds':>6} {'FD':>6} {'pixel':>9}  {'pixels':<13} band; licence")
    for each in listed:
        if each.facts is None:
            click.echo(click.style(f"{each.name:<{width}}  unusable: {each.trouble}", fg="red"))
            continue
        facts = each.facts
        size = f"{facts.pixel_size_m:.5g} m"
        pixels = f"{each.shape[0]} x {each.shape[1]}"
        click.echo(
            f"{each.name:<{width}}  {facts.coverage:>6.1%} {facts.clouds:>6} {facts.fractal_dimension:>6.3f} "
            f"{size:>9}  {pixels:<13} {facts.band}; {facts.licence}"
        )


@clouds.command("preview")
@click.argument("name")
@_folder_option
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Picture to write; default: NAME.png beside it.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def clouds_preview(name: str, folder: Path, output: Path | None, as_json: bool) -> None:
    """Draw the entry NAME and say what it is."""
    from hcss_twin.models.clouds.database import entry_path, read_entry
    from hcss_twin.report.image_preview import draw_entry

    path = entry_path(folder, name)
    entry = read_entry(path)
    picture = output or path.with_suffix(".png")
    draw_entry(entry, name, picture)
    if as_json:
        click.echo(json.dumps({"name": name, "preview": str(picture), **_as_dict(entry.facts)}))
        return
    click.echo("\n".join([*_described(entry.facts, entry.grey.shape), str(picture)]))


def _as_dict(facts: Any) -> dict[str, Any]:
    """Return the facts for JSON."""
    found: dict[str, Any] = json_value(dataclasses.asdict(facts))
    return found


def _described(facts: Any, shape: tuple[int, ...]) -> list[str]:
    """Tell an entry in lines of text."""
    nominal = ", nominal: below the satellite" if facts.pixel_size_is_nominal else ""
    thresholds = f"{facts.threshold_lowest:.6g}"
    if facts.threshold_highest != facts.threshold_lowest:
        thresholds += f" to {facts.threshold_highest:.6g}"
    units = "" if facts.units in ("not stated", "1") else f" {facts.units}"
    comparison = "above" if facts.cloud_is == "bright" else "below"
    return [
        f"coverage           {facts.coverage:.4f}, {facts.clouds} clouds of {facts.min_area} pixels or more",
        f"fractal dimension  {_dimension(facts.fractal_dimension, facts.fractal_dimension_error)}"
        f"  ({facts.fractal_dimension_method}; of the cloudy pixels)",
        f"                   {_dimension(facts.box_counting_dimension, facts.box_counting_error)}"
        f"  ({facts.box_counting_method}; of the whole scene)",
        f"image              {shape[0]} x {shape[1]} pixels of {facts.pixel_size_m:.6g} m "
        f"(from the {facts.pixel_size_from}{nominal})",
        f"cloud              {comparison} {thresholds}{units} (method {facts.method})",
        f"cleaning           closing {facts.closing}, opening {facts.opening}, {facts.holes_filled} holes of up to "
        f"{facts.largest_hole} pixels filled ({facts.hole_pixels} pixels), {facts.clouds_dropped} clouds dropped, "
        f"{facts.missing_pixels} pixels missing",
        f"band, time         {facts.band}; {facts.observed}",
        f"source, licence    {facts.source}; {facts.licence}",
    ]


def _dimension(value: float, error: float) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:.3f}" if math.isnan(error) else f"{value:.3f} +- {error:.3f}"
