"""``hcss evaluate``: how like a real image a simulated one is."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hcss_twin.cli.clouds import metres
from hcss_twin.cli.options import Stop, progress, require_two_files, require_writable, write_text

if TYPE_CHECKING:
    from hcss_twin.analysis.comparison.footage import Method


_METHODS = ["auto", "otsu", "local", "coverage", "valid", "truth"]
_FRAMES = re.compile(r"(\d+)(?:-(\d+))?")


def frame_numbers(_context: click.Context, _option: click.Parameter, text: str | None) -> tuple[int, ...]:
    """Read numbers of frames such as ``0-7`` or ``0,3,5``."""
    if text is None:
        return ()
    found: list[int] = []
    for part in text.split(","):
        match = _FRAMES.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if last < first:
            raise click.BadParameter(f"'{text}' given, allowed: numbers and ranges, as 0-7 or 0,3,5")
        found.extend(range(first, last + 1))
    return tuple(found)


def _side_options(command: Any) -> Any:
    """Add what is chosen for each side apart."""
    for side in ("sim", "real"):
        title = side.upper()
        for option in (
            click.option(
                f"--{side}-pixel-size",
                metavar="LENGTH",
                callback=metres,
                help=f"Side of a pixel of {title}, for example '2 km', in place of what the file tells.",
            ),
            click.option(
                f"--{side}-method",
                type=click.Choice(_METHODS),
                help=f"What is cloud in {title}, where it is not what --method says.",
            ),
            click.option(
                f"--{side}-frames",
                metavar="NUMBERS",
                callback=frame_numbers,
                help=f"Frames of {title}, if it is a cube: 0-7 or 0,3,5; default: all.",
            ),
            click.option(
                f"--{side}-band",
                help=f"Band of {title}, if it is a cube"
                + ("; default: the one that holds the wavelength of REAL." if side == "sim" else "."),
            ),
            click.option(
                f"--{side}-variable", help=f"Variable of {title} (NetCDF, .npz, cube), or number of a GeoTIFF's band."
            ),
        ):
            command = option(command)
    return command


@click.command("evaluate")
@click.argument("real", type=click.Path(exists=True, path_type=Path))
@click.argument("sim", type=click.Path(exists=True, path_type=Path))
@click.option(
    "--real-also",
    multiple=True,
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The next image of a real sequence that begins with REAL; can be given again.",
)
@_side_options
@click.option(
    "--method",
    default="auto",
    show_default=True,
    type=click.Choice(_METHODS),
    help="What is cloud. otsu, local, coverage: as of hcss import; valid: every pixel with a value; truth: a cube's "
    "own mask; auto: valid for cloud-top products, truth for a cube's variables of clouds, otsu for all else.",
)
@click.option("--coverage", type=click.FloatRange(0, 1), help="Cloudy fraction of method coverage.")
@click.option(
    "--window", "window_pixels", type=click.IntRange(3, 16384), help="Side of the surroundings of method local, pixels."
)
@click.option(
    "--cloud-is",
    default="auto",
    show_default=True,
    type=click.Choice(["auto", "bright", "dark"]),
    help="Which values are cloud; auto: dark in temperatures and thermal radiances; a cube's own mask decides.",
)
@click.option("--whole", is_flag=True, help="Compare all of both, not the central part that both have in common.")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Report to write (.html).")
@click.option(
    "--json",
    "json_file",
    type=click.Path(dir_okay=False, allow_dash=True, path_type=Path),
    help="Also write all numbers as JSON; - writes them to the screen instead of the table.",
)
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.pass_context
def evaluate_command(
    context: click.Context,
    /,
    real: Path,
    sim: Path,
    real_also: tuple[Path, ...],
    method: Method,
    whole: bool,
    output: Path | None,
    json_file: Path | None,
    force: bool,
    **options: Any,
) -> None:
    """Say how like REAL, an image or a cube, SIM is.

    Each is NetCDF (GOES ABI among them), GeoTIFF, PNG, JPEG, NumPy, or a cube, of which all frames count. Compared
    are brightness temperatures where both have them, else a common unit, else grey levels of cloud: EV, Den, DP, FD
    and the RMSE of eq 24 as printed and corrected, coverage, fractal dimensions, anisotropy, spectra, histograms and
    change over time. Nothing is resampled.
    """
    to_screen = json_file is not None and str(json_file) == "-"
    wanted = {"-o": output, "--json": None if to_screen else json_file}
    require_two_files(wanted)
    require_writable(wanted.values(), force)
    from hcss_twin.analysis.comparison.evaluate import evaluate
    from hcss_twin.analysis.comparison.footage import EvaluationChoice
    from hcss_twin.core.environment import announce_compilation
    from hcss_twin.report.evaluation_text import evaluation_text

    def choice(side: str) -> EvaluationChoice:
        chosen: Method = options[f"{side}_method"] or method
        return EvaluationChoice(
            variable=options[f"{side}_variable"],
            band=options[f"{side}_band"],
            frames=options[f"{side}_frames"],
            method=chosen,
            cloud_is=options["cloud_is"],
            # What the other side's method needs is not this one's.
            coverage=options["coverage"] if chosen == "coverage" else None,
            window_pixels=options["window_pixels"] if chosen == "local" else None,
            pixel_size_m=options[f"{side}_pixel_size"],
        )

    choices = (choice("real"), choice("sim"))
    for name, needs in (("coverage", "coverage"), ("window_pixels", "local")):
        if options[name] is not None and needs not in {each.method for each in choices}:
            raise click.UsageError(f"--{name.partition('_')[0]} goes with method {needs}, and only with it")
    shown = partial(progress, context.ensure_object(Stop), label="measuring")
    with announce_compilation(partial(click.echo, err=True)):
        found = evaluate([real, *real_also], sim, *choices, whole=whole, progress=shown)
    text = json.dumps(found.as_dict(), allow_nan=False)
    if output is not None:
        from hcss_twin.report.evaluation_page import evaluation_page
        from hcss_twin.report.page.page import write_page

        write_page(output, evaluation_page(found))
    if json_file is not None and not to_screen:
        write_text(json_file, text)
    click.echo(text if to_screen else evaluation_text(found))
    if not to_screen:
        for file in (output, json_file):
            if file is not None:
                click.echo(str(file))
