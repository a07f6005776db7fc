"""``hcss skies``: list the examples, and make one from a satellite image."""

from __future__ import annotations

from pathlib import Path

import click

from hcss_twin.cli.options import metres


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
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False, path_type=Path), help="Example (.nc).")
@click.option("--variable", help="Brightness temperature near 10.8 um in a file with several images.")
@click.option("--second", help="Brightness temperature at 12.0 um in the same file: heights of thin clouds.")
@click.option(
    "--pixel-size",
    "pixel_size_m",
    metavar="LENGTH",
    callback=metres,
    help="Pixel size on the ground, for example '3 km'; overrides the file.",
)
@click.option("--lapse", default=6.5, type=click.FloatRange(1.0, 12.0), help="Lapse rate of the air, K/km.")
@click.option("--clear", type=click.FloatRange(180.0, 330.0), help="Clear sky, K; default: the 99th percentile.")
@click.option("--kind", default="imported", help="Kind of clouds.")
@click.option("--licence", default="", help="Terms of use of the image; default: those in the file.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
def import_image(
    image: Path,
    output: Path,
    variable: str | None,
    second: str | None,
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
    from hcss_skies.example import write_example
    from hcss_skies.importing import import_example
    from hcss_twin.errors import CatalogError

    if output.exists() and not force:
        raise CatalogError(f"{output} exists; --force replaces it")
    example = import_example(
        image,
        variable=variable,
        second=second,
        pixel_size_m=pixel_size_m,
        lapse_K_km=lapse,
        clear_K=clear,
        kind=kind,
        licence=licence,
    )
    write_example(output, example)
    click.echo(
        f"{output}: {' x '.join(map(str, example.opaque.shape))} pixels of {example.pixel_size_m:g} m, cloud cover "
        f"{example.coverage:.2f}."
        + ("" if second else " One channel: cloud tops above the opaque height are not known.")
    )
