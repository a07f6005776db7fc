"""``hcss evaluate``: metrics of a simulated and a real image, the realism test of many, the blind radiance test."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from hcss_twin.cli.options import Existing, Number, Output, Shared, Stop

if TYPE_CHECKING:
    from hcss_evaluate.comparison.footage import EvaluationChoice, Method


_METHODS = ["auto", "otsu", "local", "coverage", "valid", "truth"]
_FRAMES = re.compile(r"(\d+)(?:-(\d+))?")


def frame_numbers(_context: click.Context, _option: click.Parameter, text: str | None) -> tuple[int, ...]:
    """Parse frame numbers such as ``0-7`` or ``0,3,5``."""
    if text is None:
        return ()
    numbers: list[int] = []
    for part in text.split(","):
        match = _FRAMES.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if last < first:
            raise click.BadParameter(f"'{text}' given, allowed: numbers and ranges, such as 0-7 or 0,3,5")
        numbers.extend(range(first, last + 1))
    return tuple(numbers)


_LIMITS = re.compile(r"(\d+(?:\.\d+)?)-(\d+(?:\.\d+)?)")


Channel = tuple[float, float] | dict[str, str] | None
"""Limits in um, or keys of a band with a measured response; None: known by name."""


def channels_of(_context: click.Context, _option: click.Parameter, given: tuple[str, ...]) -> dict[str, Channel]:
    """Parse channels such as ``ir_108=9.8-11.8``, ``ir_039=response.txt`` or ``b10=table.csv:B10``."""
    found: dict[str, Channel] = {}
    for text in given:
        name, equals, value = text.partition("=")
        match = _LIMITS.fullmatch(value)
        if name and match and 2.0 < float(match[1]) < float(match[2]) < 40.0:
            found[name] = (float(match[1]), float(match[2]))
        elif name and not equals:
            found[name] = None
        elif name and not match and (response := _response_of(value)):
            found[name] = response
        else:
            raise click.BadParameter(
                f"'{text}' given, allowed: a variable, or with limits in um, such as b13=10.1-10.6, or with a file of "
                "its response, if need be with column or unit, such as b13=srf.txt, b13=srf.csv:B13 or b13=srf.txt@cm-1"
            )
    return found


def _response_of(value: str) -> dict[str, str] | None:
    """Return the keys of a band for ``FILE``, with ``:COLUMN`` and ``@UNIT``; None if there is no such file."""
    start, _, unit = value.rpartition("@")
    keys = {"unit": unit} if unit in ("um", "nm", "cm-1") else {}
    value = start if keys else value
    file, _, column = value.rpartition(":")
    if not Path(value).is_file() and column:
        value, keys = file, {**keys, "column": column}
    return {"response": str(Path(value).resolve()), **keys} if Path(value).is_file() else None


def _side_options(command: Any) -> Any:
    """Add the options that each side has separately."""
    for side in ("sim", "real"):
        title = side.upper()
        for option in (
            Shared.length(
                f"--{side}-pixel-size", help=f"Pixel size of {title}, for example '2 km'; overrides the file."
            ),
            click.option(
                f"--{side}-method", type=click.Choice(_METHODS), help=f"Cloud detection in {title}; default: --method."
            ),
            click.option(
                f"--{side}-frames",
                metavar="NUMBERS",
                callback=frame_numbers,
                help=f"Frames of {title} (cube): 0-7 or 0,3,5; default: all.",
            ),
            click.option(
                f"--{side}-band",
                help=f"Band of {title} (cube)" + ("; default: that of REAL's wavelength." if side == "sim" else "."),
            ),
            click.option(f"--{side}-variable", help=f"Variable of {title}, or band number of a GeoTIFF."),
        ):
            command = option(command)
    return command


@click.command("evaluate")
@click.argument("real", type=Existing())
@click.argument("sim", type=Existing(), required=False)
@click.option(
    "--real-also",
    multiple=True,
    type=Existing(),
    help="Next image of a real sequence that begins with REAL, or with --realism more images; repeat.",
)
@click.option("--sim-also", multiple=True, type=Existing(), help="With --realism: more simulated images; repeat.")
@_side_options
@click.option(
    "--method",
    default="auto",
    type=click.Choice(_METHODS),
    help="Cloud detection, as hcss import; truth: the cube's mask; auto: valid for cloud-top products, truth for cloud "
    "variables of a cube, otsu for all else.",
)
@click.option("--coverage", type=Number(0, 1), help="Cloudy fraction for method coverage.")
@click.option("--window", "window_pixels", type=click.IntRange(3, 16384), help="Window of method local, pixels.")
@click.option(
    "--cloud-is",
    default="auto",
    type=click.Choice(["auto", "bright", "dark"]),
    help="Cloud contrast; auto: dark in temperatures and thermal radiances.",
)
@click.option("--whole", is_flag=True, help="Compare whole images, not their common central part.")
@click.option("--realism", is_flag=True, help="Test whether classifiers can tell the images of SIM from those of REAL.")
@click.option(
    "--radiance",
    is_flag=True,
    help="Simulate clear sea and opaque clouds at place, time and view of REAL, and compare brightness temperatures.",
)
@click.option(
    "--channel",
    "channels",
    multiple=True,
    metavar="NAME[=LOW-HIGH|=FILE[:COLUMN][@UNIT]]",
    callback=channels_of,
    help="With --radiance: a variable of REAL and the limits of its channel, um, for example ir_108=9.8-11.8, or the "
    "file of its spectral response. Repeat; default: all variables with known limits.",
)
@click.option(
    "--spots", default=12, type=click.IntRange(1), help="With --radiance: most spots of clear sea, and of cloud."
)
@click.option("--paired", is_flag=True, help="With --realism: the n-th scene of SIM was made from the n-th of REAL.")
@click.option(
    "--blur", default=0.65, type=Number(0, 10), help="With --realism: standard deviation of the blur of SIM, pixels."
)
@click.option("--seed", default=0, type=click.IntRange(0), help="With --realism: seed of noise, folds and classifiers.")
@click.option("-o", "--output", type=Output(dir_okay=False), help="Report to write (.html).")
@Shared.json_file
@Shared.force
@click.pass_context
def evaluate_command(
    context: click.Context,
    /,
    real: Path,
    sim: Path | None,
    real_also: tuple[Path, ...],
    sim_also: tuple[Path, ...],
    method: Method,
    whole: bool,
    realism: bool,
    radiance: bool,
    channels: dict[str, Channel],
    spots: int,
    paired: bool,
    blur: float,
    seed: int,
    output: Path | None,
    json_file: Path | None,
    force: bool,
    **options: Any,
) -> None:
    """Compare SIM with REAL by image similarity metrics.

    Each is a cube, NetCDF (also GOES ABI), GeoTIFF, PNG, JPEG or NumPy. The metrics are those of the HCSS paper (as
    printed and corrected), coverage, fractal dimensions, anisotropy, spectra, histograms and change over time.

    With --realism, REAL and SIM are files or folders of brightness temperature with the same pixel size. Two
    classifiers learn to tell patches of SIM from patches of REAL: AUC is 0.5 if they cannot tell, 1 if they always can.
    Needs the package scikit-learn.

    With --radiance, REAL alone is given: a NetCDF file with brightness temperature of several channels, latitude,
    longitude, view_zenith and time. Clear sea and opaque clouds in it are simulated.
    """
    to_screen = json_file is not None and str(json_file) == "-"
    wanted = {"-o": output, "--json": None if to_screen else json_file}
    Output.require_different(wanted)
    Output.require_writable([output], force, "give another name", form="HTML")
    Output.require_writable([wanted["--json"]], force, "give another name", form="JSON")
    _require_options_of_one_test(context, realism, radiance)
    if (sim is None) != radiance:
        raise click.UsageError("SIM: allowed without --radiance only" if radiance else "Missing argument 'SIM'.")
    from hcss_evaluate.comparison.comparison import evaluate
    from hcss_evaluate.pages.evaluation_text import evaluation_text
    from hcss_twin.core.environment import announce_compilation

    choices = (_choice("real", method, options), _choice("sim", method, options))
    for name, needs in (("coverage", "coverage"), ("window_pixels", "local")):
        if options[name] is not None and needs not in {choice.method for choice in choices}:
            raise click.UsageError(f"--{name.partition('_')[0]}: allowed with method {needs} only")
    shown = partial(context.ensure_object(Stop).progress, label="measuring")
    if sim is None:
        _test_radiance(real, channels, spots, shown, output, json_file)
        return
    if realism:
        from hcss_evaluate.realism.files import compare_files
        from hcss_evaluate.realism.text import realism_text

        tested = compare_files(
            (real, *real_also), (sim, *sim_also), *choices, paired=paired, blur_pixels=blur, seed=seed
        )
        if output is not None:
            from hcss_evaluate.realism.page import realism_page

            realism_page(tested).write(output)
        _answer(tested.as_dict(), realism_text(tested), output, json_file)
        return
    with announce_compilation(partial(click.echo, err=True)):
        result = evaluate([real, *real_also], sim, *choices, whole=whole, progress=shown)
    if output is not None:
        from hcss_evaluate.pages.evaluation_page import evaluation_page

        evaluation_page(result).write(output)
    _answer(result.as_dict(), evaluation_text(result), output, json_file)


def _test_radiance(
    real: Path, channels: dict[str, Channel], spots: int, shown: Any, output: Path | None, json_file: Path | None
) -> None:
    from hcss_evaluate.radiance.blind import blind_test, channel_limits, half_power_limits, known_channels
    from hcss_evaluate.radiance.text import blind_page, blind_text

    limits: dict[str, tuple[float, float]] = {}
    responses: dict[str, dict[str, str]] = {}
    for name, given in (channels or known_channels(real)).items():
        if isinstance(given, dict):
            responses[name] = given
            limits[name], read_as = half_power_limits(given)
            if read_as:
                click.echo(f"{name}: {read_as}", err=True)
        else:
            limits[name] = given or channel_limits(name)
    done = blind_test(real, limits, responses, most=spots, progress=shown)
    if output is not None:
        blind_page(done).write(output)
    _answer(done.as_dict(), blind_text(done), output, json_file)


_OF_METRICS = ("method", "real_method", "sim_method", "coverage", "window_pixels", "cloud_is", "whole")
_OF_REALISM = ("sim_also", "paired", "blur", "seed")
_OF_RADIANCE = ("channels", "spots")
_OF_IMAGES = tuple(
    f"{side}_{name}" for side in ("real", "sim") for name in ("also", "pixel_size", "frames", "band", "variable")
)


def _require_options_of_one_test(context: click.Context, realism: bool, radiance: bool) -> None:
    """Raise UsageError if an option is given that the chosen test does not use."""
    if radiance and realism:
        raise click.UsageError("--radiance: allowed without --realism only")
    foreign = {"--realism": () if realism else _OF_REALISM, "--radiance": () if radiance else _OF_RADIANCE}
    chosen = "--radiance" if radiance else "--realism"
    unused = (*_OF_METRICS, *_OF_IMAGES) if radiance else _OF_METRICS if realism else ()
    for parameter in context.command.params:
        if context.get_parameter_source(parameter.name or "") is not ParameterSource.COMMANDLINE:
            continue
        for test, names in foreign.items():
            if parameter.name in names:
                raise click.UsageError(f"{parameter.opts[-1]}: allowed with {test} only")
        if parameter.name in unused:
            raise click.UsageError(f"{parameter.opts[-1]}: allowed without {chosen} only")


def _choice(side: str, method: Method, options: dict[str, Any]) -> EvaluationChoice:
    from hcss_evaluate.comparison.footage import EvaluationChoice

    chosen: Method = options[f"{side}_method"] or method
    return EvaluationChoice(
        variable=options[f"{side}_variable"],
        band=options[f"{side}_band"],
        frames=options[f"{side}_frames"],
        method=chosen,
        cloud_is=options["cloud_is"],
        # Omit options that only the other side's method needs.
        coverage=options["coverage"] if chosen == "coverage" else None,
        window_pixels=options["window_pixels"] if chosen == "local" else None,
        pixel_size_m=options[f"{side}_pixel_size"],
    )


def _answer(answer: dict[str, Any], text: str, output: Path | None, json_file: Path | None) -> None:
    """Print JSON or the text with the names of the files, and write JSON to its file."""
    if json_file is not None:
        Shared.write_json(answer, json_file)
    if str(json_file) == "-":
        return
    click.echo(text)
    for file in (output, json_file):
        if file is not None:
            click.echo(str(file))
