"""Options of commands that find the clouds in an image: ``hcss import``, ``match`` and ``fit``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from hcss_twin.cli.options import Number, Shared


def cloud_options(method: str, others: tuple[str, ...] = ()) -> Any:
    """Return a decorator that adds the options for cloud detection in an image.

    Parameters
    ----------
    method : str
        Default method.
    others : tuple of str
        Methods in addition to those of ``hcss import``.
    """
    options = (
        click.option("--variable", help="Variable of a NetCDF or .npz file, or band number of a GeoTIFF."),
        Shared.at,
        click.option(
            "--method",
            default=method,
            type=click.Choice([*others, "otsu", "local", "coverage", "valid"]),
            help="Cloud detection, as hcss import; auto: valid for cloud-top products, otsu for all else."
            if "auto" in others
            else "Cloud detection. otsu: threshold that splits the histogram; local: threshold of the surroundings; "
            "coverage: the cloudiest pixels up to --coverage; valid: every pixel with a value.",
        ),
        click.option(
            "--window", "window_pixels", type=click.IntRange(3, 16384), help="Window of method local, pixels."
        ),
        click.option(
            "--coverage",
            type=Number(0, 1),
            help="Cloudy fraction for method coverage" + (", or without IMAGE." if "auto" in others else "."),
        ),
        click.option(
            "--cloud-is",
            default="auto",
            type=click.Choice(["auto", "bright", "dark"]),
            help="Cloud contrast; auto: dark in temperatures and thermal radiances.",
        ),
        Shared.length(
            "--pixel-size", "pixel_size_m", help="Pixel size on the ground, for example '1 km'; overrides the file."
        ),
    )

    def add(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return add


_OF_AN_IMAGE = ("variable", "at", "method", "window_pixels", "cloud_is", "missing", "row_origin", "column_origin")
"""Options of :func:`image_options` that apply only to an image."""


def refuse_image_options(options: dict[str, Any], image: str, *more: str) -> None:
    """Raise UsageError for options that apply only with the argument ``image``."""
    refused = [name for name in (*_OF_AN_IMAGE, *more) if options[name] not in (None, "auto", "error", {})]
    if refused:
        raise click.UsageError(f"{', '.join(refused)}: applies only with {image}; leave it out")


def image_options(command: Any) -> Any:
    """Add the options for cloud detection and for the part of the image to use."""
    part = (
        click.option(
            "--missing",
            default="error",
            type=click.Choice(["error", "clear"]),
            help="Meaning of missing pixels, except with method valid.",
        ),
        click.option("--rows", type=click.IntRange(1), help="Rows to use; default: all, at most 800."),
        click.option("--columns", type=click.IntRange(1), help="Columns to use; default: all, at most 800."),
        click.option("--row-origin", type=click.IntRange(0), help="First row; default: centred."),
        click.option("--column-origin", type=click.IntRange(0), help="First column; default: centred."),
    )
    for option in reversed((cloud_options("auto", ("auto",)), *part)):
        command = option(command)
    return command


# Scenario fields named in errors of the image reader, and the corresponding options.
_OPTIONS = {
    "clouds.parameters.missing": "--missing",
    "clouds.parameters.row_origin": "--row-origin",
    "clouds.parameters.column_origin": "--column-origin",
    "clouds.coverage": "--coverage",
    "image.rows": "--rows",
    "image.columns": "--columns",
}
_WORDS = {
    "of the scene at 0 s are missing in the image": "of the part are missing",
    'allowed: another row_origin and column_origin, or missing = "clear"': "allowed: --missing clear, or a part "
    "without them by --rows, --columns, --row-origin and --column-origin",
}


@contextmanager
def worded_for_options() -> Iterator[None]:
    """Replace scenario keys in errors of the image reader by option names."""
    from hcss_twin.providers import Problem, ScenarioError

    try:
        yield
    except ScenarioError as error:
        problems = []
        for problem in error.problems:
            message = problem.message
            for words, ours in _WORDS.items():
                message = message.replace(words, ours)
            problems.append(Problem(_OPTIONS.get(problem.field, problem.field), message))
        raise ScenarioError(problems, error.origin) from error
