"""``hcss serve``: live frames in shared memory."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hcss_payload.checks import PayloadError, require_within
from hcss_twin.cli.options import Number, Shared

if TYPE_CHECKING:
    from hcss_payload.live.twin import Method
    from hcss_twin.plan.few_columns import Omission


def _include(context: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        click.echo(Path(__file__).parents[1] / "include")
        context.exit()


@click.command()
@Shared.scenario
@Shared.changes
@click.option("--start", "start_s", type=Number(), help="First time of poses, s; default: that of the first frame.")
@click.option("--end", "end_s", type=Number(), help="Last time of poses, s; default: that of the last frame.")
@click.option("--name", help="Of the shared memory; default: hcss-live- and the number of the process.")
@click.option("--slots", default=4, show_default=True, type=click.IntRange(4, 1024), help="Frames in the ring.")
@click.option("--threads", default=2, show_default=True, type=click.IntRange(1, 64), help="Threads that compute.")
@click.option("--fineness", default=1.4, show_default=True, help="Points of the sky per width of a pixel, 1 to 16.")
@click.option(
    "--method",
    type=click.Choice(["auto", "fast", "cube", "keyframes"]),
    default="auto",
    show_default=True,
    help="Fast frames of one layer of cloud, or the pixels of cubes, of any scene; auto: fast ones if they show it; "
    "keyframes: between those of cubes.",
)
@click.option("--margin", "margin_px", type=Number(), help="Pixels by which poses may look beside the pass (cube).")
@click.option("--rate", "rate_hz", type=Number(), help="Frames a second that you need; says what is too slow for them.")
@click.option("--highest-target", "highest_m", type=Number(), help="Altitude up to which clients may show targets, m.")
@click.option(
    "--follow",
    "folder",
    type=click.Path(exists=True, file_okay=False),
    help="Folder whose new images become the scene (keyframes).",
)
@click.option("--keyframe", "keyframe_s", type=Number(), help="Time between keyframes, s; default: by their error.")
@click.option(
    "--zmq", "endpoint", help="Sockets for commands and frames, ipc://PATH or tcp://127.0.0.1:PORT (and the next)."
)
@click.option("--outlive-parent", is_flag=True, help="Go on when the process that started this one has ended.")
@click.option(
    "--include",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_include,
    help="Print the folder of hcss_ring.h, the memory's layout for C and C++, and exit.",
)
def serve(
    scenario: str,
    assignments: tuple[str, ...],
    start_s: float | None,
    end_s: float | None,
    name: str | None,
    slots: int,
    threads: int,
    fineness: float,
    method: Method,
    margin_px: float | None,
    rate_hz: float | None,
    highest_m: float | None,
    folder: str | None,
    keyframe_s: float | None,
    endpoint: str | None,
    outlive_parent: bool,
) -> None:
    """Serve live frames of SCENARIO from poses that a client sends.

    Its sections [camera], [orbit], [attitude] and [jitter] are the camera and the nominal pass. Clients use
    hcss_payload.live.LiveClient. SIGTERM and Ctrl-C end the server, which then deletes its memory.
    """
    parent = None if outlive_parent else _parent()  # first, since it may end during the preparation
    from hcss_payload.live.folder_watch import FolderWatch
    from hcss_payload.live.gateway import Gateway, frames_endpoint_of
    from hcss_payload.live.keyframe_worker import follower_named
    from hcss_payload.live.ring import Ring
    from hcss_payload.live.scenario_pass import live_pass
    from hcss_payload.live.server import Server

    name = name or f"hcss-live-{os.getpid()}"
    Ring.require_name(name)  # before minutes of compilation
    if endpoint is not None:
        frames_endpoint_of(endpoint)
    if folder is not None and method not in ("auto", "keyframes"):
        raise PayloadError(
            f"method: '{method}' with --follow; allowed: keyframes, which show scenes that follow images"
        )
    if rate_hz is not None:
        require_within("rate", rate_hz, 1e-3, 1e6, "Hz")
    loaded = Shared.load(scenario, assignments)
    if folder is not None and follower_named(loaded) is None:
        raise PayloadError(
            "follow: no clouds of this scene follow images; allowed: a generator that does ('followed' of hcss-follow)"
        )
    chosen: Method = method if folder is None else "keyframes"
    live = live_pass(
        loaded, start_s, end_s, threads, fineness, None, highest_m, chosen, margin_px, keyframe_s=keyframe_s
    )
    for note in live.notes:
        click.echo(f"note: {note}", err=True)
    gateway = None
    try:
        gateway = None if endpoint is None else Gateway(endpoint)
        images = None if folder is None else FolderWatch(Path(folder))
        server = Server(live, name, slots, parent, gateway, images)
    except BaseException:
        if gateway is not None:
            gateway.close()
        live.close()
        raise
    bands, rows, columns = live.shape
    kind = "digital numbers" if live.has_numbers else "radiance"
    text = f"{name}: {bands} x {rows} x {columns} {kind}, times {live.start_s:g} to {live.end_s:g} s"
    if gateway is not None:
        text += f"\ncommands at {endpoint}, frames at {gateway.frames_endpoint}"
    omitted = [f"omitted: {omission.what}{_size(omission)}: {omission.why}" for omission in live.omissions]

    def ready() -> None:
        assert server.cost is not None
        click.echo("\n".join((text, f"{live.method} frames: {server.cost.of_rate(rate_hz)}", *omitted)))

    server.serve(ready)


def _size(omission: Omission) -> str:
    return "" if omission.size is None else f" ({100.0 * omission.size:.2g} % of the radiance)"


def _parent() -> int:
    """Return the process that started this one.

    Raises
    ------
    PayloadError
        If it has ended while this one was loading: the process that adopts orphans seldom belongs to their session.
        Where it does, as the first process of some containers, this end passes unnoticed.
    """
    parent = os.getppid()
    try:
        session = os.getsid(parent)
    except (PermissionError, ProcessLookupError):
        session = -1
    # The leader of a session may have been started from another one.
    if session != os.getsid(0) != os.getpid():
        raise PayloadError(
            "parent: the process that started this one has ended; allowed: one that goes on, or --outlive-parent"
        )
    return parent
