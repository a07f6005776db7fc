"""``hcss bench``: run time against error on this machine."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path

import click

from hcss_twin.cli.options import load, require_writable, set_option, write_text

_ACCURACIES = ("1e-1", "1e-2", "1e-3", "1e-4", "1e-5")
_PICTURES = (".png", ".svg", ".pdf")


def _accuracies(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> tuple[float | str, ...]:
    """Read accuracies as scenarios have them."""
    if not given:
        return ()
    from pydantic_core import PydanticCustomError

    from hcss_twin.scenario.units import parse_accuracy

    try:
        return tuple(map(parse_accuracy, given))
    except PydanticCustomError as error:
        raise click.BadParameter(str(error), context, option) from error


@click.command()
@click.argument("scenario", default="stratus")
@set_option
@click.option(
    "--accuracy",
    "accuracies",
    multiple=True,
    metavar="ACCURACY",
    callback=_accuracies,
    help="As in scenarios, such as 1e-3, '0.1 %' or '0.1 K'; repeat. Default: "
    f"{', '.join(_ACCURACIES)}, and the scenario's own.",
)
@click.option(
    "--rounds",
    default=3,
    show_default=True,
    type=click.IntRange(min=1),
    help="Times that everything is run, in turn; tables are compiled in the first only.",
)
@click.option(
    "--pixels",
    default=24,
    show_default=True,
    type=click.IntRange(1, 3000),
    help="Random pixels whose error is measured at each accuracy.",
)
@click.option(
    "--folder",
    default=".",
    show_default=True,
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Where cubes are written for a moment.",
)
@click.option(
    "--json",
    "json_file",
    type=click.Path(dir_okay=False, allow_dash=True, path_type=Path),
    help="File for the results; - prints them in place of the table.",
)
@click.option(
    "--plot", type=click.Path(dir_okay=False, path_type=Path), help="Picture (.png, .svg, .pdf) of time against error."
)
@click.option("--force", is_flag=True, help="Replace existing files.")
def bench(
    scenario: str,
    assignments: tuple[str, ...],
    accuracies: tuple[float | str, ...],
    rounds: int,
    pixels: int,
    folder: Path,
    json_file: Path | None,
    plot: Path | None,
    force: bool,
) -> None:
    """Time SCENARIO (default: stratus) at several accuracies, and measure its error.

    Each stage, the whole run, writing the same bytes raw and integrating every pixel by itself take turns, so that
    ratios hold also where others use the machine. Nothing kept from earlier runs is used. Takes a minute or two, and
    says on stderr what it is doing.
    """
    printed = json_file is not None and str(json_file) == "-"
    require_writable([None if printed else json_file, plot], force)
    if plot is not None and plot.suffix not in _PICTURES:
        raise click.BadParameter(f"{plot} must end in one of {', '.join(_PICTURES)}", param_hint="--plot")
    if len(set(accuracies)) < len(accuracies):
        raise click.BadParameter("the same accuracy is given twice", param_hint="--accuracy")
    loaded = load(scenario, assignments)
    from hcss_twin.report.benchmark_text import bench_text
    from hcss_twin.report.benchmarking.bench import bench as measure

    found = measure(loaded, accuracies or None, rounds, pixels, folder, _teller())
    text = json.dumps(found.as_dict(), indent=1)
    click.echo(text if printed else bench_text(found))
    if json_file is not None and not printed:
        write_text(json_file, text)
    if plot is not None:
        from hcss_twin.report.benchmark_text import draw_bench

        draw_bench(found, plot)
    if not printed:
        for path in (json_file, plot):
            if path is not None:
                click.echo(str(path))


def _teller() -> Callable[[str], None]:
    """Tell what comes next, with the time since the start."""
    start = time.monotonic()

    def tell(text: str) -> None:
        click.echo(f"{time.monotonic() - start:5.0f} s  {text}", err=True)

    return tell
