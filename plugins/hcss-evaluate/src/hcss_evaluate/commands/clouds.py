"""``hcss import`` and ``hcss clouds``: the database of clouds cut from satellite images."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import click

from hcss_evaluate.commands.image_options import cloud_options
from hcss_twin.cli.options import Existing, Output, Shared
from hcss_twin.core.json_numbers import json_value
from hcss_twin.providers import CatalogError

_FOLDER = click.Path(file_okay=False, path_type=Path)


def _odd(_context: click.Context, _option: click.Parameter, value: int) -> int:
    if value % 2 == 0:
        raise click.BadParameter(f"{value} given, allowed: odd diameters; closest is {value + 1}")
    return value


def _diameter(name: str, noun: str, default: int) -> Any:
    return click.option(
        f"--{name}",
        noun,
        default=default,
        type=click.IntRange(1, 99),
        callback=_odd,
        help=f"Diameter of the {noun}, pixels; 1: none.",
    )


_LIST = "\0"
"""Value of --sample without NAME: what no argument of a command can contain."""


@click.command("import")
@click.argument("image", type=Existing(dir_okay=False), required=False)
@click.option(
    "--sample",
    is_flag=False,
    flag_value=_LIST,
    metavar="[NAME]",
    help="Measured image of the extra samples, in place of IMAGE; without NAME: list them.",
)
@click.option("--name", help="Name of the entry; default: that of the file or sample.")
@click.option(
    "--crop",
    nargs=4,
    type=click.IntRange(0),
    metavar="ROW COLUMN ROWS COLUMNS",
    help="Part to import: first row and column as stored, and size; default: the whole image. Not with --sample.",
)
@cloud_options("otsu")
@_diameter("close", "closing", 1)
@_diameter("open", "opening", 1)
@click.option("--fill-holes/--no-fill-holes", default=None, help="Fill holes in clouds, of up to 100 pixels.")
@click.option("--largest-hole", type=click.IntRange(1), help="Largest hole to fill, pixels; default: none.")
@click.option("--min-area", default=1, type=click.IntRange(1), help="Smallest cloud, pixels.")
@click.option("--band", help="Spectral band; default: from the file.")
@click.option("--observed", help="Time of observation; default: from the file.")
@click.option("--source", help="Source of the image.")
@click.option("--licence", help="Licence of the image; default: from the file.")
@click.option("--to", "folder", default="clouds", type=_FOLDER, help="Folder of the entries.")
@Shared.force
@Shared.json
def import_command(
    image: Path | None,
    sample: str | None,
    name: str | None,
    closing: int,
    opening: int,
    fill_holes: bool | None,
    largest_hole: int | None,
    min_area: int,
    folder: Path,
    force: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Extract the clouds of IMAGE into the cloud database.

    IMAGE is NetCDF (also GOES ABI), GeoTIFF, PNG, JPEG or NumPy. The command writes the entry NAME.nc and a picture
    NAME.png of the detected clouds; check it before you use the entry.
    """
    if (image is None) is (sample is None):
        given = "neither IMAGE nor --sample" if image is None else "both IMAGE and --sample"
        raise click.UsageError(f"{given} given; allowed: one of them")
    if sample is not None and options["crop"] is not None:
        raise click.UsageError(
            "--crop: has no meaning with --sample, which is a part without land; allowed: leave it out"
        )
    if sample == _LIST:
        _list_samples(as_json)
        return
    if sample is not None:
        from hcss_evaluate.database.samples import sample as measured
        from hcss_twin.providers import Catalog

        found = measured(sample, Catalog())
        image, name = found.path(), sample if name is None else name
        stated = {key: value for key, value in found.stated.items() if options[key] is None}
        options |= stated
        if stated.get("pixel_size_m") is not None:
            options["pixel_size_from"] = "sample"
    assert image is not None
    from hcss_evaluate.database.cloud_import import ImportOptions, import_image
    from hcss_evaluate.database.folder import valid_entry_name
    from hcss_evaluate.database.segmentation import Cleaning
    from hcss_evaluate.pages.cloud_pictures import draw_entry
    from hcss_twin.models.clouds.database import CloudEntry

    if options["coverage"] is None and options["method"] == "coverage":
        raise click.UsageError("--method coverage needs --coverage, the fraction of cloudy pixels")
    if options["coverage"] is not None and options["method"] != "coverage":
        raise click.UsageError("--coverage: allowed with --method coverage only")
    if options["window_pixels"] is not None and options["method"] != "local":
        raise click.UsageError("--window: allowed with --method local only")
    if largest_hole is not None and fill_holes is False:
        raise click.UsageError("--largest-hole: allowed without --no-fill-holes only")
    try:
        name = valid_entry_name(image.stem if name is None else name)
    except CatalogError as error:
        raise click.BadParameter(str(error), param_hint="--name") from error
    path = folder / f"{name}{CloudEntry.SUFFIX}"
    picture = folder / f"{name}.png"
    if folder.is_dir():
        Output.require_writable([path], force, "give another --name", form="NetCDF")
        Output.require_writable([picture], force, "give another --name", form="PNG")
    cleaning = Cleaning(closing, opening, largest_hole or (100 if fill_holes else 0), min_area)
    entry = import_image(image, ImportOptions(cleaning=cleaning, window=options.pop("window_pixels"), **options))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.ClickException(f"cannot make the folder {folder}: {error.strerror}") from error
    entry.write(path)
    draw_entry(entry, name, picture)
    if as_json:
        answer = {"name": name, "entry": str(path), "preview": str(picture), "notes": entry.notes}
        Shared.write_json({**answer, **_as_dict(entry.facts)})
        return
    click.echo("\n".join([*_described(entry.facts, entry.grey.shape), *entry.notes, f"{path}  {picture}"]))


def _list_samples(as_json: bool) -> None:
    from hcss_evaluate.database.samples import FOLDER as EXTRA
    from hcss_evaluate.database.samples import samples
    from hcss_twin.providers import Catalog

    known = samples(Catalog())
    if as_json:
        listed = [
            {"name": name, "installed": sample.folder is not None, **_as_dict(sample)} for name, sample in known.items()
        ]
        Shared.write_json(listed)
        return
    for name, sample in known.items():
        click.echo(
            f"{name}\n  {sample.title}; {sample.crop[2]} x {sample.crop[3]} pixels; {sample.band}; {sample.observed}"
        )
        click.echo(f"  {sample.source}; {sample.licence}")
        if sample.folder is None:
            click.echo(f"  not installed: pip install 'hcss-twin[{EXTRA}]'")


@click.group(invoke_without_command=True)
@Shared.json
@click.pass_context
def clouds(context: click.Context, as_json: bool) -> None:
    """Show the cloud database; without a command, list it."""
    if context.invoked_subcommand is None:
        context.invoke(clouds_list, as_json=as_json)


clouds.add_command(import_command)

_folder_option = click.option(
    "--from", "folder", type=_FOLDER, help="Folder of the entries; default: clouds, and the shipped entries."
)


def _folders(folder: Path | None) -> list[Path]:
    """Return the folders of entries: the given one, or the user's and the shipped ones."""
    from hcss_twin.models.clouds.database import CloudEntry
    from hcss_twin.providers import Catalog

    return [Path(CloudEntry.FOLDER), Catalog().root / CloudEntry.FOLDER] if folder is None else [folder]


@clouds.command("list")
@_folder_option
@Shared.json
def clouds_list(folder: Path | None = None, as_json: bool = False) -> None:
    """List the entries."""
    from hcss_evaluate.database.folder import list_entries

    listed = [entry for entries_folder in _folders(folder) for entry in list_entries(entries_folder)]
    if as_json:
        answer = [
            {
                "name": entry.name,
                "entry": str(entry.path),
                **({"trouble": entry.trouble} if entry.facts is None else _as_dict(entry.facts)),
                "rows": entry.shape[0],
                "columns": entry.shape[1],
            }
            for entry in listed
        ]
        Shared.write_json(answer)
        return
    if not listed:
        click.echo(f"no entries in {folder}; make one with: hcss import IMAGE --to {folder}")
        return
    width = max(len(entry.name) for entry in listed)
    click.echo(f"{'name':<{width}}  {'cover':>6} {'clouds':>6} {'FD':>6} {'pixel':>9}  {'pixels':<13} band; licence")
    for entry in listed:
        if entry.facts is None:
            click.echo(click.style(f"{entry.name:<{width}}  unusable: {entry.trouble}", fg="red"))
            continue
        facts = entry.facts
        size = f"{facts.pixel_size_m:.5g} m"
        pixels = f"{entry.shape[0]} x {entry.shape[1]}"
        click.echo(
            f"{entry.name:<{width}}  {facts.coverage:>6.1%} {facts.clouds:>6} {facts.fractal_dimension:>6.3f} "
            f"{size:>9}  {pixels:<13} {facts.band}; {facts.licence}"
        )


_BY_PLACE = {
    "condensation": "from condensation level up",
    "inversion": "below the inversion",
    "tropopause": "below the tropopause",
}


@clouds.command("types")
@Shared.json
def clouds_types(as_json: bool) -> None:
    """List the cloud types of the catalog, with their optical thickness beside published values."""
    from hcss_twin import Scenario
    from hcss_twin.providers import Catalog

    catalog, rows = Catalog(), list[dict[str, Any]]()
    for name in catalog.names("cloud_types", ".toml"):
        cloud = Scenario.cloud_type(name, catalog)
        layer, published = cloud.layer, cloud.optical_thickness
        where = f"{layer.base:g} to {layer.top:g} m" if layer.level is None else _BY_PLACE[layer.level]
        row: dict[str, Any] = {"name": name, "title": cloud.title, "altitudes": where}
        row["mean"] = cloud.visible_optical_thickness("mean")
        row["median"] = cloud.visible_optical_thickness("median")
        row["thickest"] = cloud.visible_optical_thickness("thickest")
        rows.append(row if published is None else row | published.model_dump())
    if as_json:
        Shared.write_json(rows)
        return
    click.echo("visible optical thickness of cloudy columns; published values beside it")
    width = max(len(str(row["name"])) for row in rows)
    click.echo(f"{'type':<{width}}  {'altitudes':<32} {'mean':>6} {'median':>6} {'most':>6}  published")
    for row in rows:
        known = "" if "of" not in row else "{of} {0:g} to {1:g}: {source}".format(*row["published"], **row)
        click.echo(
            f"{row['name']:<{width}}  {row['altitudes']:<32} {row['mean']:>6.3g} {row['median']:>6.3g} "
            f"{row['thickest']:>6.3g}  {known}"
        )


@clouds.command("preview")
@click.argument("name")
@_folder_option
@click.option(
    "-o",
    "--output",
    type=Output(dir_okay=False),
    help="Picture; default: NAME.png beside the entry; here for a shipped one.",
)
@Shared.force
@Shared.json
def clouds_preview(name: str, folder: Path | None, output: Path | None, force: bool, as_json: bool) -> None:
    """Draw and describe the entry NAME."""
    from hcss_evaluate.database.folder import entry_path
    from hcss_evaluate.pages.cloud_pictures import draw_entry
    from hcss_twin.models.clouds.database import CloudEntry

    database, *shipped = _folders(folder)
    path = next(
        (found for shipped_folder in shipped if (found := shipped_folder / f"{name}{CloudEntry.SUFFIX}").is_file()),
        None,
    )
    picture = output or (database / f"{name}.png" if path is None else Path(f"{name}.png"))
    if output is not None or path is not None:  # the picture beside an own entry belongs to it
        Output.require_writable([picture], force, form="PNG")
    path = path or entry_path(database, name)
    entry = CloudEntry.read(path)
    draw_entry(entry, name, picture)
    if as_json:
        Shared.write_json({"name": name, "preview": str(picture), **_as_dict(entry.facts)})
        return
    click.echo("\n".join([*_described(entry.facts, entry.grey.shape), str(picture)]))


def _as_dict(facts: Any) -> dict[str, Any]:
    values: dict[str, Any] = json_value(dataclasses.asdict(facts))
    return values


def _described(facts: Any, shape: tuple[int, ...]) -> list[str]:
    """Format an entry as lines of text."""
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
        f"cleaning           {_cleaning(facts)}; {facts.missing_pixels} pixels missing",
        f"band, time         {facts.band}; {facts.observed}",
        f"file               {facts.source_file}",
        f"source, licence    {facts.source}; {facts.licence}",
    ]


def _cleaning(facts: Any) -> str:
    if (facts.closing, facts.opening, facts.largest_hole, facts.min_area) == (1, 1, 0, 1):
        return "none"
    return (
        f"closing {facts.closing}, opening {facts.opening}, {facts.holes_filled} holes of up to {facts.largest_hole} "
        f"pixels filled ({facts.hole_pixels} pixels), {facts.clouds_dropped} clouds dropped"
    )


def _dimension(value: float, error: float) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:.3f}" if math.isnan(error) else f"{value:.3f} +- {error:.3f}"
