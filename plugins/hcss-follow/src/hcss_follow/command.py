"""``hcss follow``: a scenario whose sky is that of measured images."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from hcss_twin.cli.options import Existing, Number, Output, Shared


class _Time(click.ParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    name = "TIME"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> datetime:
        try:
            time = datetime.fromisoformat(str(value))
        except ValueError:
            self.fail(f"'{value}' is no time; allowed: for example 2020-09-06T00:15Z", param, ctx)
        return time if time.tzinfo else time.replace(tzinfo=UTC)


@click.command()
@click.argument("images", nargs=-1, required=True, metavar="IMAGE...")
@click.option("-o", "--output", required=True, type=Output(dir_okay=False), help="Scenario (.toml).")
@click.option("--second", metavar="IMAGE", help="Near 12.0 um at the latest time: heights of thin clouds.")
@click.option(
    "--time", "times", multiple=True, type=_Time(), help="Of each image in order; default: those of the files."
)
@click.option("--start", type=_Time(), help="Start of the scenario; default: the latest image's time.")
@Shared.at
@click.option("--place", type=float, nargs=2, metavar="LAT LON", help="Of the middle; default: that of the file.")
@click.option("--satellite", type=Number(-180.0, 360.0), metavar="LON", help="Longitude of a geostationary satellite.")
@Shared.length("--pixel-size", "pixel_size_m", help="Pixel size on the ground, for example '3 km'; overrides the file.")
@click.option(
    "--margin",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Pixels around the scene, from where clouds move in.",
)
@click.option(
    "--response",
    "responses",
    multiple=True,
    type=Existing(dir_okay=False),
    help="Spectral response (CSV) of "
    "the first image's band, of the second's, and of further bands to simulate; default: lwir-10.8, lwir-12.0.",
)
@click.option("--member", type=click.IntRange(0, 2**32 - 1), help="Of the ensemble; default: the mean forecast.")
@click.option("--page", type=Output(dir_okay=False), help="HTML page: image, twin's image, difference, uncertainty.")
@Shared.force
def follow(
    images: tuple[str, ...],
    output: Path,
    second: str | None,
    times: tuple[datetime, ...],
    start: datetime | None,
    at: dict[str, int],
    place: tuple[float, float] | None,
    satellite: float | None,
    pixel_size_m: float | None,
    margin: int,
    responses: tuple[Path, ...],
    member: int | None,
    page: Path | None,
    force: bool,
) -> None:
    """Make a scenario whose sky is that of IMAGE..., brightness temperature near 10.8 um at one or more times.

    An IMAGE is FILE or FILE:VARIABLE. Two or more, some minutes apart, give motion and change. Beside the scenario a
    state file (.nc) is written. The scenario is one for hcss plan and run.
    """
    from hcss_follow.analysis import analyse, doubts
    from hcss_follow.images import read_images
    from hcss_follow.scenario import scenario_of, toml_of
    from hcss_twin.core.files import Writing
    from hcss_twin.providers import CatalogError

    state_path = output.with_suffix(".state.nc")  # `hcss run` writes the cube to .nc
    Output.require_writable([output], force, form="TOML")
    Output.require_writable([state_path], force, form="NetCDF")
    if page is not None:
        Output.require_writable([page], force, form="HTML")
    read = read_images(images, times, second, at, place, pixel_size_m)
    state = analyse(
        read.images, pixel_size_m=read.pixel_size_m, latitude=read.latitude, longitude=read.longitude,
        source=read.source, rights=read.rights,
    )  # fmt: skip
    lead_s = 0.0 if start is None else (start - state.time).total_seconds()
    if not 0.0 <= lead_s <= 21600.0:
        raise CatalogError(
            f"--start: {lead_s:g} s after the latest image, {state.time.isoformat()}; allowed: 0 to 21600"
        )
    made = scenario_of(
        state, read.images[-1], state_name=state_path.name, lead_s=lead_s, satellite_longitude=satellite,
        margin=margin, responses=[path.resolve() for path in responses], member=member,
    )  # fmt: skip
    state.write(state_path)
    with Writing(output, CatalogError, "TOML") as draft:
        draft.write_text(toml_of(made.scenario), encoding="utf-8")
    rows, columns = state.shape
    click.echo(
        f"{output}: {rows} x {columns} pixels of {state.pixel_size_m:g} m at {state.time.isoformat()}, "
        f"{len(images)} images, state {state_path.name}"
    )
    for line in made.lines:
        click.echo(line)
    for note in (*read.notes, *doubts(state), *made.notes):
        click.echo(f"note: {note}", err=True)
    if page is not None:
        from hcss_follow.page import write_page

        write_page(page, output, state, read.images[-1], made)
        click.echo(f"{page}: image, twin's image, and their difference")
