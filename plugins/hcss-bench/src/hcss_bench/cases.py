"""``hcss bench cases``: models of light on published clouds in three dimensions, beside Monte Carlo."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import click

from hcss_twin.cli.options import Existing, Output, Shared
from hcss_twin.core.errors import OptionError

ALL = "all"


@click.command()
@click.argument("names", nargs=-1, metavar="[CASE]...")
@click.option(
    "--model",
    "models",
    multiple=True,
    type=click.Choice(["columns", "slant", "source"]),
    help="Which of our models; repeat. Default: all, or none with --results.",
)
@click.option(
    "--results",
    type=Existing(),
    help="Radiance of another code: a file for one case, or a folder with CASE.nc for each.",
)
@click.option("--markdown", is_flag=True, help="Print a table in Markdown.")
@Shared.json_file
@Shared.force
def cases(
    names: tuple[str, ...],
    models: tuple[str, ...],
    results: Path | None,
    markdown: bool,
    json_file: Path | None,
    force: bool,
) -> None:
    """List the cases of the thermal benchmark in three dimensions, or score models on CASE ("all": on all).

    A case is a NetCDF file with clouds, optics, temperatures, sun and views that any code can read, and with Monte
    Carlo radiance and its noise. Scores are the bias of the mean and the rms of pixels, without the noise of Monte
    Carlo. A file of results has the variable radiance (band, view, x, y) in W m-2 sr-1 um-1, as that of the case.
    """
    light = _light()
    printed = json_file is not None and str(json_file) == "-"
    Output.require_writable([None if printed else json_file], force, "give another name", form="JSON")
    known = light.case_names()
    if not names:
        if models or results is not None:
            raise OptionError("--model and --results need a CASE; allowed: " + ", ".join([ALL, *known]))
        _list(light, known, json_file)
        return
    chosen = known if ALL in names else list(dict.fromkeys(names))
    found = list(_scores(light, chosen, models, results))
    if json_file is not None:
        Shared.write_json([each.as_dict() for each in found], None if printed else json_file, indent=1)
    if printed:
        return
    rows = light.table(found)
    if markdown:
        rows.insert(1, ["---"] * len(rows[0]))
        click.echo("\n".join(f"| {' | '.join(row)} |" for row in rows))
    else:
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            click.echo("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    click.echo(
        "\nbias of the mean / rms over pixels without the noise of Monte Carlo; sunlit bands in % of the mean", err=True
    )


def _light() -> ModuleType:
    """Return the package with the cases.

    Raises
    ------
    OptionError
        If it is not installed.
    """
    try:
        import hcss_light.cases as light
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "hcss_light":
            raise
        raise OptionError("hcss bench cases needs hcss-light: pip install ./plugins/hcss-light") from error
    return light


def _list(light: ModuleType, names: Sequence[str], json_file: Path | None) -> None:
    entries = [light.entry(light.load_case(name)) for name in names]
    if json_file is not None:
        Shared.write_json(entries, None if str(json_file) == "-" else json_file, indent=1)
        if str(json_file) == "-":
            return
    for each in entries:
        click.echo(f"{each['name']:<20} {each['summary']}")
        click.echo(f"{'':<20} {each['text']}")
    click.echo(f"files: {light.FOLDER}")


def _scores(light: ModuleType, names: Sequence[str], models: Sequence[str], results: Path | None) -> Iterator[Any]:
    if results is not None and not results.is_dir() and len(names) != 1:
        raise OptionError(f"--results: the file {results} has one case; allowed: one CASE, or a folder with CASE.nc")
    own = models or (() if results is not None else tuple(light.MODELS))
    for name in names:
        case = light.load_case(name)
        yield from light.scores(case, own)
        if results is not None:
            yield from light.scores_of_results(
                case, results / f"{name}.nc" if results.is_dir() else results, results.stem
            )
