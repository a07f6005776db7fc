"""``hcss bench``: run time against error on this machine, and models of light on open cases."""

from __future__ import annotations

import time
from pathlib import Path

import click

from hcss_bench.cases import cases
from hcss_twin.cli.options import Existing, Output, Shared

_ACCURACIES = ("1e-1", "1e-2", "1e-3", "1e-4", "1e-5")


def _accuracies(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> tuple[float | str, ...]:
    if not given:
        return ()
    from pydantic_core import PydanticCustomError

    from hcss_twin.core.units import QuantityParser

    try:
        return tuple(map(QuantityParser.parse_accuracy, given))
    except PydanticCustomError as error:
        raise click.BadParameter(str(error), context, option) from error


class SceneUnlessNamed(click.Group):
    """A group whose first word may be missing: it is then the command ``scene``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put ``scene`` before what does not begin with a command or a request for help."""
        if not args or args[0] not in {*self.commands, *ctx.help_option_names}:
            args = ["scene", *args]
        return super().parse_args(ctx, args)


@click.group(cls=SceneUnlessNamed)
def bench() -> None:
    """Measure run time against error of a scene, or score models on cases in three dimensions.

    `hcss bench SCENARIO` is short for `hcss bench scene SCENARIO`.
    """


bench.add_command(cases)


@bench.command()
@click.argument("scenario", default="stratus")
@Shared.changes
@click.option(
    "--accuracy",
    "accuracies",
    multiple=True,
    metavar="ACCURACY",
    callback=_accuracies,
    help=f"As in scenarios: 1e-3, '0.1 %', '0.1 K'; repeat. Default: {', '.join(_ACCURACIES)}, and the scenario's.",
)
@click.option("--rounds", default=3, type=click.IntRange(min=1), help="Repetitions, in turn.")
@click.option("--pixels", default=24, type=click.IntRange(1, 3000), help="Random pixels that are checked.")
@click.option(
    "--every-model",
    is_flag=True,
    help="Measure all radiance models, physical with 8 streams and with streams chosen by error.",
)
@click.option(
    "--reference-level", type=click.IntRange(0), help="Numerical level of the reference; default: the finest."
)
@click.option("--folder", default=".", type=Existing(file_okay=False), help="Folder of temporary cubes.")
@Shared.json_file
@click.option("--plot", type=Output(dir_okay=False), help="Plot (.png, .svg, .pdf) of time against error.")
@Shared.force
def scene(
    scenario: str,
    assignments: tuple[str, ...],
    accuracies: tuple[float | str, ...],
    rounds: int,
    pixels: int,
    every_model: bool,
    reference_level: int | None,
    folder: Path,
    json_file: Path | None,
    plot: Path | None,
    force: bool,
) -> None:
    """Measure run time and error of SCENARIO (default: stratus) at several accuracies; `scene` may be left out.

    Errors are relative to the finest that the engine offers, whichever radiance model the scenario has. The cache is
    not used. Takes some minutes.
    """
    printed = json_file is not None and str(json_file) == "-"
    Output.require_different({"--json": None if printed else json_file, "--plot": plot})
    Output.require_writable([None if printed else json_file], force, "give another name", form="JSON")
    Output.require_writable([plot], force, "give another name", form="picture")
    if len(set(accuracies)) < len(accuracies):
        raise click.BadParameter("the same accuracy is given twice", param_hint="--accuracy")
    loaded = Shared.load(scenario, assignments)
    from hcss_bench.benchmark import bench as measure
    from hcss_bench.benchmark import bench_text_before
    from hcss_bench.text import bench_text, draw_bench

    start = time.monotonic()

    def announce(text: str) -> None:
        click.echo(f"{time.monotonic() - start:5.0f} s  {text}", err=True)

    announce(bench_text_before(loaded, accuracies or None, rounds, pixels, every_model))
    found = measure(loaded, accuracies or None, rounds, pixels, folder, announce, every_model, reference_level)
    if not printed:
        click.echo("\n\n".join(map(bench_text, found.values())))
    if json_file is not None:
        Shared.write_json({model: result.as_dict() for model, result in found.items()}, json_file, indent=1)
    if plot is not None:
        draw_bench(found, plot)
    if not printed:
        for path in (json_file, plot):
            if path is not None:
                click.echo(str(path))
