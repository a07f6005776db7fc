"""``hcss skies``: list the examples, and make one from a satellite image."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from hcss_twin.cli.options import Number, Output

if TYPE_CHECKING:
    from hcss_skies.missing import Missing


def indices(_context: click.Context, _option: click.Parameter, given: tuple[str, ...]) -> dict[str, int]:
    """Parse indices such as ``scene=3``."""
    found: dict[str, int] = {}
    for text in given:
        name, _, number = text.partition("=")
        if not name or not number.isdigit() or name in found:
            raise click.BadParameter(f"'{text}' given, allowed: each dimension once, with an index, such as scene=3")
        found[name] = int(number)
    return found


def metres(_context: click.Context, _option: click.Parameter, text: str | None) -> float | None:
    """Read a length such as ``1 km``; a plain number is in metres."""
    from pydantic_core import PydanticCustomError

    from hcss_twin.scenario.units import QuantityParser

    if text is None:
        return None
    try:
        size = QuantityParser("length")(text)
    except PydanticCustomError as error:
        raise click.BadParameter(error.message()) from error
    if not isinstance(size, float) or not 0.0 < size < float("inf"):
        raise click.BadParameter(f"{text} given, allowed: greater than 0")
    return size


@click.group()
def skies() -> None:
    """List examples of skies, or make one from an image."""


@skies.command(name="list")
def list_examples() -> None:
    """List the shipped examples: name, kind, pixel size, cloud cover, range of heights."""
    from hcss_skies.example import read_example
    from hcss_skies.library import shipped

    for name, path in shipped().items():
        of = read_example(path)
        heights = f"{of.opaque_m[0] / 1e3:.1f} to {of.opaque_m[-1] / 1e3:.1f} km"
        click.echo(f"{name:22} {of.kind:15} {of.pixel_size_m:g} m, cover {of.coverage:.2f}, heights {heights}")


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
@click.option(
    "--at",
    multiple=True,
    metavar="DIMENSION=INDEX",
    callback=indices,
    help="Which image of a NetCDF variable with several, for example scene=3; from 0; repeat for each dimension.",
)
@click.option(
    "--missing",
    default="auto",
    type=click.Choice(["auto", "fill", "crop"]),
    help="Missing pixels. fill: up to 5 %, by interpolation; crop: largest part without them; auto: crop if that costs "
    "a tenth or less of the pixels, else fill, else crop.",
)
@click.option(
    "--pixel-size",
    "pixel_size_m",
    metavar="LENGTH",
    callback=metres,
    help="Pixel size on the ground, for example '3 km'; overrides the file.",
)
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
