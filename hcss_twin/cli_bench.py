"""``hcss bench``: run time against error on this machine."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import click

from hcss_twin.cli_scenario import load, set_option

_ACCURACIES = ("1e-1", "1e-2", "1e-3", "1e-4", "1e-5")
_PICTURES = (".png", ".svg", ".pdf")


@click.command()
@click.argument("scenario", default="stratus")
@set_option
@click.option(
    "--accuracy",
    "accuracies",
    multiple=True,
    type=click.FloatRange(1e-6, 0.1),
    default=[float(each) for each in _ACCURACIES],
    help=f"Of the tables; repeat. Default: {', '.join(_ACCURACIES)}.",
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
    "--plot",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Picture (.png, .svg, .pdf) of time against error.",
)
@click.option("--force", is_flag=True, help="Replace existing files.")
def bench(
    scenario: str,
    assignments: tuple[str, ...],
    accuracies: tuple[float, ...],
    rounds: int,
    pixels: int,
    folder: Path,
    json_file: Path | None,
    plot: Path | None,
    force: bool,
) -> None:
    """Time SCENARIO (default: stratus) at several accuracies, and measure its error.

    Each stage, the whole run, writing the same bytes raw and integrating every pixel by itself take turns, so that
    ratios hold also where others use the machine. Nothing kept from earlier runs is used. Takes a minute or two.
    """
    printed = json_file is not None and str(json_file) == "-"
    _refuse([None if printed else json_file, plot], force)
    if plot is not None and plot.suffix not in _PICTURES:
        raise click.BadParameter(f"{plot} must end in one of {', '.join(_PICTURES)}", param_hint="--plot")
    if len(set(accuracies)) < len(accuracies):
        raise click.BadParameter("the same accuracy is given twice", param_hint="--accuracy")
    loaded = load(scenario, assignments)
    from hcss_twin.benchmarking.bench import bench as measure
    from hcss_twin.reporting.bench_text import bench_text

    found = measure(loaded, accuracies, rounds, pixels, folder, _tell)
    text = json.dumps(found.as_dict(), indent=1)
    click.echo(text if printed else bench_text(found))
    if json_file is not None and not printed:
        _write(json_file, text)
    if plot is not None:
        from hcss_twin.reporting.pareto_plot import draw_bench

        draw_bench(found, plot)
    if not printed:
        for path in (json_file, plot):
            if path is not None:
                click.echo(str(path))


def _tell(text: str) -> None:
    if sys.stderr.isatty():
        click.echo(text, err=True)


def _refuse(paths: list[Path | None], force: bool) -> None:
    """Find out before measuring what would go wrong after."""
    for path in paths:
        if path is None:
            continue
        if path.exists() and not force:
            raise click.ClickException(f"{path} exists; give another name, or --force")
        if not path.absolute().parent.is_dir():
            raise click.ClickException(f"cannot write {path}: there is no folder {path.parent}")


def _write(path: Path, text: str) -> None:
    from hcss_twin.drafts import draft_of
    from hcss_twin.errors import HcssError

    with draft_of(path, HcssError) as draft:
        draft.write_text(text + "\n", encoding="utf-8")
