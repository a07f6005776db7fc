"""``hcss-pyxel``: an example pipeline for a cube."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def cli() -> None:
    """Cubes of hcss_twin in Pyxel."""


@cli.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
@click.option(
    "-o",
    "--output",
    default="pyxel-example",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder.",
)
@click.option("--band", help="Name of the band; default: the first of CUBE.")
@click.option("--pitch", "pitch_um", type=float, help="Side of a pixel, um; default: 15.")
@click.option("--f-number", type=float, help="Focal length over aperture; default: 2.")
@click.option("--transmission", type=float, help="Of the optics; default: 0.8.")
@click.option("--quantum-efficiency", type=float, help="Default: 0.7.")
@click.option("--full-well", type=float, help="Electrons; default: 7e6.")
@click.option("--bits", type=int, help="Of the ADC; default: 14.")
def example(cube: Path, output: Path, band: str | None, **instrument: Any) -> None:
    """Write a pipeline for CUBE and an instrument: optics, photon noise, quantum efficiency, well, ADC.

    psf.npy is the Airy pattern of the f-number, the pixels and the band: make the example anew if they change.
    """
    from hcss_pyxel.example import Instrument, write_example

    given = {name: value for name, value in instrument.items() if value is not None}
    made = write_example(cube, output, band, Instrument(**given))
    click.echo(f"{made.pipeline}\n{made.kernel}")
    click.echo(
        f"  band {made.band}, {_reading(made.times_s)}, integration {made.integration_time_s:.4g} s: {made.fill}"
    )
    if made.wavelength_um is None:
        click.echo(f"  wavelength_um: black-body, because the scene cannot be computed again: {made.why_not}")
    else:
        click.echo(f"  wavelength_um: {made.wavelength_um:g}, by the scene's own spectra")
    click.echo(f"run it with: hcss-pyxel run {made.pipeline}")


def _reading(times_s: tuple[float, ...]) -> str:
    if len(times_s) == 1:
        return f"one frame, read at {times_s[0]:g} s"
    return f"{len(times_s)} frames, read at {times_s[0]:g} to {times_s[-1]:g} s"


@cli.command()
@click.argument("cube", type=click.Path(exists=True, path_type=Path))
def wavelength(cube: Path) -> None:
    """Print the mean photon wavelengths of CUBE's scene, for wavelength_um, and the errors of the other choices."""
    from hcss_pyxel.mean_wavelength import mean_wavelengths_of
    from hcss_pyxel.wavelengths import compared

    click.echo("mean wavelength in um; errors of the number of photons; radiance in W m-2 sr-1, clear sky first")
    click.echo(f"{'band':<16}{'scene':>9}{'central':>9}{'black-body':>12}{'radiance':>12}")
    for row in compared(cube, mean_wavelengths_of(cube)):
        click.echo(
            f"{row.band:<16}{row.scene_um:9.4f}{row.central_error:+9.1%}{row.black_body_error:+12.1%}"
            f"{row.radiance:12.4g}"
        )


@cli.command()
@click.argument("pipeline", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Default: result.nc beside PIPELINE.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
def run(pipeline: Path, output: Path | None, force: bool) -> None:
    """Run PIPELINE in Pyxel and write all frames: photons, electrons, volts and digital numbers."""
    from hcss_pyxel.run import run_pipeline

    output = output or pipeline.with_name("result.nc")
    if output.exists() and not force:
        raise click.ClickException(f"{output} exists; give another name with -o, or --force")
    means = run_pipeline(pipeline, output)
    click.echo(str(output))
    for name, mean in means.items():
        click.echo(f"  mean {name}: {mean:.6g}")


def main() -> None:
    """Run the command line; an expected error gives one message and exit code 1."""
    from hcss_twin.providers import HcssError

    try:
        cli(prog_name="hcss-pyxel", standalone_mode=True)
    except HcssError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(1)
