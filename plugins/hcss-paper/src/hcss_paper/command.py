"""``hcss reproduce``: recompute the paper's tables and figures and compare them with the printed ones."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import click

from hcss_twin.cli.options import Output, Shared, Stop
from hcss_twin.providers import HcssError

EXIT_FAILED = 1


@click.command()
@click.argument("items", metavar="[ITEM]...", nargs=-1)
@click.option(
    "-o",
    "--output",
    type=Output(dir_okay=False),
    default="hcss-reproduction.html",
    show_default=True,
    help="Report to write.",
)
@click.option(
    "--json",
    "json_file",
    type=Output(dir_okay=False),
    help="File for rows, checks and verdicts as JSON, keyed by item.",
)
@click.option("--seed", default=1, show_default=True, type=click.IntRange(min=0), help="Seed of random clouds.")
@Shared.force
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
    """Recompute the HCSS paper's tables and figures and write a report.

    ITEM is table-4, figure-12, ...; default: all. The checks of an item decide its verdict: reproduced,
    reproduced with fitted inputs (listed), or not reproducible (with the reason). Exit code 1: an item could not be
    computed.
    """
    from hcss_paper.index import chosen

    try:
        selected = chosen(items)
    except HcssError as error:
        raise click.BadParameter(str(error), context, param_hint="ITEM") from error
    if only_list:
        width = max(len(item.name) for item in selected) + 2
        for item in selected:
            click.echo(f"{item.name:<{width}}{item.title}")
        return
    Output.require_different({"-o": output, "--json": json_file})
    Output.require_writable([output], force, "give another name", form="HTML")
    Output.require_writable([json_file], force, "give another name", form="JSON")
    from hcss_paper.report import reproduction_page, worst_text
    from hcss_paper.run import outcomes, totals
    from hcss_twin.core.environment import announce_compilation

    with announce_compilation(partial(click.echo, err=True)):
        stop = context.ensure_object(Stop)
        results = list(stop.progress(outcomes(selected, seed), len(selected)))
    width = max(len(item.name) for item in selected) + 2
    for outcome in results:
        click.echo(f"{outcome.item.name:<{width}}{outcome.verdict:<32}{outcome.error or worst_text(outcome)}")
    click.echo("\n".join(totals(results)))
    reproduction_page(results, seed).write(output)
    click.echo(f"{output}  {output.stat().st_size / 1e6:.1f} MB")
    if json_file is not None:
        Shared.write_json({result.item.name: result.as_dict() for result in results}, json_file, indent=1)
        click.echo(str(json_file))
    if any(outcome.result is None for outcome in results):
        sys.exit(EXIT_FAILED)
