"""``hcss passes``: when a camera in orbit sees a place."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta

import click

from hcss_twin.cli.options import Number, Shared


@click.command()
@Shared.scenario
@Shared.changes
@click.option(
    "--days", default=1.0, show_default=True, type=Number(min=0.0, max=366.0), help="From the first frame on."
)
@click.option(
    "--lowest",
    default=15.0,
    show_default=True,
    type=Number(min=0.0, max=90.0),
    help="Elevation that passes exceed, deg; cameras see the ground from 15 deg on, with the limb from 5 deg on.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def passes(scenario: str, assignments: tuple[str, ...], days: float, lowest: float, as_json: bool) -> None:
    """List the passes of the camera of SCENARIO above its [place].

    Elevations are geometric, without refraction, seen from the ellipsoid. The time of a pass goes into the key `time`,
    or a little less, so that the frames are around it.
    """
    from hcss_payload.build import trajectory_of
    from hcss_payload.passes import find_passes
    from hcss_payload.sections import OrbitSection
    from hcss_payload.trajectory import Circular
    from hcss_twin.providers import Catalog

    loaded = Shared.load(scenario, assignments)
    trajectory = trajectory_of(loaded, Catalog(base=loaded.base))
    place, start = (loaded.place.latitude, loaded.place.longitude), loaded.time.astimezone(UTC)
    first = loaded.frames.first * loaded.frames.interval
    found = find_passes(trajectory, place, start, first, first + 86400.0 * days, lowest)
    orbit = loaded.sections["orbit"]
    if isinstance(orbit, OrbitSection) and isinstance(trajectory, Circular) and orbit.epoch is None:
        click.echo(
            f"note: the orbit counts from `time`; keep it with orbit.epoch = {start.isoformat()} when you set another",
            err=True,
        )
    if isinstance(trajectory, Circular) and not trajectory.precesses:
        click.echo("note: 'circular' has no precession; the planes of low orbits turn by up to 8 deg a day", err=True)

    def when(time_s: float | None) -> str | None:
        if time_s is None:
            return None
        time: datetime = start + timedelta(seconds=time_s)
        return time.isoformat(timespec="milliseconds").replace("+00:00", "Z")

    rows = [
        {
            "rise": when(one.rise_s),
            "highest": when(one.highest_s),
            "set": when(one.set_s),
            "elevation_deg": round(one.highest_deg, 3),
            "azimuth_deg": round(one.azimuth_deg, 3),
            "sun_elevation_deg": round(one.sun_deg, 3),
        }
        for one in found
    ]
    if as_json:
        click.echo(json.dumps({"latitude": place[0], "longitude": place[1], "passes": rows}, indent=1))
        return
    click.echo(f"{len(rows)} passes above {lowest:g} deg at {place[0]:g} N {place[1]:g} E in {days:g} days, UTC")
    if rows:
        click.echo("rise                  highest               set                   elevation  azimuth  sun")
    for row in rows:
        times = "  ".join(f"{_seconds(row[key]):20}" for key in ("rise", "highest", "set"))
        angles = f"{row['elevation_deg']:9.1f}  {row['azimuth_deg']:7.1f}  {row['sun_elevation_deg']:5.1f}"
        click.echo(f"{times}  {angles}")


def _seconds(time: object) -> str:
    return "-" if time is None else f"{str(time)[:19]}Z"  # a time of a scenario, as it stands
