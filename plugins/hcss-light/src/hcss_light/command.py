"""``hcss reference``: random pixels of a scene beside Monte Carlo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from hcss_twin.cli.options import Output, Shared


@click.command()
@Shared.scenario
@Shared.changes
@click.option("--pixels", default=16, type=click.IntRange(1, 10_000), help="Random pixels.")
@click.option("--photons", default=20_000, type=click.IntRange(1000), help="For each pixel and band.")
@click.option("--frame", default=0, type=click.IntRange(0), help="Number of the frame, from 0.")
@click.option("--seed", default=0, type=click.IntRange(0), help="Of pixels and photons.")
@click.option(
    "--cube",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Write the result next to the certificate of this cube of SCENARIO, as its attribute hcss_monte_carlo.",
)
@Shared.json_file
@Shared.force
def reference(
    scenario: str,
    assignments: tuple[str, ...],
    pixels: int,
    photons: int,
    frame: int,
    seed: int,
    cube: Path | None,
    json_file: Path | None,
    force: bool,
) -> None:
    """Compare random pixels of SCENARIO with Monte Carlo radiance of clouds with sides.

    The pixels are computed as in the cube, and as independent columns. Monte Carlo knows the same clouds, their
    particles and gas at the weighted wavenumbers of the radiance tables; the sea below emits and does not reflect.
    """
    from hcss_light.comparison import compare, write_to_cube

    printed = json_file is not None and str(json_file) == "-"
    Output.require_writable([None if printed else json_file], force, form="JSON")
    given = Shared.load(scenario, assignments)
    result = compare(given, pixels, photons, frame, seed)
    if cube is not None:
        write_to_cube(cube, given, result)
    if printed:
        Shared.write_json(result, indent=1)
        return
    for band in result["bands"]:
        click.echo(_line(band))
    click.echo(
        f"{pixels} pixels, {photons} photons each; bias and rms relative to the mean, noise of Monte Carlo removed"
    )
    if json_file is not None:
        Shared.write_json(result, json_file, indent=1)


def _line(band: dict[str, Any]) -> str:
    parts = [f"{band['name']}: Monte Carlo {np.mean(band['monte_carlo']):.5g} W m-2 sr-1"]
    for name in ("cube", "columns"):
        error = band["errors"][name]
        kelvin = "" if error["bias_K"] is None else f" ({error['bias_K']:+.2f}, {error['rms_K']:.2f} K)"
        bias = f"{100.0 * error['bias']:+.2f} +- {100.0 * band['noise']:.2f} %"
        parts.append(f"{name} {bias}, rms {100.0 * error['rms']:.2f} %{kelvin}")
    return "; ".join(parts)
