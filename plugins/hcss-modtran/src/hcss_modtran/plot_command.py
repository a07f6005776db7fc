"""``hcss atmosphere plot``: one or two atmospheres become a picture and, if two, a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.options import Number, Output, Shared


@click.command("plot")
@click.argument("sources", nargs=-1, required=True, metavar="PROVIDER_OR_TABLE...")
@click.option("-o", "--output", required=True, type=Output(dir_okay=False), help="Picture to write (.png).")
@click.option("--profile", default="us-standard-1976", help="Atmosphere of the providers.")
@click.option("--zenith", multiple=True, type=Number(0, 90, max_open=True), help="Angle in deg; repeat.")
@click.option("--height", multiple=True, type=Number(min=0), help="Target height in m; repeat.")
@click.option("--range-um", nargs=2, type=Number(0.1, 1000), default=(2.5, 14.3), help="Range, um; default: 2.5 14.3.")
@Shared.force
@Shared.json
def atmosphere_plot(
    sources: tuple[str, ...],
    output: Path,
    profile: str,
    zenith: tuple[float, ...],
    height: tuple[float, ...],
    range_um: tuple[float, float],
    force: bool,
    as_json: bool,
) -> None:
    """Draw transmittance and path radiance of one or two providers or tables; two are compared.

    The JSON has mean transmittance and path radiance (W m-2 sr-1) of the bands 2.7-3.0, 3-5 and 8-14 um by angle.
    """
    from hcss_modtran import plot

    Output.require_writable([output], force, form="picture")
    if len(sources) > 2:
        raise click.UsageError(f"{len(sources)} sources; allowed: one to plot, or two to compare")
    spectra = plot.sample(
        [plot.open_source(name, profile) for name in sources],
        zenith or plot.ZENITHS_DEG,
        height or plot.HEIGHTS_M,
        range_um,
    )
    plot.draw(spectra, output)
    lines = plot.compare(spectra[0], spectra[1]) if len(spectra) == 2 else []
    if as_json:
        found = {
            spectrum.label: {"zenith_deg": spectrum.zenith_deg.tolist(), "bands": _bands(spectrum)}
            for spectrum in spectra
        }
        Shared.write_json({"picture": str(output), "sources": found, "comparison": lines})
    else:
        click.echo("\n".join([*lines, str(output)]))


def _bands(spectra: Any) -> list[dict[str, Any]]:
    from hcss_modtran import plot

    means = [(band, plot.band_means(spectra, band)) for band in plot.BANDS_UM]
    return [
        {"limits_um": band, "transmittance": mean[0].tolist(), "path_radiance": mean[1].tolist()}
        for band, mean in means
        if mean is not None  # the spectrum does not cover the band
    ]
