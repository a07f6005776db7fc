"""``hcss report``: one HTML file about a cube, a sweep, a posterior or a propagation."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command("report")
@click.argument(
    "source", metavar="CUBE|SWEEP|POSTERIOR|PROPAGATION", type=click.Path(exists=True, path_type=Path)
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write; default: its name with .html, beside it.",
)
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.option("--json", "as_json", is_flag=True, help="Answer in JSON.")
def report_command(source: Path, output: Path | None, force: bool, as_json: bool) -> None:
    """Write one HTML file about a cube, a sweep (its folder or dataset), a posterior or a propagation.

    It needs no network and no other files, fits a phone, and can be printed.
    """
    from hcss_twin.reporting.report import report

    written = report(source, output, replace=force)
    size = written.stat().st_size
    click.echo(
        json.dumps({"report": str(written), "bytes": size}) if as_json else f"{written}  {size / 1e6:.1f} MB"
    )
