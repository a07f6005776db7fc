"""``hcss reproduce``: the paper's tables and figures, computed again and laid beside what is printed."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

import click

from hcss_twin.cli.options import Stop, progress, require_writable, write_text
from hcss_twin.core.errors import HcssError

EXIT_FAILED = 1


@click.command()
@click.argument("items", metavar="[ITEM]...", nargs=-1)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    default="hcss-reproduction.html",
    show_default=True,
    help="Report to write.",
)
@click.option(
    "--json",
    "json_file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Also write rows, checks and verdicts as JSON, keyed by item.",
)
@click.option("--seed", default=1, show_default=True, type=click.IntRange(min=0), help="Of random clouds.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.option("--list", "only_list", is_flag=True, help="List the items and compute nothing.")
@click.pass_context
def reproduce(
    context: click.Context,
    items: tuple[str, ...],
    output: Path,
    json_file: Path | None,
    seed: int,
    force: bool,
    only_list: bool,
) -> None:
    """Compute the HCSS paper's tables and figures again and write a report.

    ITEM is table-4, figure-12, ...; all by default. Each gets a verdict that follows from its checks: reproduced,
    reproduced with fitted inputs (listed), or not reproducible (and why). Exit code 1 if an item could not be computed.
    """
    from hcss_twin.paper.index import chosen

    try:
        wanted = chosen(items)
    except HcssError as error:
        raise click.BadParameter(str(error), context, param_hint="ITEM") from error
    if only_list:
        width = max(len(item.name) for item in wanted) + 2
        for item in wanted:
            click.echo(f"{item.name:<{width}}{item.title}")
        return
    require_writable((output, json_file), force)
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.paper.report import reproduction_page, worst_text
    from hcss_twin.paper.run import outcomes
    from hcss_twin.report.page.page import write_page

    with announce_compilation(partial(click.echo, err=True)):
        stop = context.ensure_object(Stop)
        found = list(progress(stop, outcomes(wanted, seed), len(wanted)))
    width = max(len(item.name) for item in wanted) + 2
    for outcome in found:
        told = outcome.error or worst_text(outcome)
        click.echo(f"{outcome.item.name:<{width}}{outcome.verdict:<32}{told}")
    write_page(output, reproduction_page(found, seed))
    click.echo(f"{output}  {output.stat().st_size / 1e6:.1f} MB")
    if json_file is not None:
        write_text(json_file, json.dumps({each.item.name: each.as_dict() for each in found}, indent=1))
        click.echo(str(json_file))
    if any(outcome.found is None for outcome in found):
        sys.exit(EXIT_FAILED)
