"""``hcss explore``: a page on this machine."""

from __future__ import annotations

import webbrowser

import click

from hcss_twin.cli.options import Shared


@click.command()
@click.argument("scenario", default="stratus")
@Shared.changes
@click.option("--port", default=0, type=click.IntRange(0, 65535), help="Port of 127.0.0.1; 0: any free one.")
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
def explore(scenario: str, assignments: tuple[str, ...], port: int, no_browser: bool) -> None:
    """Explore SCENARIO (default: stratus) on a page in the browser, until Ctrl-C.

    The page answers on this machine only, to who knows the address. It writes nothing but the scenarios that you save.
    """
    from hcss_explore.explorer import Explorer
    from hcss_explore.server import Server

    Shared.load(scenario, assignments)  # prints its notes
    explorer = Explorer(scenario, Shared.assigned(assignments))
    try:
        server = Server(explorer, port)
    except OSError as error:
        raise click.ClickException(f"--port: {port} given: {error}; allowed: a free port, or 0") from error
    with server:
        click.echo(f"exploring {scenario} at {server.address}\nCtrl-C ends it")
        if not no_browser and not webbrowser.open(server.address):
            click.echo("no browser was found: open the address in one of this machine", err=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            click.echo("ended")
